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
import subprocess
import sys
import tempfile
from pathlib import Path

HEADERS = Path(__file__).resolve().parents[2] / "kernels/include/softcd"

# Lines that the terms below repeat. One that changes here has to change there.
LINES = {
    "math/impact/query.hpp": (
        "const Vec3<T> plane_t0 = cross(motion.t0.b, motion.t0.c);",
        "const Vec3<T> plane_mixed = cross(motion.t0.b, motion.t1.c) + cross(motion.t1.b, motion.t0.c);",
        "const Cubic<T> cubic{dot(motion.t0.a, plane_t0), dot(motion.t1.a, plane_t0) + dot(motion.t0.a, plane_mixed),",
        "const T lowest = smaller(smaller(cubic.b0, cubic.b3), T(1) / T(3) * smaller(cubic.b1, cubic.b2));",
        "const T threshold = kHeightError<T> * volume + (T(1) + kLengthError<T>)*(motion.reach() * longest);",
        "const T longest = larger(larger(norm(plane_t0), T(0.5) * norm(plane_mixed)), norm(plane_t1));",
    ),
    "grid/uniform_grid.hpp": (
        "return kCoordinateError * furthest_coordinate(dop) * inverse_size;",
        "cells.lo[axis] = static_cast<int>(floorf(dop.lo[axis] * inverse_size - pad)) - (axis >= 3 && axis < 6 ? 1 : 0);",
    ),
    "math/kdop.hpp": ("p.x + p.y, p.x + p.z, p.y + p.z, p.x - p.y, p.x - p.z, p.y - p.z};",),
}
MARGINS = {
    "kCoefficientError": ("math/impact/query.hpp", r"constexpr T kCoefficientError = T\((\d+)\) \* epsilon<T>\(\);"),
    "kHeightError": ("math/impact/query.hpp", r"constexpr T kHeightError = T\((\d+)\) \* epsilon<T>\(\);"),
    "kCoordinateError": ("math/scalar.hpp", r"constexpr float kCoordinateError = ([\d.]+)F \* epsilon<float>\(\);"),
}
FAULTS = (
    ("math/impact/query.hpp", "kCoefficientError = T(40)", "kCoefficientError = T(34)"),
    ("math/impact/query.hpp", "kHeightError = T(64)", "kHeightError = T(49)"),
    ("math/scalar.hpp", "kCoordinateError = 8.0F", "kCoordinateError = 3.0F"),
    ("math/impact/query.hpp", "T(1) / T(3) * smaller(cubic.b1, cubic.b2)", "smaller(cubic.b1, cubic.b2)"),
    ("math/impact/query.hpp", "T(0.5) * norm(plane_mixed)", "norm(plane_mixed)"),
    ("grid/uniform_grid.hpp", "dop.lo[axis] * inverse_size - pad", "dop.lo[axis] * inverse_size"),
)
PRECISIONS = {"float": 24, "double": 53}


class Terms:
    """Terms of rounded operations, and beside each the same of exact ones. A number is the pair of both names."""

    def __init__(self, precision):
        self.precision, self.lines, self.inputs = precision, [], []

    def operate(self, operator, a, b):
        name = {"*": "mul", "+": "add", "-": "sub"}[operator]
        rounded, exact = f"r{len(self.lines)}", f"e{len(self.lines)}"
        self.lines.append(f"{rounded} = {name}_rel<{self.precision}>({a[0]}, {b[0]});\n{exact} = {a[1]} {operator} {b[1]};")
        return rounded, exact

    def vector(self, name):
        """Returns differences of positions, which are rounded once. Their components are at most 1."""
        components = [(f"{name}{axis}", f"{name}{axis}_exact") for axis in "xyz"]
        self.inputs += components
        return components

    def cross(self, a, b):
        def minor(i, k):
            return self.operate("-", self.operate("*", a[i], b[k]), self.operate("*", a[k], b[i]))

        return [minor(1, 2), minor(2, 0), minor(0, 1)]

    def dot(self, a, b):
        x, y, z = (self.operate("*", a[i], b[i]) for i in range(3))
        return self.operate("+", self.operate("+", x, y), z)

    def add(self, a, b):
        return [self.operate("+", a[i], b[i]) for i in range(3)]

    def third(self, a):
        """Returns a third of a number, as a product with a rounded third."""
        self.lines.append(f"third = mul_rel<{self.precision}>(1 / 3, 1);")
        return self.operate("*", ("third", "(1 / 3)"), a)

    def statement(self, result, bound):
        unit = f"1b-{self.precision}"
        known = [f"|{r}| <= 1 /\\ |{e}| <= {1 + 2.0 ** (2 - self.precision)!r} /\\ |{r} - {e}| <= {unit}" for r, e in self.inputs]
        return "\n".join(self.lines) + "\n{ " + " /\\\n  ".join(known) + f"\n-> |{result[0]} - {result[1]}| {bound} }}\n"


