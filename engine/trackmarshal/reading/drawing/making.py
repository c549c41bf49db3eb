"""Drawings of rules out of a spec, its tests and recordings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.reading.drawing.choosing import Known, Standing
from trackmarshal.reading.drawing.demand import Demand
from trackmarshal.reading.drawing.drawn import asked, drawn, nothing
from trackmarshal.reading.drawing.points import Places, together
from trackmarshal.reading.drawing.quantities import Undrawable
from trackmarshal.reading.drawing.recorded import recorded
from trackmarshal.runtime.frame import Settings
from trackmarshal.scenarios.recording import Recording
from trackmarshal.testing.boundary import Distances, near
from trackmarshal.testing.cases import PreparedTest
from trackmarshal.testing.si import spec_in_si


def drawings(
    rules: Sequence[RuleInfo], spec: Spec, tests: Sequence[PreparedTest], recordings: Iterable[tuple[Recording, Evaluator]],
    distances: Distances | None = None, over: str | None = None, against: str | None = None, declared: Spec | None = None,
) -> Iterator[tuple[str, Mapping[str, Any]]]:  # fmt: skip
    """By rule its drawing, or `none`, the reason why it has none. recordings: each with the rules that it is replayed with.

    over, against: the inputs to the right and up; None: the most telling ones. declared: the spec that tests are of, where that is not the same, as
    other values are in force. Raises E493.
    """
    demands: dict[str, Demand] = {}
    for rule in rules:
        try:
            demands[rule.name] = _demand(rule, spec, (over, against))
        except Undrawable as why:
            yield rule.name, nothing(rule.name, why.reason)
    places = recorded(recordings, demands) if demands else {}
    for name, demand in demands.items():
        found = [one for one in places[name].values() if one is not None]
        standing = list(_standing(demand, declared or spec, tests, distances or Distances()))
        known = Known(standing, together(found) if found else None)
        runs = {
            "runs": len(found),
            "unusable": sorted(run for run, one in places[name].items() if one is None),
        }
        yield name, {**drawn(demand, asked(demand, over, against, known), known), **runs}


def _demand(rule: RuleInfo, spec: Spec, names: Sequence[str | None]) -> Demand:
    """A demand, of which parameters that are asked for are inputs."""
    plain = Demand(rule, spec)
    known = {name for one in plain.quantities for name in one.names}
    asked_ = {name for name in names if name not in known}
    wanted = [name for name in plain.params if not asked_.isdisjoint((name, spec.params[name].short))]
    return Demand(rule, spec, wanted) if wanted else plain


def _standing(
    demand: Demand, declared: Spec, tests: Sequence[PreparedTest], distances: Distances
) -> Iterator[Standing]:
    """The tests of a rule that are decided at one place, with the parameters and tables that are in force in each."""
    rule, spec = demand.rule, declared
    own = [one for one in tests if one.rule.name == rule.name and not one.later and one.verdict in ("satisfied", "violated")]  # fmt: skip
    if not own:
        return
    own_rule = spec.rule(rule.name)
    assert own_rule is not None
    in_si, places = (
        Evaluator(spec_in_si(spec), [rule.name], "reference"),
        Places(Demand(own_rule, spec, demand.added)),
    )
    params = {
        name: spec.params[name].value
        for name, info in demand.spec.params.items()
        if spec.params[name].value != info.value
    }
    tables = {
        name: (spec.tables[name].knots, spec.tables[name].values) for name, info in demand.spec.tables.items()
        if (spec.tables[name].knots, spec.tables[name].values) != (info.knots, info.values) and info.across is None
    }  # fmt: skip
    for test in own:
        frame = in_si.read(test.case)
        points = places.of([frame])
        place = points.decisive()
        if place is not None:
            settings = Settings({**params, **frame.settings.params}, {**tables, **frame.settings.tables})
            yield Standing(
                test.title,
                points.values[:, place],
                test.verdict,
                near(test, spec, distances).narrow,
                settings,
            )
