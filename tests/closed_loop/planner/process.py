"""graph-ltpl as a process of its own, in an environment of its own: JSON lines in and out, one answer a request.

`python process.py TRACK.csv PARAMS GRAPH.pckl` reads the race line, plans its lattice (minutes; kept in GRAPH.pckl) and answers:

    {"do": "run", "pace": {...}}                           a fresh planner for one run; {} at once
    {"do": "start", "x", "y", "heading", "v"}              puts it on the track: {"outside": bool}
    {"do": "plan", "t", "ego": {...}, "objects": [...]}    {"action", "t", "driving": {...}, "emergency": {...}, "said": [...]}
    {"do": "end"}                                          forgets the run: {}

Each run is a fork of the process that has the lattice, so that no run sees what another one left. Headings are the planner's own,
0 along +y; lengths in m, times in s. Columns: s, x, y, psi, kappa, v, a.
"""

from __future__ import annotations

import shim  # first: it replaces the clock

CLOCK = shim.install()

# ruff: noqa: E402
import json
import logging
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
from graph_ltpl.Graph_LTPL import Graph_LTPL
from graph_ltpl.helper_funcs.src.calc_brake_emergency import calc_brake_emergency

COLUMNS = ("s", "x", "y", "psi", "kappa", "v", "a")


class Said(logging.Handler):
    """What the planner logs, a list that is taken away in each cycle."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())

    def take(self) -> list[str]:
        lines, self.lines = self.lines, []
        return lines


class Planning:
    """One run of the planner."""

    def __init__(self, planner: Graph_LTPL, said: Said) -> None:
        self.planner, self.said, self.action = planner, said, "straight"
        self.pace: dict[str, Any] = {}

    def run(self, pace: dict[str, Any]) -> dict[str, Any]:
        self.pace = pace
        return {}

    def start(self, x: float, y: float, heading: float, v: float) -> dict[str, Any]:
        outside = self.planner.set_startpos(np.array([x, y]), heading, v)
        return {"outside": bool(outside)}

    def plan(self, t: float, ego: dict[str, float], objects: list[dict[str, Any]]) -> dict[str, Any]:
        CLOCK.t = t
        seen = [
            {"id": o["id"], "type": "physical", "form": "rectangle", "X": o["x"], "Y": o["y"], "theta": o["heading"],
             "v": o["v"], "length": o["length"], "width": o["width"]}
            for o in objects
        ]  # fmt: skip
        self.planner.calc_paths(prev_action_id=self.action, object_list=seen)
        found = self.planner.calc_vel_profile(
            pos_est=[ego["x"], ego["y"]],
            vel_est=ego["v"],
            vel_max=self.pace["v_max"],
            gg_scale=1.0,
            local_gg=(self.pace["along"], self.pace["across"]),
            ax_max_machines=np.array(self.pace["drive"]),
            safety_d=self.pace["safety_distance"],
            incl_emerg_traj=True,
        )[0]
        self.action = next(name for name in self.pace["wanted"] if name in found)
        driving = found[self.action][0]
        own = self.pace["own_emergency"]
        return {
            "action": self.action,
            "t": t,
            "driving": _columns(driving),
            "emergency": _columns(found["emergency"][0] if own else self._branched(driving, ego)),
            "said": self.said.take(),
        }

    def _branched(self, driving: Any, ego: dict[str, float]) -> Any:
        """An emergency trajectory that can be taken up: as the driving one until `common` s after the car, then graph-ltpl's own braking."""
        nearest = int(np.argmin(np.hypot(driving[:, 1] - ego["x"], driving[:, 2] - ego["y"])))
        way = np.diff(driving[nearest:, 0])
        mean = (driving[nearest:-1, 5] + driving[nearest + 1 :, 5]) / 2.0
        due = np.cumsum(np.divide(way, mean, out=np.full(way.shape, np.inf), where=mean > 0.0))
        branch = min(nearest + 1 + int(np.searchsorted(due, self.pace["common"])), len(driving) - 2)
        rest = driving[branch:]
        limits = np.full((len(rest), 2), (self.pace["along"], self.pace["across"]))
        return np.vstack((driving[:branch], calc_brake_emergency(rest, limits)))


def _columns(trajectory: Any) -> dict[str, list[float]]:
    return {name: trajectory[:, i].tolist() for i, name in enumerate(COLUMNS)}


def serve(planner: Graph_LTPL, said: Said, answers: Any) -> None:
    """Answers requests from standard input until it ends."""
    planning: Planning | None = None
    while line := sys.stdin.buffer.readline():
        asked = json.loads(line)
        what = asked.pop("do")
        if what == "run":
            child = os.fork()
            if child:  # the run is the child's until it ends
                status = os.waitpid(child, 0)[1]
                if status:
                    _answer(answers, {"error": f"the planner of this run ended with status {status}"})
                continue
            planning = Planning(planner, said)
        if what == "end":
            _answer(answers, {})
            os._exit(0)
        if planning is None or what not in ("run", "start", "plan"):
            raise ValueError(f"cannot do {what!r} now")
        try:
            _answer(answers, getattr(planning, what)(**asked))
        except Exception as error:  # graph-ltpl raises whatever it comes upon; the run is told
            _answer(answers, {"error": f"{type(error).__name__}: {error}"})


def _answer(answers: Any, content: dict[str, Any]) -> None:
    answers.write(json.dumps(content).encode() + b"\n")
    answers.flush()


def main() -> None:
    track, params, graph = sys.argv[1:]
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # the planner prints; only answers go out
    said = Said()
    logging.getLogger("local_trajectory_logger").addHandler(said)
    planner = Graph_LTPL(
        path_dict={
            "globtraj_input_path": track,
            "graph_store_path": graph,
            "ltpl_offline_param_path": str(Path(params) / "ltpl_config_offline.ini"),
            "ltpl_online_param_path": str(Path(params) / "ltpl_config_online.ini"),
        },
        visual_mode=False,
        log_to_file=False,
    )
    planner.graph_init(veh_param_dyn_model_exp=1.0, veh_param_dragcoeff=0.854, veh_param_mass=1160.0)
    _answer(answers, {"ready": True})
    serve(planner, said, answers)


if __name__ == "__main__":
    main()
