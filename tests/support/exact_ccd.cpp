#include "exact_ccd.hpp"

#include <algorithm>
#include <array>
#include <boost/multiprecision/gmp.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

// Coordinates become integers: removing a common power of two or denominator changes no verdict. Every condition is
// then the sign of an integer polynomial in t, of degree at most 4, at a root of another polynomial.
namespace softcd::test {
namespace {

using Integer = boost::multiprecision::mpz_int;
using Rational = boost::multiprecision::mpq_rational;

/// Coefficients from the constant upwards; the last one is not 0, and the zero polynomial has none.
using Polynomial = std::vector<Integer>;

void trim(Polynomial& p) {
  while (!p.empty() && p.back() == 0) p.pop_back();
}

Polynomial combine(const Polynomial& p, const Polynomial& q, int sign_of_q) {
  Polynomial sum(std::max(p.size(), q.size()));
  for (std::size_t i = 0; i < p.size(); ++i) sum[i] = p[i];
  for (std::size_t i = 0; i < q.size(); ++i) sum[i] += sign_of_q * q[i];
  trim(sum);
  return sum;
}

Polynomial operator+(const Polynomial& p, const Polynomial& q) {
  return combine(p, q, 1);
}
Polynomial operator-(const Polynomial& p, const Polynomial& q) {
  return combine(p, q, -1);
}

Polynomial operator*(const Polynomial& p, const Polynomial& q) {
  if (p.empty() || q.empty()) return {};
  Polynomial product(p.size() + q.size() - 1);
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t j = 0; j < q.size(); ++j) product[i + j] += p[i] * q[j];
  }
  return product;
}

void divide_by_content(Polynomial& p) {
  Integer content = 0;
  for (const Integer& coefficient : p) content = gcd(content, coefficient);
  if (content > 1) {
    for (Integer& coefficient : p) coefficient /= content;
  }
}

/// Returns the remainder of p divided by q, times some integer that is not 0.
Polynomial pseudo_remainder(Polynomial p, const Polynomial& q) {
  while (p.size() >= q.size()) {
    const Integer leading = p.back();
    const std::size_t shift = p.size() - q.size();
    for (Integer& coefficient : p) coefficient *= q.back();
    for (std::size_t i = 0; i < q.size(); ++i) p[i + shift] -= leading * q[i];
    trim(p);
  }
  divide_by_content(p);
  return p;
}

/// Returns the greatest common divisor, up to a factor.
Polynomial greatest_common_divisor(Polynomial p, Polynomial q) {
  while (!q.empty()) {
    Polynomial remainder = pseudo_remainder(std::move(p), q);
    p = std::move(q);
    q = std::move(remainder);
  }
  divide_by_content(p);
  return p;
}

/// Returns p / q up to a factor; q must divide p.
Polynomial exact_quotient(Polynomial p, const Polynomial& q) {
  Polynomial quotient(p.size() - q.size() + 1);
  while (p.size() >= q.size()) {
    const std::size_t shift = p.size() - q.size();
    for (Integer& coefficient : quotient) coefficient *= q.back();
    const Integer leading = p.back();
    quotient[shift] += leading;
    for (Integer& coefficient : p) coefficient *= q.back();
    for (std::size_t i = 0; i < q.size(); ++i) p[i + shift] -= leading * q[i];
    trim(p);
  }
  divide_by_content(quotient);
  return quotient;
}

Polynomial without_repeated_roots(const Polynomial& p) {
  Polynomial derivative(p.size() - 1);
  for (std::size_t i = 1; i < p.size(); ++i) derivative[i - 1] = p[i] * i;
  return exact_quotient(p, greatest_common_divisor(p, derivative));
}

/// The dyadic interval from m / 2^k to (m + 1) / 2^k.
struct Dyadic {
  Integer m = 0;
  unsigned k = 0;

  Dyadic left_half() const { return {2 * m, k + 1}; }
  Dyadic right_half() const { return {2 * m + 1, k + 1}; }

  /// Returns its ends, or the left one twice, rounded outward.
  TimeBracket bracket(bool is_left_end) const {
    constexpr unsigned kDoubleBits = 53;
    const unsigned excess = k > kDoubleBits ? k - kDoubleBits : 0;
    const auto to_double = [&](const Integer& integer) {
      return std::ldexp(integer.convert_to<double>(), -static_cast<int>(k - excess));
    };
    const Integer end = is_left_end ? m : m + 1;
    return {to_double(m >> excess), to_double(-(-end >> excess))};
  }
};

