#include "queries.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace softcd::test {
namespace {

double rounded_to_float(double x) {
  volatile float narrow = static_cast<float>(x);
  return static_cast<double>(narrow);
}

Vec3d at(const Rows& rows, std::size_t point, double t) {
  return (1.0 - t) * rows[point] + t * rows[point + 4];
}

/// Returns weights of a point of the features; in a third of the cases it is on an edge or a corner.
std::array<double, 4> random_weights(Random& random, ContactKind kind) {
  double x = random.unit();
  double y = random.unit();
  if (random.chance(0.2)) x = random.chance(0.5) ? 0.0 : 1.0;
  if (random.chance(0.2)) y = random.chance(0.5) ? 0.0 : 1.0;
  if (kind == ContactKind::edge_edge) return {1.0 - x, x, 1.0 - y, y};
  if (x + y > 1.0) {
    x = 1.0 - x;
    y = 1.0 - y;
  }
  return {1.0, 1.0 - x - y, x, y};
}

Vec3d separation(const Rows& rows, ContactKind kind, const std::array<double, 4>& w, double t) {
  const Vec3d first = w[0] * at(rows, 0, t);
  const Vec3d second = w[1] * at(rows, 1, t);
  const Vec3d rest = w[2] * at(rows, 2, t) + w[3] * at(rows, 3, t);
  return kind == ContactKind::edge_edge ? (first + second) - rest : first - (second + rest);
}

/// Moves side a so that the weighted points meet at t.
void make_touch(Random& random, ContactKind kind, Rows& rows) {
  const double t = random.chance(0.2) ? (random.chance(0.5) ? 0.0 : 1.0) : random.unit();
  const Vec3d shift = separation(rows, kind, random_weights(random, kind), t);
  for (const std::size_t point : {0U, 1U}) {
    if (point == 1 && kind == ContactKind::vertex_triangle) continue;
    rows[point] = rows[point] - shift;
    rows[point + 4] = rows[point + 4] - shift;
  }
}

/// Makes a query whose cubic has a double root at t. Side b contains the x axis at the time t, and turns about it. Side
/// a passes through it along y, in the plane z = 0. The height of one over the other is rate (time - t) y with y =
/// slide (time - t).
void make_tangential(Random& random, ContactKind kind, Rows& rows) {
  const double t = random.uniform(0.25, 0.75);
  const Vec3d axis = random.direction();
  const Vec3d other = cross(axis, random.direction());
  const Vec3d normal = cross(axis, other);
  const double rate = random.uniform(0.5, 2.0);
  const double slide = random.uniform(0.5, 1.0);
  for (const std::size_t first : {0U, 4U}) {
    const double since = (first == 0 ? 0.0 : 1.0) - t;
    const auto flat = [&](double x) { return x * axis + (slide * since) * other; };
    const auto turned = [&](double x, double y) { return x * axis + y * other + (rate * since * y) * normal; };
    if (kind == ContactKind::vertex_triangle) {
      rows[first] = flat(0.0);
      rows[first + 1] = turned(-1.0, -2.0);
      rows[first + 2] = turned(3.0, -1.0);
      rows[first + 3] = turned(-1.0, 3.0);
    } else {
      rows[first] = flat(-1.0);
      rows[first + 1] = flat(1.0);
      rows[first + 2] = turned(0.0, -2.0);
      rows[first + 3] = turned(0.0, 2.0);
    }
  }
}

void make_degenerate(Random& random, ContactKind kind, Rows& rows) {
  const auto copy = [&](std::size_t from, std::size_t to, std::size_t time) { rows[to + time] = rows[from + time]; };
  const bool at_t0 = random.chance(0.8);
  const bool at_t1 = !at_t0 || random.chance(0.8);
  for (const std::size_t time : {0U, 4U}) {
    if (!(time == 0 ? at_t0 : at_t1)) continue;
    switch (random.below(4)) {
      case 0:
        copy(2, 3, time);
        break;
      case 1:
        copy(2, 3, time);
        if (kind == ContactKind::vertex_triangle) copy(2, 1, time);
        if (kind == ContactKind::edge_edge) copy(0, 1, time);
        break;
      case 2:
        rows[3 + time] = 2.0 * rows[2 + time] - rows[1 + time];
        break;
      default:
        if (kind == ContactKind::edge_edge) {
          rows[3 + time] = rows[2 + time] + 0.5 * (rows[1 + time] - rows[time]);
        } else {
          rows[3 + time] = 0.5 * (rows[2 + time] + rows[1 + time]);
        }
    }
  }
}

void make_needle(Random& random, Rows& rows) {
  const double aspect = std::pow(10.0, -random.uniform(2.0, 8.0));
  for (const std::size_t time : {0U, 4U}) {
    rows[3 + time] = rows[2 + time] + aspect * random.in_box(1.0);
    if (random.chance(0.5)) std::swap(rows[3 + time], rows[1 + time]);
  }
}

}  // namespace

