"""Faults in specs: rules, tests, assumptions, parameters, signals, constraints, and what they are called."""

from __future__ import annotations

from support.planted.edits import Fault, add, agreed, all_of, cut, each, gone, put, remade, swap

S, C, B, N = "specs/rules.spec", "specs/vehicle.spec", "specs/order.spec", "specs/signals.spec"
#: A test that says by a name how fast it is.
BY_NAME = '\ntest speed_limit "faster"\n  given  plan = line(v: much)\n  expect violated\n'
_DEFINED = agreed(add(S, f"\ndefine much = 13 m/s\n{BY_NAME}"))
# fmt: off
FAULTS = [
    Fault("a use of signals struck", swap(S, "use signals\n", ""), "E201", "free_ahead"),
    Fault("a use of values struck", swap(S, "use vehicle\n", ""), "E201", "free_ahead"),
    # rules
    Fault("a rule taken away with its tests", all_of(cut(S, "rule braking", "rule keeps_clear"), cut(S, 'test braking "as hard', "test keeps_clear"), swap(B, " > braking", "")), "T222", "braking"),
    Fault("a rule taken away", cut(S, "rule braking", "rule keeps_clear"), "T222", "braking"),
    Fault("a rule under another name", all_of(each(S, "braking", "brake"), swap(B, "braking", "brake")), "T222", "braking"),
    Fault("a rule made weaker by a where", swap(S, "  for all   p in plan\n  require   p.v <= v_max", "  for all   p in plan where p.v <= 13 m/s\n  require   p.v <= v_max"), "T370", "speed_limit"),
    Fault("a rule that is never asked", swap(S, "  for all   p in plan\n  require   p.v <= v_max", "  whenever  ego.v > 100 m/s\n  for all   p in plan\n  require   p.v <= v_max"), "T370", "speed_limit"),
    Fault("a comparison turned round", swap(S, "require   p.v <= v_max", "require   p.v >= v_max"), "T370", "speed_limit"),
    Fault("a strict comparison", swap(S, "require   p.v <= v_max", "require   p.v < v_max"), "T370", "speed_limit"),
    Fault("a tolerance in a rule", swap(S, "require   p.v <= v_max", "require   p.v <= v_max + 0.1 m/s"), "T370", "speed_limit"),
    Fault("a rule that is always so", swap(S, "require   p.v <= v_max", "require   p.v <= v_max or p.v > v_max"), "T370", "speed_limit"),
    Fault("a definition changed", swap(S, "o.length / 2 - length / 2", "o.length / 2"), "T370", "keeps_clear"),
    Fault("a rule that only advises", swap(S, "  satisfies S-1\n", "  satisfies S-1\n  severity  advisory\n"), "T219", "S-1"),
    Fault("a rule of less weight", swap(S, "  satisfies S-2\n", "  satisfies S-2\n  severity  minor\n"), "T370", "braking"),
    Fault("a rule that satisfies nothing", swap(S, "  satisfies S-2\n", ""), "T206", "braking"),
    Fault("a rule that satisfies something else", swap(S, "  satisfies S-2\n", "  satisfies S-1\n"), "T206", "braking"),
    Fault("a rule that satisfies what there is not", swap(S, "  satisfies S-2\n", "  satisfies S-22\n"), "T201", "braking"),
    Fault("a rule that satisfies what is demanded no longer", swap(S, "  satisfies S-2\n", "  satisfies S-2, S-9\n"), "T203", "braking"),
    Fault("a rule that satisfies something twice", swap(S, "  satisfies S-2\n", "  satisfies S-2, S-2\n"), "T210", "braking"),
    Fault("two rules with one name", add(S, '\nrule braking "Again"\n  satisfies S-2\n  for all   p in plan\n  require   p.v <= v_max\n'), "E202", "braking"),
    Fault("a rule without a requirement", add(S, '\nrule reverse "Not backwards"\n  for all   p in plan\n  require   p.v >= 0 m/s\n'), "T202", "reverse"),
    Fault("a rule without a test", add(S, '\nrule reverse "Not backwards"\n  satisfies S-1\n  for all   p in plan\n  require   p.v >= 0 m/s\n'), "T211", "reverse"),
    Fault("an equation that the concept does not have", swap(S, "source    concept eq 2, 3", "source    concept eq 2, 99"), "T170", "braking"),
    Fault("a work that nobody knows", swap(S, "source    concept eq 2, 3", "source    paper eq 2, 3"), "E219", "braking"),
    # assumptions
    Fault("a monitor taken away", all_of(swap(S, "  for all   o in objects\n  monitor   o.age <= oldest\n", ""), cut(S, 'test A-SEEN "as old', 'test speed_limit "at')), "T208", "A-SEEN"),
    Fault("a monitor made weaker", swap(S, "monitor   o.age <= oldest", "monitor   o.age <= 2 * oldest"), "T370", "A-SEEN"),
    Fault("an assumption of nobody", swap(S, '  owner     "Ola Observer"\n', ""), "T208", "A-SEEN"),
    Fault("an assumption of somebody unknown", swap(S, '"Ola Observer"', '"x"'), "T153", "A-SEEN"),
    Fault("an assumption without evidence", swap(S, '  evidence  "docs/sensors.md"\n', ""), "T208", "A-SEEN"),
    Fault("an assumption whose evidence is not there", swap(S, '"docs/sensors.md"', '"docs/sensor.md"'), "T252", "A-SEEN"),
    Fault("an assumption taken away", all_of(cut(S, "assume A-SEEN", "rule speed_limit"), swap(S, "  assuming  A-SEEN\n", ""), cut(S, 'test A-SEEN "as old', 'test speed_limit "at')), "D256", status=2),
    Fault("an assumption that there is not", swap(S, "assuming  A-SEEN", "assuming  A-SENSE"), "E219", "keeps_clear"),
    Fault("an assumption no longer said", swap(S, "  assuming  A-SEEN\n", ""), "T370", "keeps_clear"),
    # tests
    Fault("a test taken away", cut(S, 'test speed_limit "below', 'test speed_limit "too'), "T221", "speed_limit"),
    Fault("the test on the boundary taken away", cut(S, 'test speed_limit "at', 'test speed_limit "below'), "T221", "speed_limit"),
    Fault("all tests of a rule taken away", cut(S, 'test braking "as hard', "test keeps_clear"), "T221", "braking"),
    Fault("a test emptied under its title", swap(S, 'test keeps_clear "too close"\n  given  ego = { x: 0 m, v: 6 m/s }\n  given  objects = [{ x: 12 m, length: 5 m }]\n  expect violated, margin -1 m', 'test keeps_clear "too close"\n  given  ego = { x: 0 m, v: 6 m/s }\n  given  objects = [{ x: 6 m, length: 5 m }]\n  expect violated'), "T374", "keeps_clear"),
    Fault("a test that no longer says how much", swap(S, "expect violated, margin -1 m/s^2", "expect violated"), "T374", "braking"),
    Fault("a test that expects the contrary", swap(S, "expect violated, margin -1 m/s^2", "expect satisfied"), "T374", "braking"),
    Fault("a test that sets its own limit", swap(S, 'test speed_limit "below the limit"\n', 'test speed_limit "below the limit"\n  given  v_max = 20 m/s\n'), "T374", "speed_limit"),
    Fault("a boundary within a million", swap(S, "  given  plan = line(v: 12 m/s)\n  expect satisfied, margin 0 m/s", "  given  plan = line(v: 12 m/s)\n  expect satisfied, margin about 0 m/s within 1000000 m/s"), "T374", "speed_limit"),
    Fault("another speed by the name that a test gives", all_of(_DEFINED, swap(S, "define much = 13 m/s", "define much = 12.5 m/s")), "T374", "speed_limit"),
    Fault("another speed by the name that a test gives, and another title of the test", all_of(_DEFINED, swap(S, "define much = 13 m/s", "define much = 12.5 m/s"), swap(S, '"faster"', '"quicker"')), "T221", "speed_limit"),
    Fault("a definition of the same name in place of the one that a test gives", all_of(put("specs/much.spec", b"module much\n\ndefine a = 13 m/s\ndefine b = 12.5 m/s\n"), agreed(all_of(swap(S, "use vehicle\n", "use vehicle\nuse much\n"), add(S, BY_NAME.replace("much", "a")))), each("specs/much.spec", "define a = 13", "define c = 13"), each("specs/much.spec", "define b", "define a")), "T374", "speed_limit"),
    Fault("a parameter that tests alone read", all_of(agreed(all_of(add(C, '\nparam much : m/s = 13 m/s in [1, 20]\n'), add(S, BY_NAME))), swap(C, "much : m/s = 13 m/s", "much : m/s = 12.5 m/s")), "T372", "vehicle.much"),
    Fault("a speed of a test with other units", swap(S, "given  plan = line(v: 9 m/s)\n  expect satisfied, margin 3 m/s", "given  plan = line(v: 9 km/h)\n  expect satisfied, margin 9.5 m/s"), "T374", "speed_limit"),
    Fault("values of a test under each other's names", swap(S, "given  objects = [{ x: 60 m, length: 5 m }]", "given  objects = [{ length: 6 m, x: 60 m }]"), "T374", "keeps_clear"),
    Fault("another sample of a test", swap(S, "with v[3] = 13 m/s\n  expect violated, margin -1 m/s, at p = 3", "with v[2] = 13 m/s\n  expect violated, margin -1 m/s, at p = 2"), "T374", "speed_limit"),
    Fault("a test that no longer says where", swap(S, ", at p = 3", ""), "T374", "speed_limit"),
    Fault("two tests with one title", add(S, '\ntest braking "harder"\n  given  plan = { v: [5 m/s, 4 m/s], a: [-8 m/s^2, 0 m/s^2] }\n  expect violated\n'), "E421"),
    Fault("a test that fails", add(S, '\ntest braking "soft"\n  given  plan = { v: [5 m/s, 4 m/s], a: [-2 m/s^2, 0 m/s^2] }\n  expect violated\n'), "T215", "braking"),
    Fault("a test of what there is not", add(S, '\ntest brakes "soft"\n  given  plan = { v: [5 m/s, 4 m/s], a: [-2 m/s^2, 0 m/s^2] }\n  expect satisfied\n'), "E219"),
    # parameters, tables, signals, constraints
    Fault("a threshold moved by 1 %", swap(C, "v_max      : m/s   = 12 m/s ", "v_max      : m/s   = 12.12 m/s "), "T372", "vehicle.v_max"),
    Fault("a threshold of an assumption moved", swap(C, "200 ms", "250 ms"), "T372", "vehicle.oldest"),
    Fault("a range widened", swap(C, "in [1, 20]", "in [1, 40]"), "T372", "vehicle.v_max"),
    Fault("a length of the vehicle", swap(C, "= 5 m        in", "= 4.9 m      in"), "T372", "vehicle.length"),
    Fault("a table changed", swap(C, "20 m/s: 5 m/s^2", "20 m/s: 5.5 m/s^2"), "T372", "vehicle.bite"),
    Fault("a table that goes on otherwise", swap(C, "linear clamp", "step clamp"), "T372", "vehicle.bite"),
    Fault("a constraint changed", swap(C, "constrain b_comfort <= b_max", "constrain b_comfort <= 2 * b_max"), "T372", "b_comfort <= b_max"),
    Fault("a constraint taken away", cut(C, "constrain b_comfort", "-- How hard"), "T372", "b_comfort <= b_max"),
    Fault("a constraint that belongs to nothing", add(C, '\nparam spare : m = 1 m in [0, 5]\n\nconstrain spare <= 2 m\n  because "there is not more"\n'), "T172", "spare <= 2 m"),
    Fault("a constraint broken", swap(C, "= 3 m/s^2    in [0.5, 6]", "= 7 m/s^2    in [0.5, 8]"), "E307", "b_comfort"),
    Fault("a value out of its range", swap(C, "= 12 m/s     in [1, 20]", "= 21 m/s     in [1, 20]"), "E306", "v_max"),
    Fault("a signal's range widened", swap(N, "age: s in [0, 60]", "age: s in [0, 600]"), "T372", "objects"),
    Fault("a default for what an assumption watches", swap(N, "age: s in [0, 60]", "age: s in [0, 60] default 0"), "T372", "objects"),
    Fault("a signal's field in another unit", swap(N, "age: s in [0, 60]", "age: m in [0, 60]"), "E301", "A-SEEN"),
    Fault("what a builder gives declared in another unit", swap(N, "kappa: 1/m in", "kappa: 1/m^2 in"), "E421"),
    Fault("the order of the rulebook turned round", swap(B, "keeps_clear > speed_limit > braking", "braking > speed_limit > keeps_clear"), "T372", "campus"),
    Fault("a rulebook without a rule", swap(B, " > braking", ""), "T372", "campus"),
    # what cannot be compiled
    Fault("an unknown name", swap(S, "require   p.v <= v_max", "require   p.v <= v_limit"), "E201", "speed_limit"),
    Fault("units that do not fit", swap(S, "require   p.v <= v_max", "require   p.v <= b_max"), "E301", "speed_limit"),
    Fault("a parenthesis too few", swap(S, "min(b_max, bite(p.v))", "min(b_max, bite(p.v)"), "E108", "braking"),
    Fault("a conflict of a merge in a spec", swap(S, "  require   p.v <= v_max\n", "<<<<<<< ours\n  require   p.v <= v_max\n=======\n  require   p.v <= 13 m/s\n>>>>>>> theirs\n"), "E008", status=2),
    Fault("a spec that is no text", put(N, b"\xff\xfe"), "E004", status=2),
    Fault("a spec cut off", remade(S, lambda data: data[:-30]), "E102"),
    Fault("a spec thrown away", gone(C), "E203"),
]
# fmt: on
