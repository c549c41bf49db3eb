"""A C program that hands mutated cycles to the generated door and holds it against a plain reading of the contract.

The arrays are as long as the capacities and not one entry longer, so that the address sanitizer sees whoever reads beyond them.
"""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.ir.spec import FieldType, Spec

#: Capacities that the driver is compiled with.
SAMPLES, ELEMENTS = 24, 6


def driver(spec: Spec) -> str:
    """The program: arguments are the number of cycles and the seed; it prints how many were admitted, and aborts on a lie."""
    return "\n".join([*_tables(spec), _PROGRAM])


def _tables(spec: Spec) -> Iterator[str]:
    plan = [f for f in spec.signals["plan"].fields_ if f.kind == "number"]
    yield '#include "supervisor.h"'
    yield "#include <float.h>\n#include <math.h>\n#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>"
    yield f"enum {{ SAMPLES = {SAMPLES}, ELEMENTS = {ELEMENTS}, PLAN = {len(plan)} }};"
    yield "typedef struct { const char *name; double low; double high; } range;"
    for name in ("plan", "objects", "obstacles", "ego"):
        fields = [f for f in spec.signals[name].fields_ if f.kind == "number"]
        yield f"static const range {name}_range[{len(fields)}] = {{{', '.join(map(_range, fields))}}};"
        if name != "ego":
            yield f"static double *{name}_column[2][{len(fields)}];"
            yield f"static size_t {name}_count[2];"
        yield f"enum {{ {name.upper()}_FIELDS = {len(fields)} }};"
    yield "static void wire(tm_input *in, int side) {"
    for name in ("plan", "objects", "obstacles"):
        at = "side" if name == "plan" else "0"
        yield f"  in->{name}.count = {name}_count[{at}];"
        for k, field in enumerate(f for f in spec.signals[name].fields_ if f.kind == "number"):
            yield f"  in->{name}.{field.name} = {name}_column[{at}][{k}];"
    yield "}"
    yield "static double *ego_field(tm_input *in, size_t k) {"
    yield "  switch (k) {"
    for k, field in enumerate(spec.signals["ego"].fields_):
        yield f"    case {k}: return &in->ego.{field.name};"
    yield "    default: abort();"
    yield "  }"
    yield "}"
    names = [f.name for f in plan]
    for name in ("t", "x", "y", "heading", "v"):
        yield f"enum {{ P_{name.upper()} = {names.index(name)} }};"


def _range(field: FieldType) -> str:
    low = "-DBL_MAX" if field.lower is None else repr(field.lower)
    high = "DBL_MAX" if field.upper is None else repr(field.upper)
    return f'{{"{field.name}", {low}, {high}}}'


