"""Finds bounds of rounding errors by Gappa's interval arithmetic. docs/inside/proofs.md says what they are for.

With u = epsilon / 2, an operation has a relative error of at most u. All bounds are returned in u. `p` is the number of
bits of a significand: 24 or 53.
"""

import functools
import math
import re
import subprocess

SQRT3 = math.sqrt(3.0)
LEAST_EXPONENT = {24: -149, 53: -1074}
PARTS_OF_TIME = 64


class Terms:
    """Terms of rounded operations, and beside each the same of exact ones. A number is the pair of both names."""

    def __init__(self, p):
        self.p, self.lines, self.known = p, [], []

    def operate(self, operator, a, b):
        name = {"*": "mul", "+": "add", "-": "sub"}[operator]
        rounded, exact = f"r{len(self.lines)}", f"e{len(self.lines)}"
        self.lines.append(f"{rounded} = {name}_rel<{self.p}>({a[0]}, {b[0]});\n{exact} = {a[1]} {operator} {b[1]};")
        return rounded, exact

    def exact(self, name, size=1.0):
        """Returns a number without an error, of this size at most."""
        self.known.append(f"|{name}| <= {size!r}")
        return name, name

    def number(self, name, size=1.0, error=1.0):
        """Returns a number of this size at most, with an error of `error` u of it."""
        error *= size * 2.0**-self.p
        self.known.append(f"|{name}| <= {size!r} /\\ |{name}_exact| <= {size + error!r}")
        self.known.append(f"|{name} - {name}_exact| <= {error!r}")
        return name, f"{name}_exact"

    def vector(self, name):
        """Returns the difference of two positions. Its components are at most 1."""
        return [self.number(f"{name}{axis}") for axis in "xyz"]

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
        self.lines.append(f"third = mul_rel<{self.p}>(1 / 3, 1);")
        return self.operate("*", ("third", "(1 / 3)"), a)

    def bound(self, result):
        """Returns a bound of the result's error."""
        known = " /\\\n  ".join(self.known)
        text = "\n".join(self.lines) + f"\n{{ {known}\n-> |{result[0]} - {result[1]}| in ? }}\n"
        return highest(text) * 2.0**self.p


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


def rounding(p):
    return f"@f = float<{p}, {LEAST_EXPONENT[p]}, ne>;\n"


def parts_of_time():
    return ((i / PARTS_OF_TIME, (i + 1) / PARTS_OF_TIME) for i in range(PARTS_OF_TIME))


@functools.cache
def first_coefficient(p):
    """Coefficients b0 and b3 of the cubic, relative to A B C."""
    terms = Terms(p)
    a, b, c = (terms.vector(name) for name in "abc")
    return terms.bound(terms.dot(a, terms.cross(b, c)))


@functools.cache
def third_of_second_coefficient(p):
    """Thirds of b1 and b2, relative to A B C."""
    terms = Terms(p)
    a0, b0, c0, a1, b1, c1 = (terms.vector(name + end) for end in "01" for name in "abc")
    mixed = terms.add(terms.cross(b0, c1), terms.cross(b1, c0))
    return terms.bound(terms.third(terms.operate("+", terms.dot(a1, terms.cross(b0, c0)), terms.dot(a0, mixed))))


@functools.cache
def plane_component(p):
    """A component of b x c, relative to B C."""
    terms = Terms(p)
    b, c = (terms.vector(name) for name in "bc")
    return terms.bound(terms.cross(b, c)[0])


@functools.cache
def mixed_component(p):
    """A component of plane_mixed, relative to B C."""
    terms = Terms(p)
    b0, c0, b1, c1 = (terms.vector(name + end) for end in "01" for name in "bc")
    return terms.bound(terms.add(terms.cross(b0, c1), terms.cross(b1, c0))[0])


@functools.cache
def length(p):
    """The length of a vector, relative to it."""
    square = highest(
        f"s = add_rel<{p}>(add_rel<{p}>(mul_rel<{p}>(x, x), mul_rel<{p}>(y, y)), mul_rel<{p}>(z, z));\n"
        "{ x in [1b-9, 1] /\\ y in [1b-9, 1] /\\ z in [1b-9, 1] -> s -/ (x * x + y * y + z * z) in ? }"
    )
    # A root halves a relative error, and is rounded once.
    return square / 2.0 * 2.0**p + 1.0


