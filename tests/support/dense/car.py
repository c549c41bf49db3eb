"""The numbers of the car that the planner plans for, read from `ltpl_car.spec` by a reader of its own; SI units throughout."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from support.dense.recording import Floats


@dataclass(frozen=True)
class Car:
    """grip: m/s^2 at the tyres in any direction. drive: rows of speed and acceleration, linear between, constant beyond."""

    length: float
    width: float
    mass: float
    radius: float
    grip: float
    drag: float
    drive: Floats
    v_max: float
    #: Of the machine's brakes; the planner's car has none but the grip, so the shipped vehicle's number counts (devbot.spec).
    brakes: float = 35.0

    def allowed(self, share: float) -> Car:
        """The same car with a share more of grip and drive: 0.01 is 1 %."""
        drive = self.drive * np.array([1.0, 1.0 + share])
        return replace(self, grip=self.grip * (1.0 + share), drive=drive)

    def air(self, v: Floats | float) -> Floats:
        """Deceleration by drag, m/s^2."""
        return np.asarray(self.drag * np.square(v) / self.mass)

    def tyres(self, v: Floats, a: Floats, kappa: Floats) -> Floats:
        """Acceleration that the tyres give: along, they push against drag too; across, the bend. m/s^2."""
        return np.hypot(a + self.air(v), v * v * kappa)

    def most_drive(self, v: Floats) -> Floats:
        """What the drive train gives at a speed, before drag, m/s^2."""
        return np.interp(v, self.drive[:, 0], self.drive[:, 1])


_NUMBER = r"(-?\d+(?:\.\d+)?)"


def read(path: Path) -> Car:
    """Raises AssertionError for a file that says anything in another form, or leaves anything out."""
    text = path.read_text("utf-8")
    values: dict[str, float] = {}
    for name, number, divisor in re.findall(
        rf"^param (\w+)\s*:\s*\S+\s*= {_NUMBER}(?: / {_NUMBER})?", text, flags=re.MULTILINE
    ):
        values[name] = float(number) / float(divisor or 1.0)
    assert len(values) == text.count("\nparam "), "a parameter is written in a form that is not read here"
    rows = re.findall(rf"\| {_NUMBER} m/s: {_NUMBER} m/s\^2", text)
    assert len(rows) == text.count(" m/s: "), "a row of the table is written in a form that is not read here"
    assert values["drive_factor"] == 1.0
    return Car(
        length=values["length"],
        width=values["width"],
        mass=values["mass"],
        radius=values["R_min"],
        grip=values["mu"] * values["g"],
        drag=values["drag"],
        drive=np.array(rows, dtype=np.float64),
        v_max=values["v_max"],
    )
