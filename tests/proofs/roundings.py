#!/usr/bin/env python3
"""Proves margins for roundings by interval arithmetic: docs/inside/proofs.md states what, and for which inputs.

    tests/proofs/roundings.py [--faults | --headers FOLDER]

Reads the margins from the headers, and checks that the lines that it proves something about are still there. Has Gappa
(apt-get install gappa) find a bound of each error, and fails where one exceeds its margin. With --faults, plants FAULTS in
copies of the headers, and fails where they are not noticed.
"""

import argparse
import re
import shutil
import sys
import tempfile
from pathlib import Path

import rounding_bounds as bounds
from rounding_bounds import SQRT3

HEADERS = Path(__file__).resolve().parents[2] / "kernels/include/softcd"

# Lines that the bounds repeat. One that changes here has to change there.
LINES = {
    "core/vec3.hpp": ("return a + t * (b - a);",),
    "math/scalar.hpp": ("return (T(1) - t) * a + t * b;", "return square_root(squared_norm(a));"),
    "math/cubic.hpp": (
        "return ((b0 * s + b1 * t) * s + b2 * tt) * s + b3 * (tt * t);",
        "const T d0 = cubic.b1 - T(3) * cubic.b0;",
        "const T d1 = cubic.b2 - cubic.b1;",
        "const T d2 = T(3) * cubic.b3 - cubic.b2;",
        "const T discriminant = d1 * d1 - d0 * d2;",
        "const T root = square_root(discriminant);",
        "const T z = d1 > T(0) ? -d1 - root : root - d1;",
        "const T p = z * d2 > T(0) ? z / (z + d2) : T(1);",
        "const T q = z * d0 > T(0) ? d0 / (z + d0) : T(1);",
        "if (!(sign * at_from > bound)) return from;",
        "const T excess = sign * cubic(t) - bound;",
        "(excess > T(0) ? clear : blocked) = t;",
        "const T discriminant = g1 * g1 - g0 * g2;",
        "return g1 < T(0) ? g0 / (g0 + (root - g1)) : (g1 + root) / ((g1 + root) - g2);",
    ),
    "math/impact/motion.hpp": (
        "return {interpolate(t0.a, t1.a, t), interpolate(t0.b, t1.b, t), interpolate(t0.c, t1.c, t)};",
        "SOFTCD_HD T reach() const { return margin + tolerance; }",
    ),
    "math/impact/query.hpp": (
        "return !(height > T(0) && height * height > reach * reach * squared_norm(plane));",
        "const T height = magnitude(dot(pair.a, plane)) - kCoefficientError<T> * volume;",
        "const T reach = margin + kDistanceError<T> * (size_a + size_b + size_c);",
        "motion.tolerance = kDistanceError<T> * (size_a + size_b + size_c);",
        "const T error = kCoefficientError<T> * volume;",
        "const Vec3<T> plane_t0 = cross(motion.t0.b, motion.t0.c);",
        "const Vec3<T> plane_mixed = cross(motion.t0.b, motion.t1.c) + cross(motion.t1.b, motion.t0.c);",
        "const Cubic<T> cubic{dot(motion.t0.a, plane_t0), dot(motion.t1.a, plane_t0) + dot(motion.t0.a, plane_mixed),",
        "const T lowest = smaller(smaller(cubic.b0, cubic.b3), T(1) / T(3) * smaller(cubic.b1, cubic.b2));",
        "const T threshold = kHeightError<T> * volume + (T(1) + kLengthError<T>)*(motion.reach() * longest);",
        "const T longest = larger(larger(norm(plane_t0), T(0.5) * norm(plane_mixed)), norm(plane_t1));",
        "!has_volume || may_reach(magnitude(cubic.b0) - error, plane_t0, motion.reach()),",
    ),
    "math/impact/coplanar.hpp": (
        "const bool is_clear = (at_begin > bound && at_end > bound) || (at_begin < -bound && at_end < -bound);",
        "const T first = last_clear(cubic, bound, begin, end, secant_root(begin, end, at_begin, at_end));",
        "return last_clear(cubic, bound, end, begin, first +",
    ),
    "math/impact/impact.hpp": (
        "const T unit = query.volume > T(0) ? T(1) / query.volume : T(0);",
        "const Cubic<T> normalized{unit * query.cubic.b0, unit * query.cubic.b1, unit * query.cubic.b2,",
        "touch = first_coplanar_touch<kKind>(motion, normalized, kCubicError<T>);",
    ),
    "math/impact/advancement.hpp": (
        "const T g0 = dot(n.begin, r_begin) - gap;",
        "const T g1 = T(0.5) * ((dot(n.begin, r_end) + dot(n.end, r_begin)) - (gap + end_gap));",
        "const T g2 = dot(n.end, r_end) - end_gap;",
        "return g0 > T(0) ? first_root(g0, g1, g2) : T(0);",
        "const T gap = distance * norm(n.begin);",
        "fraction = smaller(fraction, clear_fraction(n, gap, end_gap, r_begin - now.c, r_end - end.c));",
        "const Vec3<T> r_begin = now.a + now.b;",
        "const auto length_at_most = [](Vec3<T> p) { return magnitude(p.x) + magnitude(p.y) + magnitude(p.z); };",
        "return length_at_most(end.a - now.a) + length_at_most(end.b - now.b) + length_at_most(end.c - now.c);",
        "if (distance > motion.reach() + most_approach(now, last)) {",
        "const T next = smaller(t + fraction * (end - t), end);",
        "const T next = smaller(t_ + fraction * (T(1) - t_), T(1));",
    ),
    "math/separation.hpp": (
        "at[first + 3] = at[first + 2] - pair.c;",
        "const float distance = margin + detail::kSeparationError * size;",
        "if (!(length > larger(margin, detail::kShortestDirection))) return false;",
        "if (least > distance * length) return true;",
    ),
    "stages/shared_vertex_test.hpp": (
        "const float scaled_distance = outward_up(scale * distance + rounding);",
        "return {{x[t.v[(corner + 1) % 3]] - origin, x[t.v[(corner + 2) % 3]] - origin}};",
        "return lowest - highest > distance;",
    ),
    "stages/virtual_subdivision.hpp": (
        "return v[0] + (weights.row[corner] * (v[1] - v[0]) + weights.along[corner] * (v[2] - v[1]));",
        "inflate(volume, outward_up(growth + kCoordinateError * furthest));",
    ),
    "stages/pair_tests.hpp": (
        "const float growth = outward_up(distance + kCoordinateError * furthest);",
        "if (overlap(inflated(merged(box_a, next_a), growth), merged(box_b, next_b))) return true;",
    ),
    "grid/uniform_grid.hpp": (
        "return kCoordinateError * furthest_coordinate(dop) * inverse_size;",
        "cells.lo[axis] = static_cast<int>(floorf(dop.lo[axis] * inverse_size - pad)) - (axis >= 3 && axis < 6 ? 1 : 0);",
    ),
    "math/kdop.hpp": (
        "p.x + p.y, p.x + p.z, p.y + p.z, p.x - p.y, p.x - p.z, p.y - p.z};",
        "return {distance, outward_up(distance * 1.41421357F) + kCoordinateError * furthest};",
    ),
}
IN_EPSILONS = r"constexpr T %s = T\((\d+)\) \* epsilon<T>\(\);"
IN_FLOAT = r"constexpr float %s = (?:kDistanceError<float> \+ )?([\d.]+)F \* epsilon<float>\(\);"
MARGINS = {
    "kCoefficientError": ("math/impact/query.hpp", IN_EPSILONS),
    "kCubicError": ("math/impact/query.hpp", IN_EPSILONS),
    "kHeightError": ("math/impact/query.hpp", IN_EPSILONS),
    "kLengthError": ("math/impact/query.hpp", IN_EPSILONS),
    "kDistanceError": ("math/impact/motion.hpp", IN_EPSILONS),
    "kSeparationError": ("math/separation.hpp", IN_FLOAT),
    "kHeightError of shared vertices": ("stages/shared_vertex_test.hpp", IN_FLOAT),
    "kCoordinateError": ("math/scalar.hpp", IN_FLOAT),
    "the part of the tolerance that steps keep": (
        "math/impact/advancement.hpp",
        r"const T distance = motion\.margin \+ T\(([\d.]+)\) \* motion\.tolerance;",
    ),
    "the tolerance's factor with a margin": (
        "math/impact/impact.hpp",
        r"query\.motion\.tolerance = T\((\d+)\) \* query\.motion\.tolerance \+",
    ),
}
FAULTS = (
    ("math/impact/query.hpp", "kCoefficientError = T(40)", "kCoefficientError = T(34)"),
    ("math/impact/query.hpp", "kCubicError = T(192)", "kCubicError = T(96)"),
    ("math/impact/query.hpp", "kHeightError = T(64)", "kHeightError = T(49)"),
    ("math/impact/query.hpp", "kLengthError = T(32)", "kLengthError = T(3)"),
    ("math/impact/motion.hpp", "kDistanceError = T(32)", "kDistanceError = T(31)"),
    ("math/impact/advancement.hpp", "T(0.5) * motion.tolerance", "T(0.49) * motion.tolerance"),
    ("math/impact/impact.hpp", "T(2) * query.motion.tolerance", "T(1) * query.motion.tolerance"),
    ("math/separation.hpp", "+ 16.0F * epsilon", "+ 9.0F * epsilon"),
    ("stages/shared_vertex_test.hpp", "= 32.0F * epsilon", "= 18.0F * epsilon"),
    ("math/scalar.hpp", "kCoordinateError = 8.0F", "kCoordinateError = 5.0F"),
    ("math/impact/query.hpp", "T(1) / T(3) * smaller(cubic.b1, cubic.b2)", "smaller(cubic.b1, cubic.b2)"),
    ("math/impact/query.hpp", "T(0.5) * norm(plane_mixed)", "norm(plane_mixed)"),
    ("math/cubic.hpp", "root - d1", "root + d1"),
    ("math/cubic.hpp", "(excess > T(0) ? clear : blocked) = t", "(excess >= -bound ? clear : blocked) = t"),
    ("math/impact/advancement.hpp", "(gap + end_gap)", "gap"),
    ("math/impact/advancement.hpp", "t + fraction * (end - t)", "t + T(1.01) * fraction * (end - t)"),
    ("math/impact/advancement.hpp", "distance > motion.reach() + most_approach", "distance > most_approach"),
    ("math/separation.hpp", "least > distance * length", "least > margin * length"),
    ("stages/virtual_subdivision.hpp", "growth + kCoordinateError * furthest", "growth"),
    ("grid/uniform_grid.hpp", "dop.lo[axis] * inverse_size - pad", "dop.lo[axis] * inverse_size"),
)
# The largest amount by which nearest() may exceed a distance, in epsilon (A + B + C). This is no result of Gappa:
# tests/kernels/math/error_bounds.cpp searches for cases that exceed it.
NEAREST = 8.0
# Roundings of a step's end: two of the fraction, one of end - t, of the product, of the sum. All numbers are positive.
OF_TIME = 5.0