@functools.cache
def value_of_cubic(p):
    """A value of a cubic whose coefficients are at most 6 and, the middle ones, 18."""
    text = (
        rounding(p)
        + """b0 = f(bb0); b1 = f(bb1); b2 = f(bb2); b3 = f(bb3); t = f(tt);
s f= 1 - t; tt_ f= t * t;
value f= ((b0 * s + b1 * t) * s + b2 * tt_) * s + b3 * (tt_ * t);
exact = ((b0 * (1 - t) + b1 * t) * (1 - t) + b2 * (t * t)) * (1 - t) + b3 * ((t * t) * t);
{ |b0| <= 6.01 /\\ |b1| <= 18.03 /\\ |b2| <= 18.03 /\\ |b3| <= 6.01 /\\ t in [%r, %r] -> |value - exact| in ? }
"""
    )
    return max(highest(text % part) for part in parts_of_time()) * 2.0**p


@functools.cache
def derivative_coefficients(p):
    """The mean error of the three coefficients of the derivative: what it adds to the cubic over the whole of [0, 1]."""
    text = (
        rounding(p)
        + """b0 = f(bb0); b1 = f(bb1); b2 = f(bb2); b3 = f(bb3);
d0 f= b1 - 3 * b0; d1 f= b2 - b1; d2 f= 3 * b3 - b2;
{ |b0| <= 6.01 /\\ |b1| <= 18.03 /\\ |b2| <= 18.03 /\\ |b3| <= 6.01 -> |%s| in ? }
"""
    )
    errors = ("d0 - (b1 - 3 * b0)", "d1 - (b2 - b1)", "d2 - (3 * b3 - b2)")
    return sum(highest(text % error) for error in errors) / 3.0 * 2.0**p


@functools.cache
def roots_of_quadratics(p):
    """Returns, for each part of all quadratics d0 s^2 + 2 d1 s t + d2 t^2, the bounds of x = |d1| and of R, the computed
    root of the discriminant, and a bound of the change of d1 that makes the computed roots exact.

    With z = R + x, the roots z / d2 and d0 / z are those of the quadratic with d0, d2 and -(z + d0 d2 / z) / 2 instead of
    d1. That differs from d1 by (z^2 - 2 x z + d0 d2) / (2 z). Powers of two scale the larger one of x and R into [1, 2].
    """
    steps = [i / 8 for i in range(17)]
    cells = list(zip(steps, steps[1:]))
    slop = 2.0**-14  # more than all roundings here
    found = []
    for x in cells:
        for r in cells:
            if x[1] <= 1.0 and r[1] <= 1.0:
                continue
            product = (x[0] ** 2 - r[1] ** 2 - slop, x[1] ** 2 - r[0] ** 2 + slop)
            discriminant = (max(r[0] ** 2 - slop, 0.0), r[1] ** 2 + slop)
            text = (
                rounding(p)
                + f"""x = f(xx);
d f= x * x - product;
r f= sqrt(d);
z f= r + x;
residual = z * z - 2 * x * z + product;
{{ x in [{x[0]!r}, {x[1]!r}] /\\ r in [{r[0]!r}, {r[1]!r}] /\\ product in [{product[0]!r}, {product[1]!r}] /\\
  d in [{discriminant[0]!r}, {discriminant[1]!r}] -> |residual| in ? }}
residual -> (z - (r + x)) * (z + r - x) + (r * r - d) + (d - (x * x - product));
r * r - d -> (r - sqrt(d)) * (r + sqrt(d));
"""
            )
            found.append((x, r, highest(text) / (2.0 * (r[0] + x[0])) * 2.0**p))
    return found


@functools.cache
def root_of_cubic(p, size):
    """What the change of d1 adds to the cubic over [0, 1], 2 s t of it being a third. d0, d1 and d2 are at most `size`."""
    worst = max(change / max(x[0], r[0], 1.0) for x, r, change in roots_of_quadratics(p))
    return worst * math.sqrt(2.0) * size / 3.0


