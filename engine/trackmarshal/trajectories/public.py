"""The helpers as callers use them: lists or arrays in, arrays of float64 out. docs/integration.md shows them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from trackmarshal.doubles import double
from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.trajectories import along, conventions, rest
from trackmarshal.trajectories.columns import arrays, equally_long, lists, numbers
from trackmarshal.trajectories.resample import resampled

if TYPE_CHECKING:
    from trackmarshal.trajectories.columns import Array


def _two(first: tuple[str, Any], second: tuple[str, Any]) -> tuple[list[float], list[float]]:
    read = {name: numbers(name, values) for name, values in (first, second)}
    equally_long(read)
    a, b = read.values()
    return a, b


def arc_length(x: Any, y: Any) -> Array:
    """(samples,) m, from 0: cumulative length of the polygon through the positions [m]. Raises D191."""
    return arrays({"s": along.arc_length(*_two(("x", x), ("y", y)))})["s"]


def time_along(s: Any, v: Any) -> Array:
    """(samples,) s, from 0: when each station s [m] is reached with the speeds v [m/s] at constant acceleration between samples.

    0.1 s between two samples that both stand still. Raises D191.
    """
    return arrays({"t": along.time_along(*_two(("s", s), ("v", v)))})["t"]


def acceleration_along(s: Any, v: Any) -> Array:
    """(samples,) m/s^2: of the step that follows each sample, (v1^2 - v0^2) / (2 ds); 0 at the last. Raises D191."""
    return arrays({"a": along.acceleration_along(*_two(("s", s), ("v", v)))})["a"]


def direction_along(x: Any, y: Any) -> Array:
    """(samples,) rad from +x, counter-clockwise: where the path points, by the circle through three samples. Raises D191, D192."""
    return arrays({"heading": along.direction_along(*_two(("x", x), ("y", y)))})["heading"]


def curvature_along(x: Any, y: Any) -> Array:
    """(samples,) 1/m, positive to the left: of the circle through three samples. Raises D191."""
    return arrays({"kappa": along.curvature_along(*_two(("x", x), ("y", y)))})["kappa"]


def heading_from(
    heading: Any, zero: str | float = "+x", clockwise: bool = False, degrees: bool = False
) -> Any:
    """Headings of another convention in rad from +x, counter-clockwise, in (-pi, pi]: a column as an array, one number as a float.

    zero: where a heading of 0 points to: `+x`, `+y`, `-x`, `-y`, `east`, `north`, `west`, `south`, or rad from +x. clockwise: whether
    it grows to the right. degrees: whether it is in degrees. Raises D191, D193.
    """
    for name, flag in (("clockwise", clockwise), ("degrees", degrees)):
        if not isinstance(flag, bool):  # "no" would be true
            raise wrong_type(f"`{name}` is True or False", flag)
    if isinstance(heading, int | float) and not isinstance(heading, bool):
        return conventions.converted([double(heading)], zero, clockwise, degrees)[0]
    read = numbers("heading", heading)
    return arrays({"heading": conventions.converted(read, zero, clockwise, degrees)})["heading"]


def complete(columns: Mapping[str, Any]) -> dict[str, Array]:
    """A trajectory with x, y [m] and v [m/s], completed by s, t, heading, kappa and a where they are missing; further columns are kept.
    Where v is negative, and nowhere positive, it points against the direction of travel.

    Raises D191 for columns that are none or unequally long, and D192 where x, y or v is missing, or heading or kappa of what leads ahead and
    backwards.
    """
    return arrays(along.completed(lists(columns, ("x", "y", "v"))))


def cut_at_rest(columns: Mapping[str, Any], speed: float = rest.TAIL_SPEED) -> dict[str, Array]:
    """A trajectory with x, y [m] and v [m/s] that ends where the car stands: the one place where that is decided (`trajectories.rest.cut`).

    From the first sample on after which none is faster than `speed` [m/s], the car goes on braking as in the step before, and the
    trajectory ends at rest. What is cut has to be what is driven. Raises D191, D192; D194 where the speed is none.
    """
    if isinstance(speed, bool) or not isinstance(speed, int | float) or not 0.0 <= speed < 1e3:
        raise TrackmarshalError(
            "D194", f"a speed of {speed!r:.40}", help="give the tail's speed in m/s, 0 or more"
        )
    return arrays(rest.cut(lists(columns, ("x", "y", "v")), max(float(speed), along.REST_SPEED)).columns)


def resample(
    columns: Mapping[str, Any],
    count: int | None = None,
    spacing: float | None = None,
    step: float | None = None,
) -> dict[str, Array]:
    """A complete trajectory (t, s, x, y, heading, v) at `count` samples, every `spacing` m, or every `step` s; its ends stay.

    What is resampled has to be what is driven: between fewer samples, rules see less. Raises D191, D192, D194.
    """
    read = lists(columns, ("t", "s", "x", "y", "heading", "v"))
    return arrays(resampled(read, count, spacing, step))
