"""Habits from other languages and common slips, each with what to write instead."""

from __future__ import annotations

import re
import unicodedata

from trackmarshal.syntax.keywords import CLAUSES, DECLARATIONS, RESERVED
from trackmarshal.syntax.names import GREEK
from trackmarshal.units import UNIT_PATTERN

_CLAUSES = frozenset().union(*CLAUSES.values())

#: Texts that start where the error is, longest first, and what to write.
_HERE = {
    "&&": "write `and`", "||": "write `or`", "=>": "write `implies` for a consequence, `>=` to compare",
    "=<": "write `<=`", "//": "a comment starts with `--`", "/*": "a comment starts with `--` and ends with its line",
    "#": "a comment starts with `--`", "->": "write `implies` for a consequence", ":=": "write `=`",
    "&": "write `and`", "|": "write `or`", "!": "write `not`", "~": "write `not`",
    ";": "nothing ends a declaration or a clause but the next one", "'": "strings stand between double quotes",
    "`": "strings stand between double quotes", "?": "write `if CONDITION then A else B`", "@": "names have letters, digits and `_`",
    "$": "names have letters, digits and `_`", "\\": "a long expression goes on in the next line by itself",
    "≦": "write `≤` or `<=`", "≧": "write `≥` or `>=`", "⩽": "write `≤` or `<=`", "⩾": "write `≥` or `>=`",
    "⇒": "write `→` or `implies`", "⟹": "write `→` or `implies`", "⇔": "write `↔` or `iff`", "⟺": "write `↔` or `iff`",
    "⊕": "write `xor`", "×": "write `·` or `*`", "⋅": "write `·` or `*`", "∙": "write `·` or `*`", "÷": "write `/`", "∕": "write `/`",
    "–": "write `-`", "—": "write `-`, or `--` for a comment", "‐": "write `-`", "“": 'write `"`', "”": 'write `"`', "„": 'write `"`',
    "’": 'write `"`', "‘": 'write `"`', "°": "write `deg`", "∞": "write `inf`", "∉": "write `¬ (x ∈ [a, b])`",
    "∄": "write `¬ ∃`", "⁻": "write the exponent as `^-1`", "¹": "an exponent 1 says nothing", "⁴": "write `^4`",
    "\u00a0": "this is a no-break space; write a blank", "\ufeff": "a byte order mark belongs to the start of the file only",
}  # fmt: skip

#: Texts whose second half the parser stumbles over.
_ACROSS = {
    "<>": "write `!=`", "**": "write `^` for a power", "==": "write `=` once, to name a value", "^^": "write `^` once",
    "++": "write `+` once", "->": "write `implies` for a consequence", "/*": "a comment starts with `--` and ends with its line", "//": "a comment starts with `--`", "--": "a comment starts with `--`", "..": "write `[a, b]` for a range", "!!": "write `not`",
}  # fmt: skip