/// Returns the sign at the interval's left end.
int sign_at_left_end(const Polynomial& p, const Dyadic& interval) {
  Integer value = 0;
  Integer weight = 1;
  for (std::size_t i = p.size(); i-- > 0;) {
    value = value * interval.m + p[i] * weight;
    weight <<= interval.k;
  }
  return value.sign();
}

struct Signs {
  int variations = 0;
  int first = 0;  ///< of the first coefficient that is not 0
};

/// Returns the signs of the Bernstein coefficients over the interval. By Descartes' rule the number of roots in the
/// open interval, with multiplicity, is the number of variations, or less by an even number.
Signs signs_over(const Polynomial& p, const Dyadic& interval) {
  const std::size_t size = p.size();
  Polynomial q(size);  // q(x) = p((m + x) / 2^k) up to a positive factor
  for (std::size_t i = 0; i < size; ++i) q[i] = p[i] << (interval.k * static_cast<unsigned>(size - 1 - i));
  for (std::size_t i = 0; i + 1 < size; ++i) {
    for (std::size_t j = size - 1; j-- > i;) q[j] += interval.m * q[j + 1];
  }
  // Coefficients of (1 + y)^degree q(y / (1 + y)): reversed, shifted by 1, reversed.
  std::reverse(q.begin(), q.end());
  for (std::size_t i = 0; i + 1 < size; ++i) {
    for (std::size_t j = size - 1; j-- > i;) q[j] += q[j + 1];
  }
  std::reverse(q.begin(), q.end());

  Signs signs;
  int previous = 0;
  for (const Integer& coefficient : q) {
    const int sign = coefficient.sign();
    if (sign == 0) continue;
    if (previous == 0) signs.first = sign;
    if (previous * sign < 0) ++signs.variations;
    previous = sign;
  }
  return signs;
}

/// A root in [0, 1]: either the only, simple root of `polynomial` in the open interval, or the interval's left end.
struct Root {
  Polynomial polynomial;
  Dyadic interval;
  bool is_left_end = false;

  void refine() {
    const Dyadic right = interval.right_half();
    if (sign_at_left_end(polynomial, right) == 0) {
      interval = right;
      is_left_end = true;
    } else {
      const Dyadic left = interval.left_half();
      interval = signs_over(polynomial, left).variations % 2 == 1 ? left : right;
    }
  }

  TimeBracket bracket() {
    constexpr unsigned kTimeBits = 42;
    while (!is_left_end && interval.k < kTimeBits) refine();
    return interval.bracket(is_left_end);
  }

  int sign_of(const Polynomial& q) {
    constexpr int kRefinementsBeforeDivisor = 16;
    if (q.empty()) return 0;
    for (int refinements = 0; !is_left_end; ++refinements) {
      const Signs signs = signs_over(q, interval);
      if (signs.variations == 0) return signs.first;
      if (refinements == kRefinementsBeforeDivisor) {
        const Polynomial common = greatest_common_divisor(polynomial, q);
        if (common.size() > 1 && signs_over(common, interval).variations % 2 == 1) return 0;
      }
      refine();
    }
    return sign_at_left_end(q, interval);
  }
};

template <class Condition>
std::optional<Root> first_where(std::vector<Root> times, const Condition& condition) {
  const auto found = std::find_if(times.begin(), times.end(), condition);
  return found == times.end() ? std::nullopt : std::optional<Root>(*found);
}

Root time_zero() {
  return {{}, {}, true};
}

void isolate_inside(const Polynomial& p, const Dyadic& interval, std::vector<Root>& roots) {
  const int variations = signs_over(p, interval).variations;
  if (variations == 1) roots.push_back({p, interval, false});
  if (variations < 2) return;
  const Dyadic right = interval.right_half();
  if (sign_at_left_end(p, right) == 0) roots.push_back({p, right, true});
  isolate_inside(p, interval.left_half(), roots);
  isolate_inside(p, right, roots);
}

/// Returns all roots in [0, 1] of a polynomial that is not 0, in ascending order.
std::vector<Root> roots_of(const Polynomial& p) {
  std::vector<Root> roots;
  for (const int end : {0, 1}) {
    const Dyadic at_end{end, 0};
    if (sign_at_left_end(p, at_end) == 0) roots.push_back({p, at_end, true});
  }
  const bool may_repeat = signs_over(p, {}).variations > 1;
  isolate_inside(may_repeat ? without_repeated_roots(p) : p, {}, roots);
  std::sort(roots.begin(), roots.end(), [](const Root& a, const Root& b) {
    const Integer left = a.interval.m << b.interval.k;
    const Integer right = b.interval.m << a.interval.k;
    return left != right ? left < right : a.is_left_end && !b.is_left_end;
  });
  return roots;
}

