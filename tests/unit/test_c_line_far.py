"""What generated C leaves out as farther than a bound beside the line of a border segment, against the distance that is worked out."""

from __future__ import annotations

import cmath
import random
import subprocess
from pathlib import Path

import numpy as np
import pytest

from trackmarshal.backends.c.build import EXACT, FAST, compiler, own_machine
from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import loads

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

SPEC = """module beside
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m }
signal track : corridor { left: polyline, right: polyline }
rule curved "made up"
  for all p in plan
  require swept_footprint(p, 4.7 m, 2.8 m) inside track
"""
#: Reads two poses and a segment each; says how far that is from what is swept straight between both, and which of some bounds around that
#: distance it is beyond.
MAIN = """
#include <stdio.h>
#include <stdlib.h>

int main(void) {
  tm_context *c = calloc(1, sizeof *c);
  double length, width, x[2], y[2], heading[2];
  while (scanf("%lf %lf %lf %lf %lf %lf %lf %lf", &length, &width, &x[0], &y[0], &heading[0], &x[1], &y[1], &heading[1]) == 8) {
    tm_ends *e = &c->ends[0];
    if (scanf("%lf %lf %lf %lf", &e->ax, &e->ay, &e->bx, &e->by) != 4) return 1;
    tm_stretch stretch;
    tm_curve curve;
    tm_sweep sweep;
    tm_stretch_of(&stretch, x, y, heading, 2, length, width);
    const double ahead = stretch.frame.ahead, aside = stretch.frame.aside;
    stretch.ua[0] = (float)(ahead * (e->ax - stretch.ox) + aside * (e->ay - stretch.oy));
    stretch.va[0] = (float)(ahead * (e->ay - stretch.oy) - aside * (e->ax - stretch.ox));
    stretch.ub[0] = (float)(ahead * (e->bx - stretch.ox) + aside * (e->by - stretch.oy));
    stretch.vb[0] = (float)(ahead * (e->by - stretch.oy) - aside * (e->bx - stretch.ox));
    static tm_shape shape;
    shape.known = false;
    tm_straight(&shape, x[0], y[0], heading[0], x[1], y[1], heading[1], &curve);
    tm_sweep_piece(&curve, 0, length, width, TM_INF, &sweep);
    (void)tm_sweep_nearer(c, 0, &sweep);
    const double apart = sweep.entered ? 0.0 : sweep.best;
    const double least = apart - 1e-3 - 3e-5 * (length + width);
    printf("%.17g %d %d\\n", apart, tm_line_far(&stretch, 0, 0, 1, length, width, apart),
           least > 0.0 && tm_line_far(&stretch, 0, 0, 1, length, width, least));
  }
  free(c);
  return 0;
}
"""
#: Length and width.
BODIES = [(4.7, 2.8), (1.0, 0.5), (12.0, 2.5), (0.02, 0.01)]


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    spec = loads(SPEC)
    source = generate(spec, spec.rules)
    folder = tmp_path_factory.mktemp("line")
    (folder / f"{source.name}.h").write_text(source.header, encoding="utf-8")
    (folder / "line_far.c").write_text(source.source + MAIN, encoding="utf-8")
    command = [
        *(compiler() or []),
        *EXACT,
        *FAST,
        *own_machine(),
        "-w",
        "line_far.c",
        "-o",
        "line_far",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "line_far"


def drawn(r: random.Random) -> str:
    """Two poses, and a segment beside them: mostly along them, on either side, as a border to the right is and the other way round."""
    length, width = r.choice(BODIES)
    place, heading = complex(r.uniform(-50, 50), r.uniform(-50, 50)), r.uniform(-4, 4)
    turn, step = r.uniform(-0.38, 0.38), r.choice([0.0, r.uniform(0, 2 * length)])
    after = place + cmath.rect(step, heading + turn / 2)
    beside = r.choice([-1, 1]) * width * r.uniform(0.55, 2.0)
    near = place + cmath.rect(1.0, heading) * complex(r.uniform(-0.7, 0.7) * length, beside)
    leaning = r.choice([r.uniform(-0.3, 0.3), r.uniform(-4, 4)]) + r.choice([0.0, cmath.pi])
    far = near + cmath.rect(length * r.choice([0.01, 0.5, 3.0]), heading + leaning)
    poses = (place.real, place.imag, heading, after.real, after.imag, heading + turn)
    return " ".join(map(repr, (length, width, *poses, near.real, near.imag, far.real, far.imag)))


def test_what_is_left_out_is_farther_away(program: Path) -> None:
    r = random.Random(7)
    given = "\n".join(drawn(r) for _ in range(100_000))
    done = subprocess.run([program], input=given, capture_output=True, text=True, check=True)
    apart, beyond, within = np.array([line.split() for line in done.stdout.splitlines()], dtype=np.float64).T
    assert apart.size == 100_000
    assert not beyond.any()
    assert within.mean() > 0.1  # the line's distance is that of the sweep