#: Words of other languages where a quantifier or an operator stands.
FOREIGN_WORDS = {
    "forall": "write `for all`", "foreach": "write `for all`", "every": "write `for all`", "each": "write `for all`",
    "all": "write `for all`", "any": "write `exists`", "some": "write `exists`", "elif": "write `else if`", "elseif": "write `else if`",
    "when": "write `whenever`", "unless": "write `whenever not (...)`", "while": "write `whenever`", "shall": "write `require`", "must": "write `require`", "assert": "write `require`",
    "mod": "there is no remainder", "equals": "write `==`", "no": "write `not (exists ...)`", "after": "write `whenever rising(...)`, and `within` for a deadline",
    "AND": "write `and`", "OR": "write `or`", "NOT": "write `not`", "XOR": "write `xor`", "IMPLIES": "write `implies`",
}  # fmt: skip
_COMPARISONS = frozenset(["<", "<=", ">", ">=", "==", "!=", "≤", "≥", "≠"])
#: What makes a formula, where a number ends or begins.
_OF_FORMULAS = _COMPARISONS.union(["not", "¬", "exists", "∃", "for", "∀", "and", "or", "implies"])
#: Nobody wrote a declaration of so many characters by hand, and patterns look at each of them more than once.
_LONG = 20000
#: What is met, what stands before it, and what to write; `FOUND` stands for what is met, without quotes.
_PAIRS = tuple(
    (re.compile(met), re.compile(rf"{behind}\s*\Z"), hint)
    for met, behind, hint in (
        (":", r"\A(?:rule|test|assume)[ \t]+\w+", "no `:` ends a name or a title: the first clause stands in the next line"),
        (":", rf"\n[ \t]+({'|'.join(sorted(_CLAUSES))})", r"no `:` stands behind `\1`"),
        ("[:=]", r"\Aenum[ \t]+\w+", "members stand in braces: `enum flag { green, yellow }`"),
        ("=", r"\Aevent[ \t]+\w+", "an event comes with each cycle's data, and has no value here; what follows from inputs is a `predicate`"),
        (":|if", r"(?:\bfor[ \t]+|\([ \t]*)\w+[ \t]+in[ \t]+\w+", "which of them are meant is said by `where`"),
        (",|and", r"\n[ \t]+(?:for[ \t]+all|exists)[ \t]+\w+[ \t]+in[ \t]+\w+", "each quantifier is a clause of its own, in the next line"),
        (r"\(", r"\b(exists|for[ \t]+all)", r"no parentheses stand behind `\1`: write `\1 o in objects: (...)`"),
        (",", r"\b(for[ \t]+all|exists)[ \t]+(\w+[ \t]+in[ \t]+[\w.]+)", r"what holds stands behind a colon: `\1 \2: (...)`"),
        ("else", r"\bimplies\b[^\n]*", "`implies` has no `else`: write `(a implies b) and (not a implies c)`"),
        ("of", r"[0-9][ \t]*%", "a share of something is a product: write `*`"),
        ("of", r"\bcase[ \t]*\(?[ \t]*([\w.]+)[ \t]*\)?", r"cases stand in braces, without `of`: `case \1 { a: ..., b: ... }`"),
        (".*", r"\b([a-z][\w.]*)[ \t]+change[sd]?(?:[ \t]+to)?", r"say what begins to hold, as in `rising(\1 is a)`"),
        ("becomes", r"\b(?:when|whenever|require|and|or|not)[ \t]+([a-z][\w.]*)", r"say what begins to hold, as in `rising(\1 is a)`"),
        ("[<>]=?|[=!]=", r"\bis", "leave out `is`"),
        (".*", r"\bat[ \t]+most", "write `<=`"),
        (".*", r"\bat[ \t]+least", "write `>=`"),
        (r"\w+", r"\binside[ \t]+zone", "a point stands `in zone FOUND`, a footprint `inside FOUND`"),
        (r"\w+", r"\boutside[ \t]+zone", "write `not (... in zone FOUND)`"),
        (".*", r"\b(?:require|and|or|implies)[ \t]+never[ \t]+\w+", "what never holds is `not (...)`: a rule is asked in every cycle"),
        ("of", r"\bwithin[ \t]+[0-9.]+[ \t]*\w+", "a deadline is two clauses: `whenever rising(...)`, and `within` below it"),
        ("with", r"\bexpect[ \t]+\w+", "write a comma: `expect satisfied, margin 1 m`"),
        ("=", r"\bmargin", "write the number at once: `margin 1 m`"),
        ("with", r"\Atest\b[^\n]*\n(?:[^\0]*\n)?", "what a test gives, parameters too, is a clause each: `given NAME = ...`"),
        (":", r"\Atest\b[^\0]*=[ \t]*\([ \t]*\w+", "a record stands in braces: `{ v: 20 m/s }`"),
        ('"', r"\b(?:is|enum\b[^\n]*\{[^}]*)|\Atest\b[^\0]*[:=,\[]", "a member stands without quotes: `FOUND`"),
        ('"', r"\Ause", "a module stands without quotes: `FOUND`"),
        ("/", r"\Ause[ \t]+[\w.]+", "the parts of a module's name are joined by `.`"),
        (":", r"\n[ \t]+let[ \t]+\w+", "a `let` has no unit of its own: write `=`"),
        (r"\.", r"\b(always|eventually|historically|once|since|until)[ \t]*(\([^()\n]*)\)[ \t]*\w+", r"a window stands in square brackets: `\1[0 s, 2 s]`"),
        (".*", r"\b(always|eventually|historically|once|since|until)[ \t]+([0-9.]+[ \t]*(?:ms|s|min))(?:[ \t]+\w+)?", r"a window stands in square brackets: `\1[0 s, \2]`"),
        ("within|for|in|during", r"\b(always|eventually|historically|once|since|until)", r"a window stands in square brackets, behind the word: `\1[0 s, 2 s]`"),
        ("[A-Z]", r"\b(?:satisfies|assuming)[ \t]+(?:[\w.-]+[ \t]*,[ \t]*)*[\w.-]+", "ids are parted by commas"),
        (r"[0-9]", r"\bsatisfies\b[^\n]*", "an id starts with a capital letter: `S-1-A-4`; what a rule is taken from is its `source`"),
        ('"[A-Z]', r"\b(?:satisfies|assuming)\b[^\n]*", "an id stands without quotes: `FOUND`"),
        ('"', r"\b(?:satisfies|assuming)\b[^\n]*", "an id starts with a capital letter, and stands without quotes: `S-1-A-4`; what a rule is taken from is its `source`"),
        (r"\.[0-9]", r"\b(?:satisfies|assuming)\b[^\n]*", "ids have letters, digits and `-`: `S-1-A-4`; what a rule is taken from is its `source`"),
        (r"\.[0-9]", r"\A(?:rule|test|param|define|predicate|state)[ \t]+\w+", "names have letters, digits and `_`"),
        (r"[0-9]", r"\A(?:rule|test|param|define|predicate|state)", "a name begins with a letter"),
        ('"[0-9]', r"\Aparam\b[^\n]*=", "a number stands without quotes: `FOUND`"),
        (r"[0-9]", r"\bsource[ \t]+(\w+)", r'say of what kind: `source \1 section FOUND`; what is more than a number, such as 5.2.3 or 5 (1), stands between double quotes: `source \1 "..."`'),
        (r"[.(/§–-]", r"\bsource[ \t]+(\w+)[ \t]+(\w+)[ \t]+[0-9., \t]*[0-9]", r'what is more than a number stands between double quotes: `source \1 "\2 ..."`'),
    )
)  # fmt: skip
#: Words of other languages that start a declaration.
FOREIGN_DECLARATIONS = {
    "import": "write `use`", "include": "write `use`", "from": "write `use`", "const": "write `param`", "constant": "write `param`",
    "def": "write `define`, or `predicate` for a formula", "function": "write `define`, or `predicate` for a formula",
    "input": "write `signal`", "assert": "write a `rule` that says `require`",
}  # fmt: skip
_COMMAS = re.compile(r"(?<![\w.,])[0-9]+(?:,[0-9]+)+(?:\.[0-9]+)?(?![\w.,])")
#: What is a formula already, though its margin is a distance.
_HOLDS = re.compile(r"\b(clear_of|inside)\b(?:(?!\b(?:and|or|implies)\b).)*\Z")
_PARTS = re.compile(r"(?<![\w.,])[0-9]+,[0-9]+(?![\w.])")
#: A unit, or the rest of one, whose last part has a digit.
_POWER = re.compile(r"/?(?:[A-Za-z]{1,3}[/*·])*([A-Za-z]{1,3})([23])\b")
#: A number whose digits somebody groups.
_GROUPED = re.compile(r"[0-9]+(?:['_][0-9]+)+")
#: Digits before a blank, and those behind it, where these are in groups of three: `1 000 000`.
_APART = re.compile(r"(?<![\w.,])[0-9]{1,3}(?:[ \u00a0][0-9]{3})*[ \u00a0]\Z")
_THREES = re.compile(r"[0-9]{3}(?:[ \u00a0][0-9]{3})*(?:\.[0-9]+)?(?![\w,])")
_OWN_SIGNS = frozenset("≤≥≠·²³√∀∃∈∧∨¬→↔−").union(GREEK)


