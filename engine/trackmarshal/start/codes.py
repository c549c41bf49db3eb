"""Error codes of what starts a project, or a piece of one."""

CODES = {
    "E412": (
        "something is there already",
        "`trackmarshal init` and `trackmarshal new` only write what is new: where one of their files is there, or what they are to declare is declared, they write nothing"
        " at all. Choose another folder or another name, or edit what is there. What other verbs write, such as `show --out`, takes the place of nothing but a file of its kind; only what fills "
        "a folder that is named for it (`assess`, `case`, `gsn --out`, `replay --out`) is written over files of the same names there.",
    ),
    "E413": (
        "a name that cannot be used",
        "`trackmarshal new` calls files and declarations by the name that it is given: a rule, a rulebook and a scenario by a word of letters, digits and `_` that the"
        " language has no other use for, a requirement by an id such as `R-2` or `S-1-A-4`.",
    ),
    "E414": (
        "nothing to begin with",
        "A new rule reads a signal that the project's specs declare, and a new rulebook puts the project's rules into an order. Where there is none yet, there is nothing that could"
        " be written and would pass `trackmarshal check`.",
    ),
}