def first_coefficient(precision):
    terms = Terms(precision)
    a, b, c = (terms.vector(name) for name in "abc")
    return terms, terms.dot(a, terms.cross(b, c))


def third_of_second_coefficient(precision):
    terms = Terms(precision)
    a0, b0, c0, a1, b1, c1 = (terms.vector(name + end) for end in "01" for name in "abc")
    mixed = terms.add(terms.cross(b0, c1), terms.cross(b1, c0))
    return terms, terms.third(terms.operate("+", terms.dot(a1, terms.cross(b0, c0)), terms.dot(a0, mixed)))


def mixed_component(precision):
    terms = Terms(precision)
    b0, c0, b1, c1 = (terms.vector(name + end) for end in "01" for name in "bc")
    return terms, terms.add(terms.cross(b0, c1), terms.cross(b1, c0))[0]


def slack_statement(margin, furthest, inverse):
    """A lower bound along a sum, in cells, is not too high. The furthest coordinate and 1 / s are in these intervals."""
    return f"""@f = float<ieee_32, ne>;
x = f(xx); y = f(yy); furthest = f(ff); inverse = f(ii);
pad f= f({margin}b-23 * furthest) * inverse;
sum = f(x + y);
scaled f= sum * inverse;
cells f= scaled - pad;
{{ |x| <= {furthest[1]} /\\ |y| <= {furthest[1]} /\\ furthest in [{furthest[0]}, {furthest[1]}] /\\
  inverse in [{inverse[0]}, {inverse[1]}] -> cells - (x + y) * inverse <= 0 }}
cells - (x + y) * inverse -> (cells - (scaled - pad)) + (scaled - sum * inverse) + (sum - (x + y)) * inverse - pad;
"""


def gappa(text):
    """Returns whether Gappa proves the text, and what it prints."""
    run = subprocess.run(["gappa"], input=text, capture_output=True, text=True)
    return run.returncode == 0, run.stdout + run.stderr


def highest(text):
    """Returns the upper end of the interval that Gappa finds."""
    proved, printed = gappa(text)
    value = re.search(r"in \[.*, [^\]{]*\{([-+.e\d]+)|in \[.*, ([-+.e\d]+)\]", printed)
    if not proved or not value:
        raise SystemExit(f"Gappa finds no bound:\n{printed}\n{text}")
    return float(value[1] or value[2])


def least_slack(most):
    """Returns the least margin, a whole number up to `most`, that is large enough. Powers of two scale coordinates and 1 / s
    into [1, 2], which is looked at in parts."""
    ends = [1 + i / 8 for i in range(9)]
    parts = list(zip(ends, ends[1:]))
    for margin in range(1, most + 1):
        if all(gappa(slack_statement(margin, furthest, inverse))[0] for furthest in parts for inverse in parts):
            return margin
    return float("inf")


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
            is_caught = subprocess.run([sys.executable, __file__, "--headers", headers], capture_output=True).returncode == 1
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
    headers = arguments.headers
    for file, lines in LINES.items():
        text = (headers / file).read_text()
        for line in lines:
            if line not in text:
                raise SystemExit(f"{file} has no longer what is proved here:\n{line}")
    margins = {}
    for name, (file, pattern) in MARGINS.items():
        found = re.search(pattern, (headers / file).read_text())
        if not found:
            raise SystemExit(f"{file}: {name} is not where it was")
        margins[name] = float(found[1])

    failed = []

    def judge(what, bound, margin):
        is_kept = bound <= margin
        print(f"{what:62} {bound:6.2f} of {margin:4.1f} epsilon  {'proved' if is_kept else 'TOO SMALL'}")
        if not is_kept:
            failed.append(what)

    for kind, precision in PRECISIONS.items():
        in_epsilons = 2.0 ** (precision - 1)
        bounds = {}
        for build in (first_coefficient, third_of_second_coefficient, mixed_component):
            terms, result = build(precision)
            bounds[build] = in_epsilons * highest(terms.statement(result, "in ?"))
        coefficient = max(bounds[first_coefficient], bounds[third_of_second_coefficient])
        judge(f"{kind}: coefficients of the cubic, the middle ones by thirds", coefficient, margins["kCoefficientError"])
        # Half of a mixed component, three of them, and a reach below sqrt(3) A.
        judge(f"{kind}: heights over planes", coefficient + 3.0 * bounds[mixed_component] / 2.0, margins["kHeightError"])
    slack = margins["kCoordinateError"]
    judge("float: projections onto diagonals, scaled to cells", least_slack(int(slack)), slack)
    for failure in failed:
        print(f"roundings.py: {failure}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
