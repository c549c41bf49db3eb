"""Tables that are not `linear clamp` of one argument, in C: what they are made of, and the constants of those of two arguments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.ir.tables import Way

_AXIS = """/* The knots of one argument of a table, and how it is read along them; length: of a period, or 0. */
typedef struct {
  const double *knots;
  size_t count;
  bool steps;
  bool clamped;
  double length;
} tm_table_axis;

/* Where an argument lies among knots: between those of two, or at one. */
typedef struct {
  size_t low;
  size_t high;
  double start;
  double end;
  double at;
  bool known;
} tm_table_spot;
"""
_GRID = """/* A table of two arguments; its cells are row by row. */
typedef struct {
  tm_table_axis rows;
  tm_table_axis columns;
  const double *cells;
} tm_table_grid;
"""


def types(plan: Layout) -> Iterator[str]:
    """Types and constants that come before the functions."""
    if plan.grids or plan.other_ways:
        yield _AXIS
    if plan.grids:
        yield _GRID
    for name, c_name in plan.grids.items():
        info, own = plan.spec.tables[name], f"tm_grid_{c_name}"
        assert info.across is not None
        text = f"/* {comment(name)} {comment(str(info.span))} */\n"
        text += _array(f"{own}_down", info.knots) + _array(f"{own}_across", info.across.knots)
        text += _array(f"{own}_cells", info.values)
        rows, columns = (
            _axis(f"{own}_down", info.knots, info.way),
            _axis(f"{own}_across", info.across.knots, info.across.way),
        )
        yield f"{text}static const tm_table_grid {own}_whole = {{{rows}, {columns}, {own}_cells}};\n"


def _array(name: str, values: Sequence[float]) -> str:
    return f"static const double {name}[{len(values)}] = {{{', '.join(map(literal, values))}}};\n"


def _axis(name: str, knots: Sequence[float], way: Way) -> str:
    steps, clamped = ("true" if each else "false" for each in way[:2])
    return f"{{{name}, {len(knots)}u, {steps}, {clamped}, {literal(way.length)}}}"
