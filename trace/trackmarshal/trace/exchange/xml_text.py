"""XML that is read whole, or not at all: no entities, no cut files, a bound on its depth."""

from __future__ import annotations

import re
from xml.parsers import expat

from trackmarshal.trace.exchange.refused import Refused

#: What XML 1.0 has no characters for.
XML_CHARACTERS = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_MAX_DEPTH = 200
_DECLARED = re.compile(r"""^(\s*<\?xml[^>]*?)\s+encoding\s*=\s*["']([^"']*)["']""")


def checked(data: bytes, shown: str) -> str:
    """The text of a well-formed XML file without its declared encoding and its comments, with the lines that it has; raises T350, T353."""
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as problem:
        line = data.count(b"\n", 0, problem.start) + 1
        raise Refused(
            "T350",
            f"byte {data[problem.start]:#04x} at offset {problem.start} is not {encoding.removesuffix('-sig').upper()}",
            shown,
            line,
            "save the file as UTF-8",
        ) from None
    declared = _DECLARED.match(text)
    if declared and declared[2].lower() not in ("utf-8", "utf8", "us-ascii", "utf-16"):
        raise Refused("T350", f"the encoding `{declared[2]}` is not read", shown, 1, "save the file as UTF-8")
    if declared:
        text = declared[1] + text[declared.end() :]
    depth, kept, ended = 0, bytearray(), 0
    parser = expat.ParserCreate("utf-8")

    def begins(*_: object) -> None:
        nonlocal depth
        depth += 1
        if depth > _MAX_DEPTH:
            raise Refused(
                "T350",
                f"nested more than {_MAX_DEPTH} deep",
                shown,
                parser.CurrentLineNumber,
                "no list of requirements needs such depth",
            )

    def ends(_: str) -> None:
        nonlocal depth
        depth -= 1

    def comments(*_: object) -> None:  # and instructions: the package takes either for an element
        nonlocal ended
        start = parser.CurrentByteIndex
        kept.extend(whole[ended:start])
        end = b"-->" if whole.startswith(b"<!--", start) else b"?>"
        ended = whole.index(end, start) + len(end)
        kept.extend(b"\n" * whole.count(b"\n", start, ended))

    def refuse(*_: object) -> None:
        raise Refused(
            "T353",
            "the file declares a document type, with which entities come",
            shown,
            parser.CurrentLineNumber,
            "ReqIF has none: remove `<!DOCTYPE ...>`",
        )

    parser.StartElementHandler, parser.EndElementHandler, parser.StartDoctypeDeclHandler = (
        begins,
        ends,
        refuse,
    )
    parser.CommentHandler = parser.ProcessingInstructionHandler = comments
    try:
        whole = text.encode("utf-8")
        parser.Parse(whole, True)
    except expat.ExpatError as problem:
        said = expat.ErrorString(problem.code)
        raise Refused("T350", f"not XML: {said}", shown, problem.lineno, "is the file whole?") from None
    except UnicodeEncodeError:
        raise Refused("T350", "not XML: half of a character", shown, help="save the file as UTF-8") from None
    return (kept + whole[ended:]).decode("utf-8")
