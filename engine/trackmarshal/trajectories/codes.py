"""Codes of what can be wrong with the columns of a trajectory that is to be completed, converted, cut or resampled."""

CODES = {
    "D191": ("no columns of numbers", "A trajectory is columns by name: equally long lists or arrays of numbers, one sample at least. None stands for a missing number (NaN)."),
    "D192": ("a column that is needed is missing", "Arc length, direction and curvature follow from x and y, time from s and v: without them nothing can be computed. Where all samples are in one place, it has no direction; where it leads ahead and backwards, its path does not say where the car points."),
    "D193": ("a heading's convention that is not known", "Where a heading of 0 points to is `+x`, `+y`, `-x`, `-y`, `east`, `north`, `west`, `south`, or an angle in rad from +x, counter-clockwise."),
    "D194": ("a trajectory cannot be cut or resampled so", "Resampling takes one of a count (2 to a million), a distance in m and a step in s, and finite t, s and v that do not go back. Cutting takes the speed of the tail in m/s."),
}  # fmt: skip