def hint_for(text: str, start: int, found: str, before: str, expected: set[str]) -> str:
    """What would mend an error at `start`, or the empty string; `before` is the declaration's code up to it."""
    line = before.rpartition("\n")[2]
    return (
        _foreign_letter(found)
        or _paired(found, before)
        or _between(found, before, expected)
        or _misplaced(text, start, found, before, expected)
        or _sign(text, start, found, expected)
        or _negated(text, start, found, line, expected)
        or _listed(found, line, before, expected)
        or _habit(text, start, found, before, expected)
        or _word(found, line, expected)
        or _structure(found, before, line, expected)
        or _strange(found)
        or _exponent(text, start)
    )


def _paired(found: str, before: str) -> str:
    """What a sign or a word of other languages stands for behind what is there."""
    if len(before) > _LONG:
        return ""
    for met, behind, hint in _PAIRS:
        place = behind.search(before) if met.match(found) else None
        if place:
            return place.expand(hint).replace("FOUND", found.strip('"'))
    return ""


def _between(found: str, before: str, expected: set[str]) -> str:
    """The one sign that may stand here, and what it is for."""
    keyword = before.split(maxsplit=1)[0] if before.split() else ""
    if found == ";" and open_brackets(before):
        return "what stands in brackets is parted by commas"
    if expected == {"COLON"} and open_brackets(before)[-1:]:
        return (
            "each parameter says its unit or its shape: `v: m/s`, `o: vehicle`"
            if keyword in ("define", "predicate", "table")
            else "behind the name of a field stands `:`, as in `v: 20 m/s`, `v: m/s` where it is declared"
        )
    if expected == {"COLON"} and found == "=":
        return "write `:`"
    if expected >= {"_STATE", "_TRAJECTORY"}:
        return "a signal is a `trajectory`, `series`, `state` or `set of object` with its fields in braces, a `corridor`, a `polyline`, or a `set of lane`"
    if expected >= {"DOT", "_BY"}:
        return "say of which number the nearest has the least: `for nearest o in objects by gap(o)`"
    if expected == {"COMMA", "VBAR"} and keyword == "table":
        return "rows stand between bars: `| 0 m/s: 3 m | 10 m/s: 5 m |`"
    if expected == {"_BECOMES", "_BRIDGES"}:
        return "a transition is a clause: `becomes b when ...`, or `becomes b from a when ...`"
    if found.startswith('"') and expected == {"NAME", "ID"}:
        name = re.sub(r"\W+", "_", found.strip('"')).strip("_").lower()
        return f"a name stands before the title: `{keyword} {name or 'name'} {found}`"
    return ""