@functools.cache
def root_of_step(p):
    """The same for a step's quadratic, relative to the chord of |n| and the largest |n . r| / |n|.

    At its ends |n| is m (1 + c) and m (1 - c), so |d1| <= m and |d0 d2| <= k^2 m^2 with k^2 = 1 - c^2. The chord is at
    least 2 s t m (1 + k). Powers of two may scale x and R up to x = m, and up to |R^2 - x^2| = k^2 m^2.
    """
    worst = 0.0
    for x, r, change in roots_of_quadratics(p):
        by_x = 1.0 / x[0] if x[0] > 0.0 else math.inf
        outer = max(r[0] ** 2 - x[1] ** 2, x[0] ** 2 - r[1] ** 2, 0.0)
        by_outer = 1.0 / math.sqrt(outer) if outer > 0.0 else math.inf
        k = min(1.0, by_x / by_outer) if by_x < math.inf else 1.0
        largest = by_x if by_outer == math.inf else min(by_x, k * by_outer)
        worst = max(worst, change * largest / (1.0 + k))
    return worst


@functools.cache
def interpolation(p):
    """A component of a, b or c between its ends, relative to A, B or C."""
    text = (
        rounding(p)
        + f"""t = f(tt);
s f= 1 - t;
value = add_rel<{p}>(mul_rel<{p}>(s, x0), mul_rel<{p}>(t, x1));
exact = (1 - t) * y0 + t * y1;
{{ |x0| <= 1 /\\ |x1| <= 1 /\\ |x0 - y0| <= 1b-{p} /\\ |x1 - y1| <= 1b-{p} /\\ t in [%r, %r] -> |value - exact| in ? }}
exact -> ((1 - t) * x0 + t * x1) - (1 - t) * (x0 - y0) - t * (x1 - y1);
"""
    )
    return max(highest(text % part) for part in parts_of_time()) * 2.0**p


@functools.cache
def distance_along(p, error, summands=1):
    """A difference from n . r, relative to |n| (A + B + C); with `summands` 2, from the mean of two such products.

    r is a sum of three vectors of sizes A, B and C, `error` u off. Roundings count most where one of them is all of it.
    This finds the part of one component. All errors are sums over n's components, hence the root of 3.
    """
    terms = Terms(p)
    zero = terms.exact("zero", 0.0)

    def product(name):
        a = terms.number(f"a{name}", 1.0, error)
        r = terms.operate("-", terms.operate("+", a, zero), zero)
        x = terms.operate("*", terms.exact(f"n{name}"), r)
        return terms.operate("+", terms.operate("+", x, zero), zero)

    result = product(0)
    for i in range(1, summands):
        result = terms.operate("+", result, product(i))
    return SQRT3 * terms.bound(terms.operate("-", result, zero)) / summands


@functools.cache
def point_between(p):
    """A component of a point between two others, relative to the furthest coordinate."""
    terms = Terms(p)
    a, b, t = (terms.exact(name) for name in "abt")
    point = terms.operate("+", a, terms.operate("*", t, terms.operate("-", b, a)))
    terms.known.append(f"|{point[1]}| <= 1")
    return terms.bound(point)


@functools.cache
def child_corner(p):
    """A component of a child's corner, relative to the furthest coordinate."""
    terms = Terms(p)
    v = [terms.exact(f"v{i}") for i in range(3)]
    row, along = terms.exact("row"), terms.exact("along")
    inner = terms.operate(
        "+",
        terms.operate("*", row, terms.operate("-", v[1], v[0])),
        terms.operate("*", along, terms.operate("-", v[2], v[1])),
    )
    corner = terms.operate("+", v[0], inner)
    # The corner is a point of the triangle.
    terms.known += [f"|{inner[1]}| <= 2", f"|{corner[1]}| <= 1"]
    return terms.bound(corner)


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


@functools.cache
def least_slack(most):
    """Returns the least margin, a whole number up to `most`, that is large enough. Powers of two scale coordinates and 1 / s
    into [1, 2], which is looked at in parts."""
    ends = [1 + i / 8 for i in range(9)]
    parts = list(zip(ends, ends[1:]))
    for margin in range(1, most + 1):
        if all(gappa(slack_statement(margin, furthest, inverse))[0] for furthest in parts for inverse in parts):
            return margin
    return float("inf")