using Moving = std::array<Polynomial, 3>;

Moving operator-(const Moving& p, const Moving& q) {
  return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}
Moving operator+(const Moving& p, const Moving& q) {
  return {p[0] + q[0], p[1] + q[1], p[2] + q[2]};
}

Polynomial dot(const Moving& p, const Moving& q) {
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

Moving cross(const Moving& p, const Moving& q) {
  return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

bool is_zero(const Moving& p) {
  return p[0].empty() && p[1].empty() && p[2].empty();
}

bool is_zero_at(const Moving& p, Root& time) {
  return time.sign_of(p[0]) == 0 && time.sign_of(p[1]) == 0 && time.sign_of(p[2]) == 0;
}

/// A point p and the segment from 0 to d.
struct PointSegment {
  Moving p, d;

  /// Returns a polynomial that is at most 0 exactly when the point is on the segment, if the points are collinear: p .
  /// (p - d). d may be 0.
  Polynomial excess() const { return dot(p, p - d); }

  bool touches_at(Root& time) const { return is_zero_at(cross(p, d), time) && time.sign_of(excess()) <= 0; }

  std::optional<Root> first_contact() const {
    const Moving collinearity = cross(p, d);
    if (is_zero(collinearity)) {
      Root start = time_zero();
      return start.sign_of(excess()) <= 0 ? start : first_where(roots_of(excess()), [](Root&) { return true; });
    }
    Polynomial common;
    for (const Polynomial& component : collinearity) common = greatest_common_divisor(common, component);
    return first_where(roots_of(common), [&](Root& time) { return time.sign_of(excess()) <= 0; });
  }
};

/// Two features that move; offset = a - x b - y c for both kinds, as in softcd/math/closest_point.hpp.
struct MovingPair {
  Moving a, b, c;
  std::vector<PointSegment> boundary;  ///< the point-segment pairs that decide when the features are collinear
  bool is_edge_edge;

  /// Returns whether the features touch at a time at which the four points are coplanar.
  bool touches_at(Root& time) const {
    const Moving normal = cross(b, c);
    if (is_zero_at(normal, time)) {
      return std::any_of(boundary.begin(), boundary.end(),
                         [&](const PointSegment& side) { return side.touches_at(time); });
    }
    const Polynomial whole = dot(normal, normal);
    const Polynomial x = dot(cross(a, c), normal);
    const Polynomial y = dot(cross(b, a), normal);
    if (time.sign_of(y) < 0) return false;
    return is_edge_edge ? time.sign_of(x) <= 0 && time.sign_of(whole + x) >= 0 && time.sign_of(whole - y) >= 0
                        : time.sign_of(x) >= 0 && time.sign_of(whole - x - y) >= 0;
  }

  /// Returns times of which the earliest is the first contact. Features that are coplanar all along and do not touch at
  /// t = 0 meet first where a point meets a segment.
  std::vector<Root> first_contacts() const {
    std::vector<Root> times;
    const auto add = [&](const std::optional<Root>& time) {
      if (time) times.push_back(*time);
    };
    const auto touches = [this](Root& time) { return touches_at(time); };
    const Polynomial volume = dot(a, cross(b, c));
    if (!volume.empty()) {
      add(first_where(roots_of(volume), touches));
      return times;
    }
    add(first_where({time_zero()}, touches));
    if (times.empty()) {
      for (const PointSegment& side : boundary) add(side.first_contact());
    }
    return times;
  }
};

using Coordinates = std::array<std::array<Integer, 3>, 8>;

Moving motion_of(const Coordinates& rows, std::size_t point) {
  Moving motion;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    motion[axis] = {rows[point][axis], rows[point + 4][axis] - rows[point][axis]};
    trim(motion[axis]);
  }
  return motion;
}

MovingPair moving_vertex_triangle(const Coordinates& rows) {
  const Moving f0 = motion_of(rows, 1);
  const Moving a = motion_of(rows, 0) - f0;
  const Moving b = motion_of(rows, 2) - f0;
  const Moving c = motion_of(rows, 3) - f0;
  return {a, b, c, {{a, b}, {a, c}, {a - b, c - b}}, false};
}

MovingPair moving_edge_edge(const Coordinates& rows) {
  const Moving e0 = motion_of(rows, 0);
  const Moving g0 = motion_of(rows, 2);
  const Moving a = e0 - g0;
  const Moving b = motion_of(rows, 1) - e0;
  const Moving c = motion_of(rows, 3) - g0;
  const Moving back = g0 - e0;
  return {a, b, c, {{a, c}, {a + b, c}, {back, b}, {back + c, b}}, true};
}

Coordinates to_integers(std::span<const Vec3d, 8> rows) {
  constexpr int kMantissaBits = 53;
  int lowest_exponent = 0;
  bool is_first = true;
  for (const Vec3d& row : rows) {
    for (int axis = 0; axis < 3; ++axis) {
      if (row[axis] == 0.0) continue;
      int exponent = 0;
      std::frexp(row[axis], &exponent);
      lowest_exponent = is_first ? exponent : std::min(lowest_exponent, exponent);
      is_first = false;
    }
  }
  Coordinates integers;
  for (std::size_t i = 0; i < 8; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      int exponent = 0;
      const double mantissa = std::frexp(rows[i][axis], &exponent);
      Integer& integer = integers[i][static_cast<std::size_t>(axis)];
      integer = static_cast<long long>(std::ldexp(mantissa, kMantissaBits));
      if (integer != 0) integer <<= static_cast<unsigned>(exponent - lowest_exponent);
    }
  }
  return integers;
}