def _habit(text: str, start: int, found: str, before: str, expected: set[str]) -> str:
    """What other languages, and English, would have here."""
    keyword = before.split(maxsplit=1)[0] if before.split() else ""
    line = before.rpartition("\n")[2]
    if found == "for" and re.match(r"for\s+(the\s+last\s+)?[0-9]", text[start : start + 20]):
        return "what holds for 5 s is `historically[0 s, 5 s] (...)`, of the past, or `always[0 s, 5 s] (...)`, of what comes"
    if found == "unless":
        return 'write `... or EXCEPTION`; behind a `for all`, the clause `except CONDITION "reason"`'
    if found == "if" and not line.strip() and keyword in ("rule", "assume"):
        return "the condition of a rule is a clause of its own: `whenever CONDITION`"
    if found == ":" and re.fullmatch(r"\s*(for\s+all|exists)\b[^(]*", line):
        return "no `:` ends a clause: `require` follows in the next line; `for all p in plan: (...)` is for formulas"
    if found == "|" and keyword == "table" and before.rstrip().endswith("|"):
        return "one `|` stands between two rows: leave out the one at the end of the row above; the last row alone ends with one"
    if alone := re.search(
        r"\b(rising|falling|count)[ \t]+\w+\s*\Z", before
    ):  # read as what `rising` does to something
        return f"what `{alone[1]}` is about stands in parentheses: `{alone[1]}(...)`"
    if found in ("previous", "next") and "MINUS" in expected and "NOT" not in expected:
        return f"of a number there is no `{found}`: samples are compared by `for all consecutive p, q in plan`, and a state may `remember` the number of a cycle"
    if "AND" in expected and not line.strip() and re.match(r"[a-z]\w*\.[a-z]\w*", text[start : start + 80]):
        return "a clause begins with its word, and conditions are joined with `and`"
    if found == "+" and "MINUS" in expected:
        return "a number has no plus sign: leave it out"
    if found == "%" and "TIMES" in expected:
        return FOREIGN_WORDS["mod"]
    if found == "|" and "MINUS" in expected and "AND" not in expected:
        return "write `abs(...)` for an absolute value"
    if found == "," and re.search(r"\bremember\b[^\n]*\Z", line) and not open_brackets(before):
        return "each number is remembered by a `remember` of its own: write another one in the next line"
    if found == "," and "AND" in expected and not open_brackets(before):
        return "join what must hold together with `and`"
    if found == "." and (given := re.search(r"\bgiven\s+(\w+)\Z", before)):
        return f"give the whole record: `{given[1]} = {{ field: value }}`"
    if found.isidentifier() and "STRING" in expected and keyword in ("rule", "test", "event", "zone", "enum"):
        return "a name is one word, and a title stands between double quotes" if "\n" not in before else ""
    return ""