const char* name_of(Family family) {
  constexpr std::array<const char*, kFamilies> kNames{
      "random", "touching", "near_grazing", "tangential", "axis_aligned", "planar", "degenerate", "needle", "still"};
  return kNames[static_cast<std::size_t>(family)];
}

Query make_query(Random& random, ContactKind kind, Family family, bool is_single) {
  Rows rows;
  for (Vec3d& row : rows) row = random.in_box(1.0);
  switch (family) {
    case Family::random:
      break;
    case Family::touching:
      make_touch(random, kind, rows);
      break;
    case Family::near_grazing: {
      make_touch(random, kind, rows);
      const double push = std::pow(10.0, -random.uniform(6.0, 16.0));
      const std::size_t pushed = random.below(8);
      rows[pushed] = rows[pushed] + push * random.direction();
      break;
    }
    case Family::tangential:
      make_tangential(random, kind, rows);
      break;
    case Family::axis_aligned:
      for (Vec3d& row : rows) row = {std::floor(2.0 * row.x), std::floor(2.0 * row.y), std::floor(2.0 * row.z)};
      break;
    case Family::planar: {
      const bool is_axis_plane = random.chance(0.5);
      const Vec3d u = random.direction();
      const Vec3d v = random.direction();
      for (Vec3d& row : rows) row = is_axis_plane ? Vec3d{row.x, row.y, 0.25} : row.x * u + row.y * v;
      if (random.chance(0.5)) make_touch(random, kind, rows);
      break;
    }
    case Family::degenerate:
      make_degenerate(random, kind, rows);
      if (random.chance(0.5)) make_touch(random, kind, rows);
      break;
    case Family::needle:
      make_needle(random, rows);
      make_touch(random, kind, rows);
      break;
    case Family::still:
      for (std::size_t point = random.chance(0.1) ? 0 : 1; point < 4; ++point) rows[point + 4] = rows[point];
      if (random.chance(0.5)) make_touch(random, kind, rows);
      break;
  }
  if (is_single) {
    for (Vec3d& row : rows) row = {rounded_to_float(row.x), rounded_to_float(row.y), rounded_to_float(row.z)};
  }
  return {kind, rows};
}

Rows scaled(const Rows& rows, double factor) {
  Rows result;
  std::transform(rows.begin(), rows.end(), result.begin(), [&](const Vec3d& row) { return factor * row; });
  return result;
}

bool collides(const Query& query) {
  return query.kind == ContactKind::vertex_triangle ? collides_vertex_triangle(query.rows)
                                                    : collides_edge_edge(query.rows);
}

std::optional<TimeBracket> first_contact(const Query& query) {
  return query.kind == ContactKind::vertex_triangle ? first_contact_vertex_triangle(query.rows)
                                                    : first_contact_edge_edge(query.rows);
}

std::array<Vec3d, 4> rows_at(const Rows& rows, double t) {
  return {at(rows, 0, t), at(rows, 1, t), at(rows, 2, t), at(rows, 3, t)};
}

double squared_distance(ContactKind kind, std::span<const Vec3d, 4> rows) {
  return kind == ContactKind::vertex_triangle ? squared_distance_vertex_triangle(rows)
                                              : squared_distance_edge_edge(rows);
}

double documented_tolerance(const Query& query, double epsilon) {
  double sizes = 0.0;
  for (std::size_t vector = 0; vector < 3; ++vector) {
    double size = 0.0;
    for (const std::size_t time : {0U, 4U}) {
      const Vec3d* p = &query.rows[time];
      const std::array<Vec3d, 3> differences = query.kind == ContactKind::vertex_triangle
                                                   ? std::array<Vec3d, 3>{p[0] - p[1], p[2] - p[1], p[3] - p[1]}
                                                   : std::array<Vec3d, 3>{p[0] - p[2], p[1] - p[0], p[3] - p[2]};
      size = std::max(size, max_norm(differences[vector]));
    }
    sizes += size;
  }
  return 32.0 * epsilon * sizes;
}

std::string to_string(const Query& query) {
  std::string text = query.kind == ContactKind::vertex_triangle ? "vertex-triangle\n" : "edge-edge\n";
  for (const Vec3d& row : query.rows) {
    std::array<char, 100> line;
    std::snprintf(line.data(), line.size(), "{%a, %a, %a}\n", row.x, row.y, row.z);
    text += line.data();
  }
  return text;
}

}  // namespace softcd::test