Coordinates to_integers(std::span<const Fraction, 24> coordinates) {
  Integer common = 1;
  for (const Fraction& fraction : coordinates) common = lcm(common, Integer(fraction.denominator));
  Coordinates integers;
  for (std::size_t i = 0; i < 24; ++i) {
    integers[i / 3][i % 3] = Integer(coordinates[i].numerator) * (common / Integer(coordinates[i].denominator));
  }
  return integers;
}

std::optional<TimeBracket> earliest(std::vector<Root> times) {
  if (times.empty()) return std::nullopt;
  TimeBracket first{1.0, 1.0};
  for (Root& time : times) {
    const TimeBracket bracket = time.bracket();
    first = {std::min(first.lo, bracket.lo), std::min(first.hi, bracket.hi)};
  }
  return first;
}

/// Returns whether the boxes of the sides' paths have a gap. Side a is the first `side_a` rows of each four.
bool boxes_are_disjoint(std::span<const Vec3d, 8> rows, std::size_t side_a) {
  for (int axis = 0; axis < 3; ++axis) {
    double low[2] = {INFINITY, INFINITY};
    double high[2] = {-INFINITY, -INFINITY};
    for (std::size_t row = 0; row < 8; ++row) {
      const std::size_t side = row % 4 < side_a ? 0 : 1;
      low[side] = std::min(low[side], rows[row][axis]);
      high[side] = std::max(high[side], rows[row][axis]);
    }
    if (high[0] < low[1] || high[1] < low[0]) return true;
  }
  return false;
}

using Long = Vec3<long double>;
static_assert(std::numeric_limits<long double>::max_exponent >= 16384,
              "products of three coordinates neither overflow"
              " nor underflow");

/// Returns whether the points are never coplanar: the Bernstein coefficients of the volume's cubic have one sign. Each
/// coefficient is a mean of up to 18 products of three differences, none of them above A B C. Its error is at most 3
/// roundings of the differences, 2 of the products and 19 of sums and mean. Each has the relative size epsilon / 2 of 6
/// A B C: 72 epsilon A B C in all.
bool is_never_coplanar(std::span<const Vec3d, 8> rows, std::size_t side_a) {
  const auto vector = [&](std::size_t from, std::size_t to) {
    return vec3_cast<long double>(rows[to]) - vec3_cast<long double>(rows[from]);
  };
  const auto size_of = [](const Long& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); };
  Long a[2], b[2], c[2];
  for (const std::size_t end : {0U, 1U}) {
    const std::size_t first = 4 * end;
    const bool is_edge_edge = side_a == 2;
    a[end] = vector(is_edge_edge ? first + 2 : first + 1, first);
    b[end] = is_edge_edge ? vector(first, first + 1) : vector(first + 1, first + 2);
    c[end] = is_edge_edge ? vector(first + 2, first + 3) : vector(first + 1, first + 3);
  }
  const auto volume = [&](int i, int j, int k) { return softcd::dot(a[i], softcd::cross(b[j], c[k])); };
  const long double coefficients[4] = {volume(0, 0, 0), (volume(1, 0, 0) + volume(0, 1, 0) + volume(0, 0, 1)) / 3,
                                       (volume(0, 1, 1) + volume(1, 0, 1) + volume(1, 1, 0)) / 3, volume(1, 1, 1)};
  const auto largest = [&](const Long(&v)[2]) { return std::max(size_of(v[0]), size_of(v[1])); };
  const long double error = 100 * std::numeric_limits<long double>::epsilon() * largest(a) * largest(b) * largest(c);
  const auto [lowest, highest] = std::minmax_element(std::begin(coefficients), std::end(coefficients));
  return *lowest > error || *highest < -error;
}

