"""What can be wrong with making the document: title and explanation by code, for `trackmarshal explain CODE`."""

from __future__ import annotations

CODES = {
    "T430": ("a template of the safety case that cannot be used", "A project may replace templates of the safety case: `document`, `blocks`, `section`, or one by the name of a section, such as `hazards.html.j2`. This one cannot be read, is no jinja2 template, or names something that is not in the document."),
    "T431": ("no folder of templates", "The folder that is to hold templates of the safety case is not there."),
    "T432": ("no PDF without typst", "The PDF of the safety case is set by typst, which comes with the extra `pdf` of this package. The HTML is whole without it."),
    "T433": ("the PDF could not be set", "Typst refuses the source of the document. Where the project has templates of its own, one of them is the likely cause; the source stands beside the HTML."),
    "T434": ("no such language, or no file of words", "The words of the safety case come in the languages of the program, or from a file of words, which begins with `format: trackmarshal-case-words`, `version: 1` and `words:`. This is neither, or it cannot be read."),
    "T435": ("words that are missing", "A file of words has all the words that the program has in English: with some of them missing, the document would be in two languages. The message lists them."),
    "T436": ("a word that does not fit", "A word of a file of words is none that the document has, has other places to fill in than the English one, or has a number in it. Numbers of the document come from the link graph, so that each can be found there again."),
    "T437": ("results of a closed loop that cannot be used", "The file that v-model.yaml names under `closed_loop` holds no results of runs in a closed loop, or some that lack what the safety case says of them."),
    "T438": ("letters that the PDF has no font for", "The PDF is set in fonts that come with typst, whatever fonts the machine has, so that it is the same everywhere. They have no glyph for these letters; `‹U+6F22›` stands for each of them in the PDF. The HTML has the letters themselves."),
    "T439": ("a template that nothing uses", "A template of a project stands in place of one of the program's by having its name: `document`, `blocks`, `section`, or a section's, with `.html.j2` or `.typ.j2` behind it, or `style.css`. This one has none of these names, and no other template of the project names it, so that the document would be as if it were not there."),
}  # fmt: skip

__all__ = ["CODES"]
