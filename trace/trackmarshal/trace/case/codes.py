"""What can be wrong with making the document: title and explanation by code, for `trackmarshal explain CODE`."""

from __future__ import annotations

CODES = {
    "T430": ("a template of the safety case that cannot be used", "A project may replace templates of the safety case: `document`, `blocks`, `section`, or one by the name of a section, such as `hazards.html.j2`. This one cannot be read, is no jinja2 template, or names something that is not in the document."),
    "T431": ("no folder of templates", "The folder that is to hold templates of the safety case is not there."),
    "T432": ("no PDF without typst", "The PDF of the safety case is set by typst, which comes with the extra `pdf` of this package. The HTML is whole without it."),
    "T433": ("the PDF could not be set", "Typst refuses the source of the document. Where the project has templates of its own, one of them is the likely cause; the source stands beside the HTML."),
}  # fmt: skip

__all__ = ["CODES"]