def judgements(margins):
    """Yields what is bounded, the bound in u, and the margin in epsilon. docs/inside/proofs.md has the reasons."""
    for kind, p in (("float", 24), ("double", 53)):
        coefficient = max(bounds.first_coefficient(p), bounds.third_of_second_coefficient(p))
        yield f"{kind}: coefficients of the cubic, the middle ones by thirds", coefficient, margins["kCoefficientError"]
        at_once = bounds.first_coefficient(p) + 3.0 * bounds.plane_component(p)
        yield f"{kind}: heights over planes, at one time", at_once, margins["kCoefficientError"]
        throughout = coefficient + 3.0 * bounds.mixed_component(p) / 2.0
        yield f"{kind}: heights over planes, throughout", throughout, margins["kHeightError"]
        # The length itself, and the roundings of the reach, of two products, of the factor and of the sum.
        yield f"{kind}: lengths of planes, and their products", bounds.length(p) + 5.0, margins["kLengthError"]
        # Coefficients are divided by the volume: roundings that all have in common do not matter, one does.
        splits = bounds.derivative_coefficients(p) + bounds.root_of_cubic(p, 36.1)
        cubic = coefficient + 6.01 + bounds.value_of_cubic(p) + splits
        yield f"{kind}: values of the cubic, and where it is split", cubic, margins["kCubicError"]

        position = bounds.interpolation(p)
        along = bounds.distance_along(p, position, 2)
        root = SQRT3 * bounds.root_of_step(p)
        kept = margins["kDistanceError"] * margins["the part of the tolerance that steps keep"]
        yield f"{kind}: steps of advancement, without a margin", along + root + OF_TIME * SQRT3, kept
        gap = (bounds.length(p) + 3.0) * SQRT3
        with_margin = along + SQRT3 + gap + 2.0 * (root + OF_TIME * SQRT3)
        factor = margins["the tolerance's factor with a margin"]
        yield f"{kind}: steps of advancement, with a margin", with_margin, factor * kept
        # Six positions for each axis, five roundings of a sum below sqrt(3) S, and the offset's own position.
        approach = 6.0 * position + 5.0 * SQRT3 + SQRT3 * position + 2.0 * NEAREST
        yield f"{kind}: approach at most, with {NEAREST} epsilon of nearest()", approach, margins["kDistanceError"]

    # A dot product of differences, rounded once, and the margin's part: a sum, a length and a product.
    direction = bounds.distance_along(24, 1.0) + (bounds.length(24) + 2.0) * SQRT3
    yield "float: distances along a direction", direction, margins["kSeparationError"]
    # Two heights, and the direction's length: of its components, of their length, of its inverse and of the product.
    beyond = 2.0 * bounds.distance_along(24, 1.0) + (bounds.length(24) + 3.0) * 2.0 * SQRT3
    yield "float: heights over an edge's neighbours", beyond, margins["kHeightError of shared vertices"]
    slack = margins["kCoordinateError"]
    yield "float: projections onto diagonals, scaled to cells", 2.0 * bounds.least_slack(int(slack)), slack
    corner = bounds.child_corner(24)
    yield "float: corners of children", corner, slack
    # Volumes grow by sqrt(2) as much along diagonals, and once more for the projections' own rounding.
    yield "float: sums of two coordinates of these", (2.0 * corner + 2.0) / (1.0 + 2.0**0.5), slack
    yield "float: boxes of two triangles in a time slab", 2.0 * bounds.point_between(24), slack


