"""What can be wrong with an argument, and with showing it: title and explanation by code, for `trackmarshal explain CODE`."""

from __future__ import annotations

CODES = {
    "T400": ("a template that there is not", "A step of the argument names a template that the document does not have, or two templates have one name. What it would have made is missing from the argument."),
    "T401": ("other than one top goal", "An argument has one root: a goal that supports nothing, and that all else leads up to."),
    "T402": ("an element that the top goal does not reach", "The element stands beside the argument: nothing that leads down from the top goal comes to it, so it argues for nothing."),
    "T403": ("a circle in the argument", "Elements support each other in a circle, so that a claim would rest on itself. The path is printed."),
    "T404": ("support by what cannot support", "A goal is supported by goals, strategies and solutions, a strategy by goals (and by solutions where nothing is left to argue), and nothing else is supported."),
    "T405": ("context in the wrong place", "Contexts, assumptions and justifications stand in the context of a goal or a strategy, and nothing else stands in a context."),
    "T406": ("a leaf without support", "A goal or a strategy at the end of the argument is supported, or is marked as undeveloped, so that everybody sees that it is not argued for."),
    "T407": ("undeveloped and supported", "An element that is marked as undeveloped has support all the same. One of the two is wrong."),
    "T408": ("a solution that is no leaf", "A solution refers to evidence. What needs support itself is a goal."),
    "T409": ("a solution without evidence", "A solution has to lead to evidence that is there and is known by its hash; else nobody can say what it was when the argument was made."),
    "T410": ("a link to no element", "The element that the link names is not in the argument."),
    "T411": ("an away goal that cites nothing", "An away goal cites a public goal of another module: the module, the goal in it, and that others may rely on it, all have to be so."),
    "T412": ("a defeater of nothing", "A defeater challenges an element of the argument. What it names is none, or is a defeater itself."),
    "T413": ("an open defeater", "Somebody, or a result, says that an element of the argument does not hold, and nobody has answered. An argument is not released with that."),
    "T414": ("support by what is defeated", "A defeater was upheld: the element does not hold, and so supports nothing, nor do claims hold that it stands beside. It is argued anew, or taken out of the argument."),
    "T415": ("an element that is not filled in", "The text of the element still has a name in braces: what its template says of its subject was not there to be said."),
    "T416": ("an id given twice", "Two different elements of the argument have one id, over all modules."),
    "T417": ("a link given twice, or to itself", "The same link stands twice, or leads from an element to itself. It adds nothing."),
    "T418": ("a confidence point without a place", "An assurance claim point names an element of the argument, or a link between two, by the elements at its ends."),
    "T419": ("the top goal is not supported", "Something below the top goal failed, is stale, is missing, or is not argued for. The message names the way down to it."),
    "T420": ("a template that does not fit", "A step goes over links that the subject does not have, or leads to another kind of things than its template is about."),
    "T421": ("a requirement that is not argued for", "A requirement of the project is demanded, and no element of the argument is about it."),
    "T422": ("a challenge by what is no defeater", "Challenges come from counter goals and counter solutions, and these do nothing else than challenge, or support a counter goal."),
    "T423": ("a defeater without an answer", "A defeater that is answered says how."),
    "T424": ("no layout engine", "Pictures are laid out by graphviz-pure, which comes with the extra `gsn` of this package. Text, YAML and JSON need none."),
    "T425": ("the layout engine failed", "The program that lays out pictures did not do it, or answered with something else than positions."),
    "T426": ("no such module", "The argument has no module of this name."),
    "T427": ("more than one picture for one output", "Every module is a picture and a file of its own. One of them goes to the standard output; all of them go to a folder."),
}  # fmt: skip

__all__ = ["CODES"]
