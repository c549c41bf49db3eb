"""Codes of what can be wrong with a map of lanes, and with vehicles on it."""

CODES = {
    "D185": ("a lanelet that is none", "A lanelet lies between a left and a right bound of as many points, two at least, in the direction of travel: finite, no two in a row in one place, the left one on the left. Bounds do not cross, nor lead opposite ways."),
    "D186": ("lanelets that do not fit together", "Neighbours and successors are lanelets of the same map. Of two neighbours each names the other, on the side that their directions say; a successor begins where the lanelet ends; no lanelets lead round in a circle."),
    "D187": ("a vehicle that cannot be looked at", "Each vehicle of a cycle has a number of its own, a finite pose, speed and acceleration, a length and a width greater than zero, and touches a lanelet; the ego is one of them. Of a vehicle off the map nothing could be said, and that would read as safe."),
}  # fmt: skip