/// Returns whether the features are apart, as far as floating point can decide. It decides most pairs that do not
/// touch.
bool surely_apart(std::span<const Vec3d, 8> rows, std::size_t side_a) {
  return boxes_are_disjoint(rows, side_a) || is_never_coplanar(rows, side_a);
}

using Exact = Vec3<Rational>;

Exact to_exact(Vec3d p) {
  return {Rational(p.x), Rational(p.y), Rational(p.z)};
}

Rational squared_point_segment(const Exact& p, const Exact& d) {
  const Rational along = softcd::dot(p, d);
  const Rational whole = softcd::dot(d, d);
  if (along <= 0) return softcd::dot(p, p);
  if (along >= whole) return softcd::dot(p - d, p - d);
  return softcd::dot(p, p) - along * along / whole;
}

/// Returns the squared distance of the planes or lines, if their nearest points are inside the features.
std::optional<Rational> squared_inside(const Exact& a, const Exact& b, const Exact& c, bool is_edge_edge) {
  const Exact normal = softcd::cross(b, c);
  const Rational whole = softcd::dot(normal, normal);
  const Rational x = softcd::dot(softcd::cross(a, c), normal);
  const Rational y = softcd::dot(softcd::cross(b, a), normal);
  const bool is_inside =
      is_edge_edge ? x <= 0 && x >= -whole && y >= 0 && y <= whole : x >= 0 && y >= 0 && x + y <= whole;
  if (whole == 0 || !is_inside) return std::nullopt;
  const Rational height = softcd::dot(a, normal);
  return Rational(height * height / whole);
}

double smallest(std::initializer_list<Rational> sides, const std::optional<Rational>& inside) {
  const Rational side = std::min(sides);
  return (inside && *inside < side ? *inside : side).convert_to<double>();
}

}  // namespace

bool collides_vertex_triangle(std::span<const Vec3d, 8> rows) {
  return !surely_apart(rows, 1) && !moving_vertex_triangle(to_integers(rows)).first_contacts().empty();
}

bool collides_edge_edge(std::span<const Vec3d, 8> rows) {
  return !surely_apart(rows, 2) && !moving_edge_edge(to_integers(rows)).first_contacts().empty();
}

std::optional<TimeBracket> first_contact_vertex_triangle(std::span<const Vec3d, 8> rows) {
  if (surely_apart(rows, 1)) return std::nullopt;
  return earliest(moving_vertex_triangle(to_integers(rows)).first_contacts());
}

std::optional<TimeBracket> first_contact_edge_edge(std::span<const Vec3d, 8> rows) {
  if (surely_apart(rows, 2)) return std::nullopt;
  return earliest(moving_edge_edge(to_integers(rows)).first_contacts());
}

bool collides_vertex_triangle(std::span<const Fraction, 24> coordinates) {
  return !moving_vertex_triangle(to_integers(coordinates)).first_contacts().empty();
}

bool collides_edge_edge(std::span<const Fraction, 24> coordinates) {
  return !moving_edge_edge(to_integers(coordinates)).first_contacts().empty();
}

double squared_distance_vertex_triangle(std::span<const Vec3d, 4> rows) {
  const Exact f0 = to_exact(rows[1]);
  const Exact a = to_exact(rows[0]) - f0;
  const Exact b = to_exact(rows[2]) - f0;
  const Exact c = to_exact(rows[3]) - f0;
  return smallest({squared_point_segment(a, b), squared_point_segment(a, c), squared_point_segment(a - b, c - b)},
                  squared_inside(a, b, c, false));
}

double squared_distance_edge_edge(std::span<const Vec3d, 4> rows) {
  const Exact e0 = to_exact(rows[0]);
  const Exact g0 = to_exact(rows[2]);
  const Exact a = e0 - g0;
  const Exact b = to_exact(rows[1]) - e0;
  const Exact c = to_exact(rows[3]) - g0;
  return smallest({squared_point_segment(a, c), squared_point_segment(a + b, c), squared_point_segment(-a, b),
                   squared_point_segment(c - a, b)},
                  squared_inside(a, b, c, true));
}

}  // namespace softcd::test