def _exponent(text: str, start: int) -> str:
    """What to write for a unit with a digit behind it, as `m/s2`."""
    unit = _POWER.match(text, start)
    return f"an exponent stands behind `^`: `{unit[1]}^{unit[2]}`" if unit else ""


def _negated(text: str, start: int, found: str, line: str, expected: set[str]) -> str:
    """A `not` in the middle, where English has it."""
    if found != "not":
        return ""
    if re.search(r"\bis\s*\Z", line):
        said = re.search(r"([\w.]+(?:\(\w+\))?)\s+is\s*\Z", line)
        member = re.match(r"not\s+(\w+)", text[start : start + 80])
        return f"write `not ({said[1]} is {member[1]})`" if said and member else "write `not (... is ...)`"
    if re.match(r"not\s+(in|inside|clear_of|meets)\b", text[start : start + 20]) and "COMPARE" in expected:
        return "`not` stands in front: `not (x in [a, b])`"
    return ""


def _listed(found: str, line: str, before: str, expected: set[str]) -> str:
    """What is written together elsewhere, and here one by one; brackets of another form."""
    keyword = before.split(maxsplit=1)[0] if before.split() else ""
    asked = re.search(r"([\w.]+)\s+in\s*\Z", line)
    if found == "{" and "_ZONE" in expected and asked:
        return f"ask for each: `{asked[1]} is a or {asked[1]} is b`; a range of numbers stands in square brackets"
    if re.search(r"\bin\s*\[[^\[\]]*\]\s*\Z", line) and re.fullmatch(
        rf"{UNIT_PATTERN}(?:/{UNIT_PATTERN})*", found
    ):
        return f"each end of a range has its unit: `in [1 {found}, 2 {found}]`"
    if found == "]" and re.search(
        r"\b(?:always|eventually|until|once|historically|since)\s*\[[^\],]*\Z", line
    ):
        return "a window has two bounds: `[0 s, 3 s]`"
    if found == "," and keyword in ("zone", "line") and line.rstrip().endswith(")"):
        return "points stand side by side, without commas: `(0 m, 0 m) (1 m, 0 m)`"
    if found == "," and keyword == "param" and not open_brackets(before):
        return "each parameter has a `param` of its own, in the next line"
    if found == "(" and keyword == "param" and re.search(r"\bin\s*\Z", line):
        return "a range stands in square brackets, `in [0, 3]`, and both ends belong to it"
    if (
        keyword == "test"
        and re.search(r"\bexpect\s*\Z", line)
        and found in ("true", "false", "safe", "unsafe", "not")
    ):
        return "a test expects `satisfied`, `violated`, `inactive`, `undefined` or `open`"
    return ""


def _misplaced(text: str, start: int, found: str, before: str, expected: set[str]) -> str:
    """What belongs to another declaration, or to another place of this one."""
    keyword = before.split(maxsplit=1)[0] if before.split() else ""
    if keyword == "predicate" and text.startswith("->", start) and "EQUAL" in expected:
        return "a predicate is a formula, and has no unit: write `=`, or `define` for a number"
    if (
        keyword == "define"
        and found in _OF_FORMULAS
        and not open_brackets(before)
        and re.search(r"=[^=]*\Z", before)
    ):
        name = re.match(r"define\s+(\w+)", before)
        return f"a `define` is a number: a formula is named by `predicate{f' {name[1]}' if name else ''}`"
    if keyword == "signal" and found in ("in", "∈") and re.search(r"\bdefault\b[^,{}]*\Z", before):
        return "the range of a field comes before its default: `v: m/s in [0, 20] default 0 m/s`"
    return ""


