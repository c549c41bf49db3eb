"""Names of a spec as C identifiers, numbers as C literals, text that is safe in comments."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from trackmarshal.source import Span

_PLAIN = re.compile(r"[ -~]*")
#: Keywords of C and C++, newer standards' and common extensions included: the header may end up in any program.
_KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long register restrict"
    " return short signed sizeof static struct switch typedef union unsigned void volatile while bool true false alignas alignof"
    " constexpr nullptr static_assert thread_local typeof typeof_unqual asm fortran and and_eq bitand bitor catch char8_t char16_t"
    " char32_t class co_await co_return co_yield compl concept const_cast consteval constinit decltype delete dynamic_cast explicit"
    " export friend mutable namespace new noexcept not not_eq operator or or_eq private protected public reinterpret_cast requires"
    " static_cast template this throw try typeid typename using virtual wchar_t xor xor_eq"
)
#: Macros in lower case: of the standard headers, and of compilers that are not asked for strict C.
_MACROS = (
    "complex imaginary noreturn errno stdin stdout stderr assert offsetof math_errhandling fpclassify isfinite isinf isnan isnormal"
    " signbit isgreater isgreaterequal isless islessequal islessgreater isunordered"
    " unix linux i386 arm mips sparc sun vax hpux vms near far huge pascal cdecl interface"
)
#: Members of our own structs, beside which names of a spec stand.
_MEMBERS = "count id unused"
#: What functions of ours may call or name: no local variable of theirs is called so.
_FUNCTIONS = (
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim floor fma fmax fmin fmod frexp"
    " hypot ilogb j0 j1 jn ldexp lgamma llrint llround log log10 log1p log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow"
    " remainder remquo rint round scalbln scalbn sin sinh sqrt tan tanh tgamma trunc y0 y1 yn signgam gamma main"
)
_TYPES = "size_t ptrdiff_t wchar_t max_align_t float_t double_t int8_t int16_t int32_t int64_t uint8_t uint16_t uint32_t uint64_t"
RESERVED = frozenset(f"{_FUNCTIONS} {_TYPES}".split(" "))
_KNOWN = frozenset(" ".join([_KEYWORDS, _MACROS, _MEMBERS]).split(" "))
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def plain(name: str) -> bool:
    """Whether a name is a C identifier as it stands."""
    return _WORD.fullmatch(name) is not None and name.casefold() not in _KEYWORDS.split(" ")


@lru_cache(maxsize=4096)
def identifier(name: str) -> str:
    """A C identifier for a name of a spec, which is nothing to the compiler and to no header.

    What C does not know is spelled out. A name ends in an underscore where it is a keyword or a macro, or might be one: all in
    capitals, or with our own prefix `tm_`; one that begins with an underscore or a digit begins with an n instead.
    """
    text = "".join(
        c if c.isascii() and (c.isalnum() or c == "_") else "_" if c in ".-" else f"u{ord(c):x}" for c in name
    )
    if not text or text[0].isdigit() or text[0] == "_":
        text = f"n{text}"
    folded = text.casefold()
    return f"{text}_" if folded in _KNOWN or text.isupper() or "tm_" in folded else text


def distinct(
    names: Iterable[str], taken: Iterable[str] = (), endings: tuple[str, ...] = ()
) -> dict[str, str]:
    """Names to C identifiers, no two alike, not even in capitals: macros are made of them.

    None is one of those that are taken (in lower case), and none ends in one of the endings.
    """
    used = set(taken)
    result: dict[str, str] = {}
    for name in names:
        base = identifier(name)
        made = base = f"{base}_" if endings and base.casefold().endswith(endings) else base
        number = 2
        while made.casefold() in used:
            made = f"{base}_{number}"
            number += 1
        used.add(made.casefold())
        result[name] = made
    return result


def literal(value: float) -> str:
    """A double as a C constant expression of exactly that value."""
    if math.isnan(value):
        return "TM_NAN"
    if math.isinf(value):
        return "TM_INF" if value > 0 else "(-TM_INF)"
    text = repr(value)
    if not re.search(r"[.e]", text):
        text += ".0"
    return f"({text})" if text.startswith("-") else text


@lru_cache(maxsize=4096)
def comment(text: str) -> str:
    """Text inside a C comment: one line, printable ASCII, no comment marks."""
    return _harmless(" ".join(text.split()))


def where(span: Span) -> str:
    """File and line of a place in a spec, inside a C comment."""
    return comment(f"{span.file.path}:{span.line}")


def written(text: str) -> tuple[str, ...]:
    """Lines of text inside a C comment, as they are laid out: printable ASCII, no comment marks."""
    return tuple(_harmless(line.expandtabs().rstrip()) for line in text.splitlines())


def _harmless(line: str) -> str:
    flat = line.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").replace("??", "? ?")
    return flat if _PLAIN.fullmatch(flat) else "".join(c if " " <= c <= "~" else "?" for c in flat)
