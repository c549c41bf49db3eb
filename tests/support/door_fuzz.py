"""A C program that hands mutated cycles to a generated Supervisor and holds its door against a plain reading of the contract.

The arrays are as long as the capacities and not one entry longer, so that the address sanitizer sees whoever reads beyond them.
"""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.ir.spec import FieldType, Spec

#: Capacities that the driver is compiled with; a set that declares its own has that.
SAMPLES, ELEMENTS, BORDER = 24, 6, 5


def driver(spec: Spec) -> str:
    """The program: arguments are the number of cycles and the seed; it prints how many were judged, and aborts on a lie."""
    return "\n".join([*_tables(spec), _PROGRAM])


def _tables(spec: Spec) -> Iterator[str]:
    plan = [f for f in spec.signals["plan"].fields_ if f.kind == "number"]
    yield '#include "supervisor.h"'
    yield "#include <float.h>\n#include <math.h>\n#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>"
    yield f"enum {{ SAMPLES = {SAMPLES}, ELEMENTS = {ELEMENTS}, BORDER = {BORDER} }};"
    yield f"enum {{ OBJECTS = {spec.signals['objects'].capacity or ELEMENTS} }};"
    yield "typedef struct { const char *name; double low; double high; } range;"
    for name in ("plan", "objects", "obstacles", "ego"):
        fields = [f for f in spec.signals[name].fields_ if f.kind == "number"]
        yield f"static const range {name}_range[{len(fields)}] = {{{', '.join(map(_range, fields))}}};"
        if name != "ego":
            yield f"static double *{name}_column[2][{len(fields)}];"
            yield f"static size_t {name}_count[2];"
        yield f"enum {{ {name.upper()}_FIELDS = {len(fields)} }};"
    yield "static tm_in_plan plans[2];"
    yield "static tm_in_objects objects;"
    yield "static tm_in_obstacles obstacles;"
    yield "static void wire(void) {"
    for name, into in (
        ("plan", "plans[0]"),
        ("plan", "plans[1]"),
        ("objects", "objects"),
        ("obstacles", "obstacles"),
    ):
        at = into[-2] if name == "plan" else "0"
        yield f"  {into}.count = {name}_count[{at}];"
        for k, field in enumerate(f for f in spec.signals[name].fields_ if f.kind == "number"):
            yield f"  {into}.{field.name} = {name}_column[{at}][{k}];"
    yield "}"
    yield "static double *ego_field(tm_in_ego *ego, size_t k) {"
    yield "  switch (k) {"
    for k, field in enumerate(spec.signals["ego"].fields_):
        yield f"    case {k}: return &ego->{field.name};"
    yield "    default: abort();"
    yield "  }"
    yield "}"
    names = [f.name for f in plan]
    for name in ("t", "x", "y", "heading", "v"):
        yield f"enum {{ P_{name.upper()} = {names.index(name)} }};"


def _range(field: FieldType) -> str:
    low = "-DBL_MAX" if field.lower is None else repr(field.lower)
    high = "DBL_MAX" if field.upper is None else repr(field.upper)
    return f'{{"{field.name}", {low}, {high}}}'


