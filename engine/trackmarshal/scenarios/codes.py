"""What can be wrong with recordings and scenario declarations: the D12x to D15x of `trackmarshal explain`."""

from __future__ import annotations

from trackmarshal.errors import TrackmarshalError

CODES: dict[str, tuple[str, str]] = {
    "D120": (
        "the recording cannot be read, or not be written",
        "The file does not exist, is a folder, or its permissions forbid reading it. Or it is to be written over and is something else, such as the log "
        "that a recording is made from, or the record of a run: what is there is only replaced by what is of its kind.",
    ),
    "D121": (
        "not a recording that is known here",
        "Recordings are ScenarioArchitect archives (.saa), trackmarshal's own JSON Lines (.tmrec.jsonl, also with .gz), "
        "records of runs (.arrows), and what one is made of (.yaml): declarations, and mappings of logs and of archives. What a file is, is told by its first bytes, and by its name only "
        "where these say nothing. Pickles (.sas) run code when they are loaded and are never opened.",
    ),
    "D122": (
        "a damaged archive",
        "A .saa file is a ZIP archive. This one has no directory of contents, ends too early, or holds a part whose "
        "checksum does not fit: it was cut off or changed on its way. Nothing of a damaged recording is used.",
    ),
    "D123": (
        "an archive with the wrong parts",
        "A .saa archive holds exactly one .scn file and at most one *_ggv.csv and one *_ax_max_machines.csv. Names that "
        "leave the archive's folder (absolute, or with `..`) are refused, although nothing is ever written to disk.",
    ),
    "D124": (
        "a file that is too large, or grows too large",
        "Sizes are limited before and while compressed parts are read: a few kilobytes can unpack to many gigabytes, and "
        "the size that an archive declares need not be true.",
    ),
    "D125": (
        "an archive that is encrypted or packed in an unusual way",
        "Parts have to be stored or deflated, and not encrypted. That is what ScenarioArchitect writes.",
    ),
    "D126": (
        "not text, or no text at all",
        "Recordings are UTF-8 text. The file is empty, or holds bytes that are not UTF-8.",
    ),
    "D127": (
        "columns are missing or do not fit",
        "A .scn text has two comment lines with the track's borders (bound_l, bound_r), a header line with the names of "
        "the columns, and a row per cycle with as many cells as the header has names, separated by semicolons.",
    ),
    "D128": (
        "a value that cannot be read",
        "The cell or field is not what it should be: a number, a list of points, a truth value. Missing numbers are NaN in "
        ".scn texts and null in trackmarshal's own format; they stay undefined and are never rated as safe.",
    ),
    "D129": (
        "a trajectory with the wrong shape",
        "All columns of a trajectory have the same length, and it has at least one sample. The samples of a .scn text have "
        "six numbers: x, y, heading, curvature, speed, acceleration.",
    ),
    "D130": (
        "cycles out of order, or none",
        "A recording has at least one cycle, and the times of its cycles are finite and strictly increasing. A row twice "
        "or out of order would give the rules with a memory a history that never was.",
    ),
    "D131": (
        "a table that cannot be read",
        "Tables are rows of numbers with strictly increasing first column. The rows of *_ax_max_machines.csv are speed and "
        "acceleration, those of *_ggv.csv speed, longitudinal and lateral acceleration.",
    ),
    "D140": (
        "a line that is not strict JSON",
        "Every line of a .tmrec.jsonl file is one JSON object by RFC 8259: no NaN or Infinity (write null, \"inf\", "
        "\"-inf\"), no name twice in one object, no number beyond the range of IEEE double.",
    ),
    "D141": (
        "a recording with the wrong structure",
        "The first line is the header, every further line a cycle; recording.schema.json says which fields they have. "
        "Unknown fields are refused rather than skipped: they may matter, and a misspelt one would be lost.",
    ),
    "D142": (
        "a damaged compressed file",
        "The gzip stream ends too early or its checksum does not fit. Nothing of a damaged recording is used.",
    ),
    "D143": (
        "a version of the format that is not known",
        "The header says which version of the format the file follows. A newer trackmarshal may read it.",
    ),
    "D144": (
        "a candidate that the cycle does not have",
        "A cycle offers the candidates `driving` and `emergency`, or one of them. Others cannot be asked for.",
    ),
    "D145": (
        "a field that nobody declares",
        "A field of a recording's car, objects, obstacles or trajectories, or a table, is declared by a signal of the specs, or it is one of the "
        "format's own. Any other may be a misspelt one, whose default would silently stand in for it; the header's `extra` declares what a "
        "recording has beside.",
    ),
    "D146": (
        "a recording of another track",
        "The recording names its track (`\"track\": {\"name\": ..}` in the first line), and rules read places (zones, lines) of another one, which say "
        "nothing there. The module `tracks.NAME` has those of the track NAME: name it in the recording's `use`, or with --with.",
    ),
    "D147": (
        "recordings are in other units than the spec",
        "What the format of recordings has itself, such as speeds of objects, curvatures and ages, is in the units of the SI there, and so is what declarations and archives say of "
        "their vehicle in place of the spec. A spec that declares "
        "one of them in another unit would take 25 m/s for 25 km/h. Declare it in the unit of the SI; what rules ask of it may be in any, and "
        "fields of one's own are in the unit that the spec declares.",
    ),
    "D150": (
        "a declaration that cannot be read",
        "Declarations are plain YAML of at most 100 kB: maps, lists, numbers, texts. Anchors, aliases and tags are "
        "refused, because a short file with aliases stands for a huge one, and tags can run code.",
    ),
    "D151": (
        "a declaration with a wrong or missing value",
        "docs/scenarios.md lists the keys of a declaration with their units and ranges. Unknown keys are errors, so that "
        "a misspelt one is not silently without effect.",
    ),
    "D152": (
        "a declaration of something impossible",
        "The pieces of a closed track have to meet, cars have to stay on it, and every motion has to respect friction, "
        "turn radius, drive and brakes of the declared vehicle. Otherwise the scenario would test the wrong thing.",
    ),
    "D153": (
        "a fault that cannot be put in",
        "The fault changes a column, a field or an object that the recording does not have, moves to the left what a change before has turned to "
        "`inf`, or none of its cycles lies in the fault's time. It would be evidence for nothing.",
    ),
    "D250": (
        "a signal or field that a declaration cannot give",
        "Signals and further fields of cars are declared by one of the specs that a declaration names under `specs`; what a car's motion says of it comes "
        "from there. An expression gives an event, or a field that is a number or a Boolean; of an enumeration, a formula gives each member.",
    ),
    "D251": (
        "a table over time that cannot be read",
        "A value over time is a table of times and values, `at: {0 s: green, 12 s: yellow}`: in order, and from 0 s on, so that there is a value in every cycle; each row "
        "is that of a cycle. "
        "Members that formulas give end with one that is there `otherwise`, for the same reason.",
    ),
    "D252": (
        "an expression of a declaration that has no meaning",
        "Expressions are of the spec language, with the words of the specs that the declaration names. What the compiler says of one is said at its line.",
    ),
    "D253": (
        "an expression of a declaration without a value",
        "The reference evaluates an expression in every cycle, with the signals that stand above it. Where it is undefined, not finite, or looks ahead, there "
        "is nothing to write down.",
    ),
    "D254": (
        "a declaration that breaks the contract of a spec",
        "What a declaration gives is held against the input contract of the specs that declare it: types, ranges, orders, members. A recording that no "
        "Supervisor would take tests nothing.",
    ),
    "D255": (
        "a ground truth of a rule that cannot be used",
        "The truth about a single rule says when it has to fire (`unsafe`) and when it may (`free`), of a rule of the specs, of an object that is there, in "
        "cycles that there are, and once. In a recording, too, it is about objects and candidates that some cycle has.",
    ),
    "D256": (
        "a ground truth of a rule that the spec does not have",
        "The recording says when a rule has to fire, and the specs that it is replayed with have no such rule: nothing would come of it, without a word.",
    ),
    "D170": (
        "a log without a column that its mapping names",
        "Columns of a log are named in its mapping as its header names them, each exactly once; files without a header count theirs from 1. Fields of an "
        "MCAP file are /topic.field.",
    ),
    "D171": (
        "a row of a log that cannot be read",
        "Every cell that a mapping asks for is a finite number, and every row has as many cells as the first. A missing number is not guessed: take "
        "the row out of the file, or mend it; `from` and `to` of the mapping leave it in, since noise is that of the whole log.",
    ),
    "D172": (
        "a log whose time does not go on",
        "The times of a log's rows are strictly increasing, without a gap of more than a second: across a gap, what was driven next is not known.",
    ),
    "D173": (
        "a log that contradicts its mapping",
        "Speed, heading and yaw rate are held against the positions, and these against the borders, of which the left one is on the left of a car that "
        "drives along it. Where they are apart by more than noise can be, a unit or a convention in the mapping is not that of the log, and everything that rules would say of it would mean something else.",
    ),
    "D174": (
        "a log of a kind that is not read",
        "Logs are delimited text with one row a sample (also packed with gzip), or MCAP files with JSON messages. Other encodings are converted first. "
        "A topic that two channels write by turns is of two sources, and nothing says which of them is meant.",
    ),
    "D175": (
        "another file than the mapping names",
        "A mapping names the log and the borders by path and, if it likes, by hash; with a hash, no other file is taken for it.",
    ),
    "D176": (
        "a log that is too short",
        "A recording of a log has at least one cycle that is followed by as much driving as its plan looks ahead and its emergency trajectory takes.",
    ),
    "D177": (
        "a log that does not tell its noise",
        "The noise of a log is taken from its own statistics while the car is faster than 3 m/s. A log that is too short or too slow for that needs all of it "
        "declared. Where a smoothed motion is beside the log by far more than noise is, as where a car was slow in every bend, or a column of a slow one has "
        "another unit, the log is refused: what would be cut out of the motion is not what was driven.",
    ),
    "D178": (
        "a file of a mapping is not here",
        "A log need not be part of the project that names it. Where it is not here, nothing is said about it: neither that something fired, nor that nothing did.",
    ),
}  # fmt: skip


class Faults:
    """Collects what is wrong with one file and raises it as one error: the first, and where the others are."""

    #: More lines than this are counted, not listed.
    LISTED = 8

    def __init__(self) -> None:
        #: The others are counted: a file of a few megabytes may have as many million.
        self._first: TrackmarshalError | None = None
        self._others = 0
        self._lines: list[int] = []

    def add(self, error: TrackmarshalError) -> None:
        if self._first is None:
            self._first = error
            return
        self._others += 1
        if error.line is not None and len(self._lines) <= self.LISTED:
            self._lines.append(error.line)

    def check(self) -> None:
        """Raise the first fault, with the lines of the others in its message; nothing where there is none."""
        first = self._first
        if first is None:
            return
        if not self._others:
            raise first
        listed = ", ".join(map(str, self._lines[: self.LISTED]))
        listed += ", ..." if len(self._lines) > self.LISTED else ""
        more = f" (and {self._others} more" + (f", lines {listed})" if self._lines else ")")
        raise TrackmarshalError(
            first.code, first.message + more, file=first.file, line=first.line, help=first.help
        )
