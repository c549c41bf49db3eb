"""Warnings of numbers: angles, percentages and headings that are plain numbers, and measured ones that are compared to the last bit."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class ExactlyEqual(Diagnostic):
    code = "W301"
    title = "measured numbers compared to the last bit"
    level = "warning"
    text = "`{op}` compares measured numbers to the last bit"
    label = "of noise, too"
    remedy = 'write `{instead}`, or say in the rule why this is meant: `allow W301 because "..."`'
    explanation = (
        "Two measurements of one thing hardly ever agree in all 53 bits: `==` is then violated, and `!=` satisfied, whatever the car does. "
        "Numbers that count something (fields with the unit 1, and what `floor` makes) are compared without this warning."
    )

    span: Span
    op: str
    instead: str


class BareAngle(Diagnostic):
    code = "W302"
    title = "a bare number used as an angle"
    level = "warning"
    text = "a number without a unit is used as an angle"
    label = "rad or deg?"
    other_label = "this is an angle"
    remedy = "{hint}"
    explanation = (
        "An angle is a plain number, in rad. A number without a unit is therefore taken for rad where it meets an angle, and `heading <= 90` "
        "holds for every heading. What a field, a parameter or a function gives in rad or deg is an angle, and so are sums and multiples of it. "
        "0 needs no unit."
    )

    span: Span
    other: Span | None
    hint: str
    #: What a test gives without a unit, several times.
    what: str = ""
    others: tuple[Span, ...] = ()


class BarePercentage(Diagnostic):
    code = "W309"
    title = "a bare number beside a percentage"
    level = "warning"
    text = "a number without a unit meets a percentage"
    label = "this is {percent}"
    other_label = "this is a percentage"
    remedy = "{hint}"
    explanation = (
        "A percentage is a plain number, a hundredth of what stands before the `%`. In a range and in a table a number without a unit is in the unit "
        "that is declared there; in a formula it is itself, so that `charge <= 90` holds for every charge. Numbers up to 1 are taken for what they are, "
        "shares of a whole, and so are multiples: `100 * charge <= 90` compares what it seems to."
    )

    span: Span
    other: Span
    percent: str
    hint: str


class NoShare(Diagnostic):
    code = "W318"
    title = "a percentage beside what is no share"
    level = "warning"
    text = "a percentage meets {what}"
    label = "this is a percentage"
    other_label = "this is {what}"
    remedy = "{hint}"
    explanation = (
        "Percentages, angles and counts are plain numbers, so that dimensions do not tell them apart. 100 % of a slope is 45 deg, and as a number it is 1, which is "
        "1 rad, 57 deg; `count(o in objects where p) <= 50 %` asks for no more than half an object."
    )

    span: Span
    other: Span | None
    what: str
    hint: str


class TurnsOver(Diagnostic):
    code = "W310"
    title = "headings compared across a whole turn"
    level = "warning"
    text = "two headings that are alike may differ by a whole turn here"
    label = "{told}"
    remedy = "write `angle_difference({first}, {second})`, of the module `prelude.frames`"
    explanation = (
        "Headings start anew after half a turn: what heads for 179 deg and what heads for -179 deg go almost the same way, and their difference is 358 deg. "
        "So it is with a course in [0, 360], between 359 deg and 1 deg, and with every angle whose declared range is a whole turn, whatever it is called. "
        "A rule that asks how far two headings are apart, how fast one turns, what lies between two, or which is the greater one, or chooses by it whom it is about, is then "
        "wrong about cars that drive side by side, and about one that drives on through 180 deg. "
        "`angle_difference` takes whole turns out; sines and cosines of a difference do without it."
    )

    span: Span
    first: str
    second: str
    told: str


class LapsOver(Diagnostic):
    code = "W317"
    title = "stations compared across the finish line"
    level = "warning"
    text = "two stations that lie side by side may differ by a whole lap here"
    label = "over the finish line of a closed line, this is a lap too much, or too little"
    remedy = 'write `station_gap(LINE, {first}, {second})`, which goes the shorter way round, or say in the rule why this is meant: `allow W317 because "..."`'
    explanation = (
        "Stations of a closed line start anew at the finish line: who is 10 m behind it and who is 10 m ahead of it are 20 m apart, and their stations "
        "almost a lap. Which of two cars leads, and by how much, is then wrong once a lap. `station_gap` goes over the finish line; on an open line it is "
        "the difference."
    )

    span: Span
    first: str
    second: str
