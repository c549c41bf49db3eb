"""Codes of what can be wrong with a case: the data that rules are evaluated on."""

CODES = {
    "D201": ("the case is not an object", "A case is one JSON object on one line: {\"id\": .., \"signals\": {..}, \"params\": {..}, \"tables\": {..}}."),
    "D202": ("wrong type", "A number, a list or an object stands where the signal's declaration asks for something else."),
    "D203": ("unknown parameter, table, place or field", "`params`, `tables` and `places` override what the spec declares, by its name; a name that it does not declare is refused. So is a key that is almost the name of one with a default, which would silently be used instead."),
    "D204": ("an override that cannot stand", "An override must be finite, lie inside the declared range, and table knots must ascend."),
    "D211": ("missing", "A signal, or a field of it, that a chosen rule reads is not there. The rules that read it are undefined."),
    "D212": ("unequal columns", "The columns of a timeline have different lengths. The rules that read the signal are undefined."),
    "D213": ("too few samples", "A trajectory has at least two samples, a series at least one. The rules that read the signal are undefined."),
    "D214": ("not increasing", "A column that is declared `increasing` stands still or goes back. The rules that read the signal are undefined."),
    "D215": ("not finite", "A value is missing (null), NaN or infinite. Whatever depends on it is undefined."),
    "D216": ("outside its range", "A value is outside the range that the input contract declares. The rules are evaluated, but the case is not safe."),
    "D218": ("an id that stands twice", "Elements of a set are told apart by their ids; with two of one id, reports could not say which one decided. The case is not safe."),
    "D217": ("unusable geometry", "A border has too few or non-finite points, or crosses itself or the other one. The rules that read it are undefined."),
}  # fmt: skip