def _sign(text: str, start: int, found: str, expected: set[str]) -> str:
    for number in _COMMAS.finditer(text, max(0, start - 40), start + 40):
        if number.start() < start < number.end():
            return _without_comma(number.group())
    if found == "," and (before := text[_line_start(text, start) : start]) and expected & {"RSQB", "RPAR"}:
        # Of `in [0,5 m, 2,5 m]` and `(0,5 m, 1 m)`, the second comma is one too many.
        opened = open_brackets(before)
        parts = _PARTS.search(before, opened[-1][1] if opened else 0)
        if parts:
            return _without_comma(parts.group())
    if found == "(" and "TIMES" in expected and re.search(r"[0-9)][ \t]*\Z", text[:start]):
        return "write `*` to multiply"
    if found == "=" and "COMPARE" in expected and "COLON" in expected:
        return "an argument stands behind its name and `:`, such as `v: 20 m/s`; `==` compares"
    if found == "=" and text[start + 1 : start + 2] not in "=<>" and "COMPARE" in expected:
        return "write `==` to compare"
    if found[:1] in ("'", "_") and text[max(0, start - 1) : start].isdigit():
        begin = re.search(r"[0-9]+\Z", text[:start])
        grouped = _GROUPED.match(text, begin.start()) if begin else None
        together = re.sub("['_]", "", grouped[0]) if grouped else "10000"
        return f"digits of a number stand together: `{together}`"
    if (apart := _APART.search(text, max(0, start - 40), start)) and (rest := _THREES.match(text, start)):
        together = "".join((apart[0] + rest[0]).split())
        return f"digits of a number stand together: `{together}`"
    if found == "==" and "EQUAL" in expected:
        return "write `=` to name a value; `==` compares"
    if found == "=" and text[max(0, start - 2) : start] == "==":
        return "write `==` to compare"
    if found in _COMPARISONS and text[start - 1 : start + 1] not in (
        "<>",
        "->",
    ):
        if expected & {"AND", "OR"} and "COMPARE" not in expected:
            if re.search(
                r"\bmod\b", text[_line_start(text, start) : start]
            ):  # read as a predicate between two things
                return FOREIGN_WORDS["mod"]
            holds = _HOLDS.search(text[_line_start(text, start) : start])
            if holds:
                return f"`{holds[1]}` holds or does not; to keep a distance, make the footprint larger: `footprint(p, length + 1 m, width + 1 m)`"
            return "join what must hold together with `and`"
        return ""
    for length in (2, 1):
        hint = _HERE.get(text[start : start + length])
        if hint and (found != "|" or "AND" in expected) and (found != "~" or "NOT" in expected):
            return hint
    return _ACROSS.get(text[max(0, start - 1) : start + 1], "") if found else ""


def _line_start(text: str, at: int) -> int:
    return text.rfind("\n", 0, at) + 1


def _without_comma(number: str) -> str:
    """What to write for a number with a comma, which some read as a decimal point and some as nothing."""
    if re.fullmatch(r"[0-9]+,[0-9]+", number) and not re.fullmatch(r"[1-9][0-9]{0,2},[0-9]{3}", number):
        return f"numbers have a decimal point: `{number.replace(',', '.')}`"
    if re.fullmatch(r"[0-9]+,[0-9]+", number):
        return f"write `{number.replace(',', '.')}` or `{number.replace(',', '')}`: numbers have no commas"
    return f"write `{number.replace(',', '')}`: numbers have no commas"


def _word(found: str, line: str, expected: set[str]) -> str:
    if found == "to" and "COMPARE" in expected:
        return "a predicate that is called `to` stands before its arguments: write `to(a, b)`, or rename it"
    if found == "for":
        return "write `for all NAME in DOMAIN`" if expected & {"_FOR_ALL", "NOT"} else ""
    if found == "if" and expected & {"COMPARE", "AND"}:
        return "a condition comes first: `whenever CONDITION` above `require`, or `CONDITION implies ...`"
    if found == "then" and re.match(r"\s*whenever\b", line):
        return "what must hold then is said by `require`, in the next line"
    if found in RESERVED and expected <= {"NAME", "ID", "CONSECUTIVE"} and expected:
        return f"`{found}` is a word of the language and cannot be a name"
    if found in DECLARATIONS and "NAME" not in expected:
        return f"a declaration starts in column 1: remove the blanks before `{found}`, if it is one"
    if found in RESERVED and "$END" in expected and not expected & {f"_{found.upper()}"}:
        owners = [keyword for keyword, words in CLAUSES.items() if found in words]
        if owners:
            return f"`{found}` is a clause of {' and '.join(f'`{keyword}`' for keyword in owners)}"
    # `forall p in plan` reads as a predicate `p` between two things until the `in`.
    quantifier = re.search(r"([a-z]+)\s+\w+\s*\Z", line)
    if found in ("in", "∈") and quantifier and quantifier[1] in FOREIGN_WORDS:
        return FOREIGN_WORDS[quantifier[1]]
    if found in RESERVED and "NAME" in expected and not expected & {"NOT", "MINUS"}:
        return f"`{found}` is a word of the language and cannot be a name"
    return FOREIGN_WORDS.get(found, "")


