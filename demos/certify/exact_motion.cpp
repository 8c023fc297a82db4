#include "exact_motion.hpp"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <vector>

// The proof. Let n = b x c, with a, b, c the differences below. The four vertices are coplanar where a . n = 0. If the
// features are coplanar and n is not 0, they meet where two weights, each of them a polynomial over |n|^2, are strictly
// between their bounds. So the features pass through each other if, within a part of the step,
// - a . n has different signs at both ends, and
// - the weights are strictly between their bounds throughout, which the signs of Bernstein coefficients show.
namespace softcd::demo {
namespace {

using Integer = boost::multiprecision::cpp_int;

/// A polynomial over a part of the step, by its Bernstein coefficients times binomials: products are convolutions.
using Polynomial = std::vector<Integer>;

Polynomial operator*(const Polynomial& p, const Polynomial& q) {
  Polynomial product(p.size() + q.size() - 1);
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t j = 0; j < q.size(); ++j) product[i + j] += p[i] * q[j];
  }
  return product;
}

/// The degrees must agree.
Polynomial operator+(Polynomial p, const Polynomial& q) {
  for (std::size_t i = 0; i < p.size(); ++i) p[i] += q[i];
  return p;
}

Polynomial operator-(Polynomial p, const Polynomial& q) {
  for (std::size_t i = 0; i < p.size(); ++i) p[i] -= q[i];
  return p;
}

bool is_certainly_positive(const Polynomial& p) {
  return std::all_of(p.begin(), p.end(), [](const Integer& c) { return c > 0; });
}

using Path = std::array<Polynomial, 3>;

Path operator-(const Path& a, const Path& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Polynomial dot(const Path& a, const Path& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Path cross(const Path& a, const Path& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Coordinates as integers, all in the same unit: a power of two.
class Units {
 public:
  void include(double x) {
    if (x != 0) lowest_ = std::min(lowest_, std::ilogb(x) - 52);
  }
  Integer of(double x) const {
    if (x == 0) return 0;
    const int exponent = std::ilogb(x) - 52;
    const Integer figures = static_cast<long long>(std::scalbn(x, -exponent));
    return figures << static_cast<unsigned>(exponent - lowest_);
  }

 private:
  int lowest_ = std::numeric_limits<int>::max();
};

constexpr int kTimeBits = 40;

/// A part of the step, from `begin` to `end` times 2^-kTimeBits.
struct Part {
  long long begin, end;
};

/// Returns a vertex's path within a part of the step, in units times 2^-kTimeBits.
Path path_of(const Units& units, const Vec3d& x_t0, const Vec3d& x_t1, const Part& part) {
  Path path;
  for (int axis = 0; axis < 3; ++axis) {
    const Integer start = units.of(x_t0[axis]);
    const Integer motion = units.of(x_t1[axis]) - start;
    const Integer scaled = start << kTimeBits;
    path[static_cast<std::size_t>(axis)] = {Integer(scaled + motion * part.begin), Integer(scaled + motion * part.end)};
  }
  return path;
}

bool pass_through_within(ContactKind kind, const std::array<Path, 4>& x) {
  const bool is_vertex_triangle = kind == ContactKind::vertex_triangle;
  const Path a = is_vertex_triangle ? x[0] - x[1] : x[2] - x[0];
  const Path b = is_vertex_triangle ? x[2] - x[1] : x[1] - x[0];
  const Path c = is_vertex_triangle ? x[3] - x[1] : x[3] - x[2];
  const Path n = cross(b, c);
  const Polynomial height = dot(a, n);
  if (height.front().sign() * height.back().sign() >= 0) return false;
  const Polynomial whole = dot(n, n);
  const Polynomial first = dot(cross(a, c), n);
  const Polynomial second = dot(is_vertex_triangle ? cross(b, a) : cross(a, b), n);
  if (!is_certainly_positive(first) || !is_certainly_positive(second)) return false;
  // Vertex-triangle: weights of the second and third corner. Edge-edge: places on either edge.
  if (is_vertex_triangle) return is_certainly_positive(whole - first - second);
  return is_certainly_positive(whole - first) && is_certainly_positive(whole - second);
}

}  // namespace

bool certainly_pass_through(ContactKind kind, const PairPositions& x_t0, const PairPositions& x_t1, double nearby) {
  Units units;
  for (const PairPositions* end : {&x_t0, &x_t1}) {
    for (const Vec3d& x : *end) {
      for (int axis = 0; axis < 3; ++axis) units.include(x[axis]);
    }
  }
  const double whole_step = std::scalbn(1.0, kTimeBits);
  // Times of impact are floats and may be early. A short part of the step suffices where they are accurate.
  for (const double reach : {0x1p-22, 0x1p-17, 0x1p-12, 0x1p-7, 0x1p-2}) {
    const Part part{static_cast<long long>(std::floor(std::max(nearby - reach, 0.0) * whole_step)),
                    static_cast<long long>(std::ceil(std::min(nearby + reach, 1.0) * whole_step))};
    std::array<Path, 4> x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = path_of(units, x_t0[i], x_t1[i], part);
    if (pass_through_within(kind, x)) return true;
  }
  return false;
}

}  // namespace softcd::demo