_PROGRAM = r"""
static unsigned long long state;
static unsigned below(unsigned n) {
  state = state * 6364136223846793005ull + 1442695040888963407ull;
  return (unsigned)((state >> 33) % n);
}
static double wild(void) {
  static const double some[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, 5e-324, -5e-324, DBL_MAX, -DBL_MAX, -0.0, 0.0, 1.0, -1.0, 1e10, 1001.0};
  return some[below(sizeof some / sizeof *some)];
}
static double *column_of(size_t most) { /* on the heap, ending where it ends */
  double *made = malloc(most * sizeof *made);
  if (made == NULL) { abort(); }
  return made;
}
static int64_t last_number;
static double last_t;
static bool numbered;
static bool stamped;

static double reading;
static tm_in_ego ego;
static tm_in_track track;
static double *left;
static double *right;

static double clock_now(void *user) { return *(const double *)user; }

static void fresh(tm_cycle *c) {
  for (int side = 0; side < 2; ++side) {
    plan_count[side] = 2u + below(SAMPLES - 1u);
    for (size_t k = 0; k < PLAN_FIELDS; ++k) {
      for (size_t i = 0; i < SAMPLES; ++i) {
        plan_column[side][k][i] = 0.0;
      }
    }
    for (size_t i = 0; i < SAMPLES; ++i) {
      plan_column[side][P_T][i] = 0.1 * (double)i;
      plan_column[side][P_X][i] = (double)i;
    }
  }
  objects_count[0] = below(OBJECTS + 1u);
  obstacles_count[0] = below(ELEMENTS + 1u);
  for (size_t i = 0; i < OBJECTS; ++i) {
    for (size_t k = 0; k < OBJECTS_FIELDS; ++k) { objects_column[0][k][i] = fmax(objects_range[k].low, fmin(objects_range[k].high, 3.0)); }
  }
  for (size_t i = 0; i < ELEMENTS; ++i) {
    for (size_t k = 0; k < OBSTACLES_FIELDS; ++k) { obstacles_column[0][k][i] = fmax(obstacles_range[k].low, fmin(obstacles_range[k].high, 3.0)); }
  }
  wire();
  memset(&ego, 0, sizeof ego);
  for (size_t i = 0; i < BORDER; ++i) {
    left[2u * i] = right[2u * i] = 50.0 * (double)i;
    left[(2u * i) + 1u] = 8.0 + (double)below(2u);
    right[(2u * i) + 1u] = -8.0;
  }
  track.left.points = left;
  track.right.points = right;
  if (track.left.count < 2u || track.left.count > BORDER || below(2u) == 0u) { track.left.count = 2u + below(BORDER - 1u); }
  if (track.right.count < 2u || track.right.count > BORDER || below(2u) == 0u) { track.right.count = 2u + below(BORDER - 1u); }
  track.left.id = track.left.count; /* of as many points as last, it counts as the line that passed last */
  track.right.id = track.right.count;
  track.closed = false;
  c->came = c->numbered = c->stamped = true;
  c->number = numbered ? (last_number + 1) : 0;
  c->t = stamped ? (last_t + 0.1) : 0.0;
  c->now = fmax(c->t + 0.01, reading);
  c->driving = &plans[0];
  c->emergency = &plans[1];
  c->signals.ego = &ego;
  c->signals.objects = &objects;
  c->signals.obstacles = &obstacles;
  c->signals.track = &track;
  c->found = NULL;
  c->found_count = 0u;
}

static void spoil(tm_cycle *c) {
  const unsigned side = below(2u);
  switch (below(15u)) {
    case 0: case 1: case 2: plan_column[side][below(PLAN_FIELDS)][below(SAMPLES)] = wild(); break;
    case 3: objects_column[0][below(OBJECTS_FIELDS)][below(OBJECTS)] = wild(); break;
    case 4: obstacles_column[0][below(OBSTACLES_FIELDS)][below(ELEMENTS)] = wild(); break;
    case 5: *ego_field(&ego, below(EGO_FIELDS)) = wild(); break;
    case 6: { /* time goes back, or stands still */
      const size_t i = below(SAMPLES);
      plan_column[side][P_T][i] = plan_column[side][P_T][below(SAMPLES)];
      break;
    }
    case 7: plans[side].count = (below(2u) == 0u) ? below(3u) : (SAMPLES + below(3u)); break;
    case 8:
      if (below(2u) == 0u) { objects.count = OBJECTS + below(3u); } else { obstacles.count = (size_t)-1; }
      break;
    case 9: if (below(2u) == 0u) { plans[side].x = NULL; } else { objects.v = NULL; } break;
    case 10: plan_column[1][(below(2u) == 0u) ? P_X : P_HEADING][0] += 0.03 * (double)below(10u); break;
    case 11: plan_column[1][P_V][(below(2u) == 0u) ? 0u : (plan_count[1] - 1u)] += 0.3 * (double)below(4u); break;
    case 12:
      switch (below(5u)) {
        case 0: track.left.points = NULL; break;
        case 1: track.right.count = below(3u); break;
        case 2: track.left.count = BORDER + below(2u); break;
        case 3: left[below(2u * BORDER)] = wild(); track.left.id = 0u; break;
        default: track.closed = true; break;
      }
      break;
    case 13:
      switch (below(6u)) {
        case 0: c->driving = NULL; break;
        case 1: c->emergency = NULL; break;
        case 2: c->signals.ego = NULL; break;
        case 3: c->signals.objects = NULL; break;
        case 4: c->signals.track = NULL; break;
        default: c->came = false; break;
      }
      break;
    default:
      switch (below(8u)) {
        case 0: c->number += (int64_t)below(3u) - 1; break;
        case 1: c->number = (below(2u) == 0u) ? INT64_MAX : INT64_MIN; break;
        case 2: c->t += 0.1 * ((double)below(5u) - 2.0); break;
        case 3: c->now += 0.1 * ((double)below(5u) - 2.0); break;
        case 4: c->t = wild(); break;
        case 5: c->now = wild(); break;
        case 6: c->numbered = false; break;
        default: c->stamped = false; break;
      }
      break;
  }
}

static bool outside(double x, const range *r) { return !(x >= r->low && x <= r->high); }

static bool line_broken(const tm_points *line) {
  bool bad = line->count < 2u || line->count > BORDER || line->points == NULL;
  for (size_t i = 0; !bad && i < 2u * line->count; ++i) { bad = !isfinite(line->points[i]); }
  return bad;
}

static bool clock_broken(const tm_cycle *c) { return !isfinite(c->now) || c->now < reading; }

/* Whether the stamp follows the last one; a clock that is wrong says nothing about it. */
static bool in_order(const tm_cycle *c) {
  return c->came && c->stamped && isfinite(c->t) && (!stamped || c->t - last_t > 0.001) && (clock_broken(c) || !(c->t - c->now > 0.01));
}

static bool broken(const tm_cycle *c) {
  bool bad = clock_broken(c) || !c->came || !c->numbered || !in_order(c);
  if (bad || c->now - c->t > 0.1) { return true; }
  if (stamped) { bad = c->t - last_t > 0.15; }
  if (numbered) { bad = bad || (last_number == INT64_MAX) || (c->number != last_number + 1); }
  if (c->driving == NULL || c->emergency == NULL || c->signals.ego == NULL || c->signals.objects == NULL || c->signals.track == NULL) { return true; }
  for (int side = 0; side < 2; ++side) {
    const size_t n = plans[side].count;
    if (n < 2u || n > SAMPLES || plans[side].x == NULL) { return true; }
    for (size_t k = 0; k < PLAN_FIELDS; ++k) {
      for (size_t i = 0; i < n; ++i) { bad = bad || outside(plan_column[side][k][i], &plan_range[k]); }
    }
    for (size_t i = 1; i < n; ++i) { bad = bad || !(plan_column[side][P_T][i - 1u] < plan_column[side][P_T][i]); }
  }
  if (objects.count > OBJECTS || obstacles.count > ELEMENTS) { return true; }
  if (objects.v == NULL && objects.count > 0u) { return true; }
  for (size_t i = 0; i < objects.count; ++i) {
    for (size_t k = 0; k < OBJECTS_FIELDS; ++k) { bad = bad || outside(objects_column[0][k][i], &objects_range[k]); }
  }
  for (size_t i = 0; i < obstacles.count; ++i) {
    for (size_t k = 0; k < OBSTACLES_FIELDS; ++k) { bad = bad || outside(obstacles_column[0][k][i], &obstacles_range[k]); }
  }
  for (size_t k = 0; k < EGO_FIELDS; ++k) { bad = bad || outside(*ego_field(&ego, k), &ego_range[k]); }
  bad = bad || line_broken(&track.left) || line_broken(&track.right);
  {
    double *const *d = plan_column[0];
    double *const *e = plan_column[1];
    bad = bad || !(hypot(d[P_X][0] - e[P_X][0], d[P_Y][0] - e[P_Y][0]) <= 0.1);
    bad = bad || !(fabs(remainder(d[P_HEADING][0] - e[P_HEADING][0], 6.283185307179586)) <= 0.05);
    bad = bad || !(fabs(d[P_V][0] - e[P_V][0]) <= 0.5) || !(fabs(e[P_V][plans[1].count - 1u]) <= 0.01);
  }
  return bad;
}

int main(int argc, char **argv) {
  static tm_context context;
  static tm_decision out;
  const unsigned long cycles = strtoul(argc > 1 ? argv[1] : "1000", NULL, 10);
  unsigned long judged = 0;
  uint64_t serial = 0;
  state = strtoull(argc > 2 ? argv[2] : "1", NULL, 10);
  reading = -DBL_MAX;
  for (int side = 0; side < 2; ++side) {
    for (size_t k = 0; k < PLAN_FIELDS; ++k) { plan_column[side][k] = column_of(SAMPLES); }
  }
  for (size_t k = 0; k < OBJECTS_FIELDS; ++k) { objects_column[0][k] = column_of(OBJECTS); }
  for (size_t k = 0; k < OBSTACLES_FIELDS; ++k) { obstacles_column[0][k] = column_of(ELEMENTS); }
  left = column_of(2u * BORDER);
  right = column_of(2u * BORDER);
  (void)tm_init(&context);
  for (unsigned long k = 0; k < cycles; ++k) {
    tm_cycle cycle;
    tm_in_plan plan;
    bool bad;
    bool ordered;
    fresh(&cycle);
    if (below(8u) != 0u) { spoil(&cycle); }
    bad = broken(&cycle);
    ordered = in_order(&cycle);
    tm_step(&context, &cycle, clock_now, &cycle.now, &out);
    if (out.judged == bad || (out.fault_count == 0u) == bad || out.serial != ++serial || out.reason_count > TM_MAX_REASONS) {
      (void)printf("cycle %lu: %s, judged %d, %lu faults, the first %d of %s.%s\n", k, bad ? "broken" : "fine", (int)out.judged,
                   (unsigned long)out.fault_count, (int)out.reasons[0].fault.name, out.reasons[0].fault.signal, out.reasons[0].fault.field);
      abort();
    }
    if (bad && (out.safe || out.driven == TM_DRIVE_DRIVING)) { abort(); }
    for (size_t r = 0; r < TM_RULES && bad; ++r) {
      if (out.driving.rule[r].verdict != TM_UNDEFINED || out.emergency.rule[r].verdict != TM_UNDEFINED) { abort(); }
    }
    if (tm_stored_plan(&context, &plan, NULL) != out.stored) { abort(); }
    if (!clock_broken(&cycle)) { reading = cycle.now; }
    if (ordered) {
      last_t = cycle.t;
      stamped = true;
      if (cycle.numbered) {
        last_number = cycle.number;
        numbered = true;
      }
    }
    if (!(fabs(last_t) < 1e6) || reading > 1e6 || last_number == INT64_MAX) { /* far away, or the last number: start anew */
      stamped = false;
      numbered = false;
      last_t = 0.0;
      reading = -DBL_MAX;
      last_number = 0;
      serial = 0;
      (void)tm_init(&context);
    }
    judged += bad ? 0u : 1u;
  }
  for (int side = 0; side < 2; ++side) {
    for (size_t k = 0; k < PLAN_FIELDS; ++k) { free(plan_column[side][k]); }
  }
  for (size_t k = 0; k < OBJECTS_FIELDS; ++k) { free(objects_column[0][k]); }
  for (size_t k = 0; k < OBSTACLES_FIELDS; ++k) { free(obstacles_column[0][k]); }
  free(left);
  free(right);
  (void)printf("%lu of %lu judged\n", judged, cycles);
  return 0;
}
"""