def _structure(found: str, before: str, line: str, expected: set[str]) -> str:
    keyword = before.split(maxsplit=1)[0] if before.split() else ""
    clause = next((word for word in reversed(re.findall(r"[a-z]+", before)) if word in _CLAUSES), keyword)
    if keyword == "param" and "COLON" in expected and found == "=":
        return "a parameter states its unit: `param mass: kg = 1160 kg`; the unit of a plain number is 1"
    if expected == {"UNIT"} or (keyword == "param" and "UNIT" in expected):
        return "the unit of a plain number is 1"
    if expected == {"STRING"} or (clause == "source" and "STRING" in expected):
        return "put the text between double quotes" if found and found not in RESERVED else ""
    if clause == "except" and "STRING" in expected and "AND" in expected:
        return 'an exception says why: `except CONDITION "reason"`'
    if found == "-" and not expected & {"MINUS"}:
        lower = re.search(r"\b([a-z])\w*\Z", line)
        if lower and clause in ("satisfies", "assuming", "assume"):
            return "an id starts with a capital letter: `S-1-A-4`"
        return (
            "names have letters, digits and `_`"
            if expected & {"DOT", "EQUAL", "COLON", "STRING", "$END"}
            else ""
        )
    if "LSQB" in expected and "_ZONE" in expected and found.isidentifier():
        return f"for a range write `in [a, b]`, for a place `in zone {found}`"
    if "LSQB" in expected and "_ZONE" in expected and re.match(r"[(0-9]", found):
        return "a range stands in square brackets, `in [a, b]`, and both ends belong to it"
    if found in ("{", "}") and keyword in ("rule", "assume", "state", "test"):
        return "clauses stand without braces"
    bracketed = re.search(r"([0-9.]+)[ \t]*\Z", before)
    if found == "[" and bracketed:
        return f"units stand without brackets: `{bracketed[1]} m/s`"
    if found == "[" and "DOT" in expected:
        return "a column is not indexed: bind its samples with `for all p in plan`"
    if re.search(r"[0-9]\.\s*\Z", before) and expected == {"NAME"}:
        return "a number with a point has digits after it"
    if "_ELSE" in expected and re.search(r"\bif\b", before):
        return "an `if` chooses between two numbers, `if C then a else b`; between two conditions: `(C implies A) and (C or B)`"
    if "_ELSE" in expected and found == "," and "COMPARE" not in expected:
        return "a number of many ranges over one: of two, it is one in the other, `min(min(... for p in plan) for o in objects else ...)`"
    if not found and "_EXPECT" in expected:
        return "a test says what it expects: `expect satisfied`"
    if found and found in ")]}" and not open_brackets(before):
        return f"nothing is open that `{found}` could close"
    if found == ":" and re.search(r"\b(for[ \t]+all|exists)\b", line) is None and "EQUAL" in expected:
        return "write `=`"
    if found[:1] in ('"', "{") and expected == {"EQUAL"}:
        return "write `=` before it"
    return ""


def open_brackets(code: str) -> list[tuple[str, int]]:
    """The brackets of a text without strings and comments that are not closed in it, outermost first."""
    stack: list[tuple[str, int]] = []
    for offset, char in enumerate(code):
        if char in "([{":
            stack.append((char, offset))
        elif char in ")]}" and stack:
            stack.pop()
    return stack


def _foreign_letter(found: str) -> str:
    """A letter of another alphabet, as in `größe`; Greek ones are words of this language."""
    if not found[:1].isalpha() or found[0].isascii() or found[0] in _OWN_SIGNS or not _strange(found[0]):
        return ""
    return f"names have the letters a to z and A to Z, digits and `_`: {_strange(found[0])}"


def _strange(found: str) -> str:
    if len(found) != 1 or found.isascii() or found in _OWN_SIGNS:
        return ""
    name = unicodedata.name(found[0], "")
    return f"the character is U+{ord(found[0]):04X} {name}".rstrip()