_PROGRAM = r"""
static unsigned long long state;
static unsigned below(unsigned n) {
  state = state * 6364136223846793005ull + 1442695040888963407ull;
  return (unsigned)((state >> 33) % n);
}
static double wild(void) {
  static const double some[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, 5e-324, -5e-324, DBL_MAX, -DBL_MAX, -0.0, 0.0, 1.0, -1.0, 1e10, 1001.0};
  return some[below(sizeof some / sizeof *some)];
}
static double *column_of(size_t most) { /* on the heap, ending where it ends */
  double *made = malloc(most * sizeof *made);
  if (made == NULL) { abort(); }
  return made;
}
static int64_t last_number;
static double last_t;
static bool begun;

static void fresh(tm_input in[2], tm_stamp *stamp) {
  for (int side = 0; side < 2; ++side) {
    plan_count[side] = 2u + below(SAMPLES - 1u);
    for (size_t k = 0; k < PLAN_FIELDS; ++k) {
      for (size_t i = 0; i < SAMPLES; ++i) {
        plan_column[side][k][i] = 0.0;
      }
    }
    for (size_t i = 0; i < SAMPLES; ++i) {
      plan_column[side][P_T][i] = 0.1 * (double)i;
      plan_column[side][P_X][i] = (double)i;
    }
  }
  objects_count[0] = below(ELEMENTS + 1u);
  obstacles_count[0] = below(ELEMENTS + 1u);
  for (size_t i = 0; i < ELEMENTS; ++i) {
    for (size_t k = 0; k < OBJECTS_FIELDS; ++k) { objects_column[0][k][i] = fmax(objects_range[k].low, fmin(objects_range[k].high, 3.0)); }
    for (size_t k = 0; k < OBSTACLES_FIELDS; ++k) { obstacles_column[0][k][i] = fmax(obstacles_range[k].low, fmin(obstacles_range[k].high, 3.0)); }
  }
  for (int side = 0; side < 2; ++side) {
    memset(&in[side], 0, sizeof in[side]);
    wire(&in[side], side);
  }
  in[0].emergency = TM_FALSE;
  in[1].emergency = TM_TRUE;
  stamp->number = begun ? (last_number + 1) : 0;
  stamp->t = begun ? (last_t + 0.1) : 0.0;
  stamp->now = stamp->t + 0.01;
}

static void spoil(tm_input in[2], tm_stamp *stamp) {
  const unsigned side = below(2u);
  switch (below(13u)) {
    case 0: case 1: case 2: plan_column[side][below(PLAN_FIELDS)][below(SAMPLES)] = wild(); break;
    case 3: objects_column[0][below(OBJECTS_FIELDS)][below(ELEMENTS)] = wild(); break;
    case 4: obstacles_column[0][below(OBSTACLES_FIELDS)][below(ELEMENTS)] = wild(); break;
    case 5: *ego_field(&in[0], below(EGO_FIELDS)) = wild(); break;
    case 6: { /* time goes back, or stands still */
      const size_t i = below(SAMPLES);
      plan_column[side][P_T][i] = plan_column[side][P_T][below(SAMPLES)];
      break;
    }
    case 7: in[side].plan.count = (below(2u) == 0u) ? below(3u) : (SAMPLES + below(3u)); break;
    case 8:
      if (below(2u) == 0u) { in[0].objects.count = ELEMENTS + below(3u); } else { in[0].obstacles.count = (size_t)-1; }
      break;
    case 9: if (below(2u) == 0u) { in[side].plan.x = NULL; } else { in[0].objects.v = NULL; } break;
    case 10: plan_column[1][(below(2u) == 0u) ? P_X : P_HEADING][0] += 0.03 * (double)below(10u); break;
    case 11: plan_column[1][P_V][(below(2u) == 0u) ? 0u : (plan_count[1] - 1u)] += 0.3 * (double)below(4u); break;
    default:
      switch (below(7u)) {
        case 0: stamp->number += (int64_t)below(3u) - 1; break;
        case 1: stamp->number = INT64_MAX; break;
        case 2: stamp->t += 0.1 * ((double)below(5u) - 2.0); break;
        case 3: stamp->now += 0.1 * ((double)below(5u) - 2.0); break;
        case 4: stamp->t = wild(); break;
        case 5: stamp->now = wild(); break;
        default: in[side].emergency = TM_MISSING; break;
      }
      break;
  }
}

static bool outside(double x, const range *r) { return !(x >= r->low && x <= r->high); }

static bool broken(const tm_input in[2], const tm_stamp *stamp) {
  bool bad = false;
  if (!isfinite(stamp->t) || !isfinite(stamp->now)) { return true; }
  bad = bad || (stamp->t - stamp->now > 0.01) || (stamp->now - stamp->t > 0.1);
  if (begun) {
    bad = bad || !(stamp->t - last_t > 0.001) || (stamp->t - last_t > 0.15) || (last_number == INT64_MAX) || (stamp->number != last_number + 1);
  }
  for (int side = 0; side < 2; ++side) {
    const size_t n = in[side].plan.count;
    if (n < 2u || n > SAMPLES || in[side].plan.x == NULL) { return true; }
    for (size_t k = 0; k < PLAN_FIELDS; ++k) {
      for (size_t i = 0; i < n; ++i) { bad = bad || outside(plan_column[side][k][i], &plan_range[k]); }
    }
    for (size_t i = 1; i < n; ++i) { bad = bad || !(plan_column[side][P_T][i - 1u] < plan_column[side][P_T][i]); }
  }
  if (in[0].objects.count > ELEMENTS || in[0].obstacles.count > ELEMENTS) { return true; }
  if (in[0].objects.v == NULL && in[0].objects.count > 0u) { return true; }
  for (size_t i = 0; i < in[0].objects.count; ++i) {
    for (size_t k = 0; k < OBJECTS_FIELDS; ++k) { bad = bad || outside(objects_column[0][k][i], &objects_range[k]); }
  }
  for (size_t i = 0; i < in[0].obstacles.count; ++i) {
    for (size_t k = 0; k < OBSTACLES_FIELDS; ++k) { bad = bad || outside(obstacles_column[0][k][i], &obstacles_range[k]); }
  }
  for (size_t k = 0; k < EGO_FIELDS; ++k) {
    tm_input copy = in[0];
    bad = bad || outside(*ego_field(&copy, k), &ego_range[k]);
  }
  bad = bad || in[0].emergency != TM_FALSE || in[1].emergency != TM_TRUE;
  {
    double *const *d = plan_column[0];
    double *const *e = plan_column[1];
    bad = bad || !(hypot(d[P_X][0] - e[P_X][0], d[P_Y][0] - e[P_Y][0]) <= 0.1);
    bad = bad || !(fabs(remainder(d[P_HEADING][0] - e[P_HEADING][0], 6.283185307179586)) <= 0.05);
    bad = bad || !(fabs(d[P_V][0] - e[P_V][0]) <= 0.5) || !(fabs(e[P_V][in[1].plan.count - 1u]) <= 0.01);
  }
  return bad;
}

int main(int argc, char **argv) {
  static tm_context context;
  static const double left[8] = {-100.0, 8.0, 0.0, 9.0, 50.0, 8.0, 200.0, 8.0};
  static const double right[4] = {-100.0, -8.0, 200.0, -8.0};
  const unsigned long cycles = strtoul(argc > 1 ? argv[1] : "1000", NULL, 10);
  unsigned long admitted = 0;
  tm_fault fault;
  state = strtoull(argc > 2 ? argv[2] : "1", NULL, 10);
  for (int side = 0; side < 2; ++side) {
    for (size_t k = 0; k < PLAN_FIELDS; ++k) { plan_column[side][k] = column_of(SAMPLES); }
  }
  for (size_t k = 0; k < OBJECTS_FIELDS; ++k) { objects_column[0][k] = column_of(ELEMENTS); }
  for (size_t k = 0; k < OBSTACLES_FIELDS; ++k) { obstacles_column[0][k] = column_of(ELEMENTS); }
  (void)tm_init(&context);
  if (!tm_admit_track(&context, left, 4u, right, 2u, &fault) || tm_set_track(&context, left, 4u, right, 2u, false) != TM_OK) { abort(); }
  for (unsigned long k = 0; k < cycles; ++k) {
    tm_input in[2];
    tm_output out[2];
    tm_stamp stamp;
    bool bad;
    bool fine;
    fresh(in, &stamp);
    if (below(8u) != 0u) { spoil(in, &stamp); }
    bad = broken(in, &stamp);
    fine = tm_admit(&context, &stamp, &in[0], &in[1], &fault);
    (void)tm_check_both(&context, &in[0], &in[1], &out[0], &out[1]);
    if (fine == bad || (fault.name == TM_FAULT_NONE) != fine || (!fine && fault.signal[0] == '\0')) {
      (void)printf("cycle %lu: %s, fault %d of %s.%s\n", k, bad ? "broken" : "fine", (int)fault.name, fault.signal, fault.field);
      abort();
    }
    for (size_t r = 0; r < TM_RULES && !fine; ++r) {
      if (out[0].rule[r].verdict != TM_UNDEFINED || out[1].rule[r].verdict != TM_UNDEFINED) { abort(); }
    }
    if (isfinite(stamp.t) && isfinite(stamp.now) && (!begun || stamp.t - last_t > 0.001) && !(stamp.t - stamp.now > 0.01)) {
      begun = true;
      last_t = stamp.t;
      last_number = stamp.number;
    }
    if (fabs(last_t) > 1e6 || last_number == INT64_MAX) { /* a stamp far away, or the last number: start anew */
      begun = false;
      last_t = 0.0;
      (void)tm_init(&context);
      if (!tm_admit_track(&context, left, 4u, right, 2u, &fault) || tm_set_track(&context, left, 4u, right, 2u, false) != TM_OK) { abort(); }
    }
    admitted += fine ? 1u : 0u;
  }
  for (int side = 0; side < 2; ++side) {
    for (size_t k = 0; k < PLAN_FIELDS; ++k) { free(plan_column[side][k]); }
  }
  for (size_t k = 0; k < OBJECTS_FIELDS; ++k) { free(objects_column[0][k]); }
  for (size_t k = 0; k < OBSTACLES_FIELDS; ++k) { free(obstacles_column[0][k]); }
  (void)printf("%lu of %lu admitted\n", admitted, cycles);
  return 0;
}
"""
