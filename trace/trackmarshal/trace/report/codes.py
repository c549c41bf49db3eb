"""Codes of what can go wrong while pages are written."""

CODES = {
    "T291": (
        "a run that cannot be reported",
        "A run handed to the report is no record of a run (`trackmarshal.scenarios.run_record`), is of a newer version, or its columns do "
        "not have one entry a cycle. A page drawn from it could show something that never happened, so none is written.",
    ),
    "T292": (
        "the report cannot be written",
        "The folder of the report cannot be made or written to: it is a file, is not writable, or the disk is full.",
    ),
}