def check(headers, show=True):
    """Returns the messages about what is not proved of these headers."""
    for file, lines in LINES.items():
        text = (headers / file).read_text()
        for line in lines:
            if line not in text:
                return [f"{file} has no longer what is proved here:\n{line}"]
    margins = {}
    for name, (file, pattern) in MARGINS.items():
        found = re.search(pattern.replace("%s", name.split()[0]), (headers / file).read_text())
        if not found:
            return [f"{file}: {name} is not where it was"]
        margins[name] = float(found[1])
    failed = []
    for what, bound, margin in judgements(margins):
        is_kept = bound / 2.0 <= margin
        if show:
            print(f"{what:66} {bound / 2.0:6.2f} of {margin:5.1f} epsilon  {'proved' if is_kept else 'TOO SMALL'}", flush=True)
        if not is_kept:
            failed.append(f"{what}: the margin is too small")
    return failed


def try_faults():
    """Returns the number of faults that are not noticed."""
    survived = 0
    for file, before, after in FAULTS:
        with tempfile.TemporaryDirectory() as folder:
            headers = Path(folder) / "softcd"
            shutil.copytree(HEADERS, headers)
            text = (headers / file).read_text()
            if before not in text:
                raise SystemExit(f"{file} has no '{before}' to plant a fault in")
            (headers / file).write_text(text.replace(before, after))
            is_caught = bool(check(headers, show=False))
        print(f"{'caught  ' if is_caught else 'SURVIVED'} {file}: {before} -> {after}", flush=True)
        survived += not is_caught
    return survived


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--headers", type=Path, default=HEADERS)
    parser.add_argument("--faults", action="store_true")
    arguments = parser.parse_args()
    if arguments.faults:
        return 1 if try_faults() else 0
    failed = check(arguments.headers)
    for message in failed:
        print(f"roundings.py: {message}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
