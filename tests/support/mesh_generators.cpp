#include "mesh_generators.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "random.hpp"

namespace softcd::test {
namespace {

constexpr double kPi = std::numbers::pi;

std::uint32_t add_vertex(Mesh& mesh, Vec3d position) {
  mesh.positions.push_back(position);
  return static_cast<std::uint32_t>(mesh.positions.size() - 1);
}

/// Joins the vertices of a columns x rows lattice, row by row, starting at vertex 0.
void add_lattice_triangles(Mesh& mesh, std::uint32_t columns, std::uint32_t rows, bool wrap_columns, bool wrap_rows) {
  const std::uint32_t last_column = wrap_columns ? columns : columns - 1;
  const std::uint32_t last_row = wrap_rows ? rows : rows - 1;
  for (std::uint32_t row = 0; row < last_row; ++row) {
    for (std::uint32_t column = 0; column < last_column; ++column) {
      const std::uint32_t next_column = (column + 1) % columns;
      const std::uint32_t next_row = (row + 1) % rows;
      const std::uint32_t a = row * columns + column;
      const std::uint32_t b = row * columns + next_column;
      const std::uint32_t c = next_row * columns + next_column;
      const std::uint32_t d = next_row * columns + column;
      mesh.triangles.push_back({{a, b, c}});
      mesh.triangles.push_back({{a, c, d}});
    }
  }
}

Vec3d on_sphere(Vec3d p, double radius) {
  return (radius / std::sqrt(squared_norm(p))) * p;
}

Mesh icosahedron(double radius) {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  Mesh mesh;
  for (const double sign_a : {-1.0, 1.0}) {
    for (const double sign_b : {-g, g}) {
      add_vertex(mesh, on_sphere({0.0, sign_a, sign_b}, radius));
      add_vertex(mesh, on_sphere({sign_a, sign_b, 0.0}, radius));
      add_vertex(mesh, on_sphere({sign_b, 0.0, sign_a}, radius));
    }
  }
  const double edge = 4.0 * radius / std::sqrt(10.0 + 2.0 * std::sqrt(5.0));
  const auto adjacent = [&](std::uint32_t a, std::uint32_t b) {
    return squared_norm(mesh.positions[a] - mesh.positions[b]) < 1.1 * edge * edge;
  };
  for (std::uint32_t a = 0; a < 12; ++a) {
    for (std::uint32_t b = a + 1; b < 12; ++b) {
      for (std::uint32_t c = b + 1; c < 12; ++c) {
        if (adjacent(a, b) && adjacent(b, c) && adjacent(a, c)) mesh.triangles.push_back({{a, b, c}});
      }
    }
  }
  return mesh;
}

Mesh subdivided(const Mesh& mesh, double radius) {
  Mesh finer;
  finer.positions = mesh.positions;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), 0);
    if (is_new) entry->second = add_vertex(finer, on_sphere(mesh.positions[a] + mesh.positions[b], radius));
    return entry->second;
  };
  for (const Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = triangle.v;
    const std::uint32_t ab = middle(a, b);
    const std::uint32_t bc = middle(b, c);
    const std::uint32_t ca = middle(c, a);
    finer.triangles.insert(finer.triangles.end(), {{{a, ab, ca}}, {{ab, b, bc}}, {{ca, bc, c}}, {{ab, bc, ca}}});
  }
  return finer;
}

Triangle new_soup_triangle(Mesh& mesh, const SoupOptions& options, Random& random) {
  const double u = random.unit();
  const double radius = options.largest / options.size_ratio * std::pow(options.size_ratio, u * u * u * u);
  const Vec3d centre = random.in_box(options.half_extent);
  Vec3d corners[3];
  for (Vec3d& corner : corners) corner = centre + radius * random.direction();
  if (random.chance(options.needle_share)) corners[2] = corners[0] + (0.001 * radius) * random.direction();
  Triangle triangle{};
  for (int i = 0; i < 3; ++i) triangle.v[i] = add_vertex(mesh, corners[i]);
  return triangle;
}

void degenerate(Mesh& mesh, Triangle& triangle, Random& random) {
  const Vec3d first = mesh.positions[triangle.v[0]];
  const Vec3d second = mesh.positions[triangle.v[1]];
  switch (random.below(5)) {
    case 0:
      triangle.v[2] = triangle.v[1];
      break;
    case 1:
      triangle.v[1] = triangle.v[2] = triangle.v[0];
      break;
    case 2:
      mesh.positions[triangle.v[2]] = 0.5 * (first + second);
      break;
    case 3:
      mesh.positions[triangle.v[2]] = second;
      break;
    default:
      mesh.positions[triangle.v[1]] = mesh.positions[triangle.v[2]] = first;
      break;
  }
}

void join_to_earlier(const Mesh& mesh, Triangle& triangle, Random& random) {
  const Triangle& other = mesh.triangles[random.below(static_cast<std::uint32_t>(mesh.triangles.size()))];
  triangle.v[0] = other.v[0];
  if (random.chance(0.5)) triangle.v[1] = other.v[1];
}

}  // namespace

void snap_to_grid(Positions3& positions, int bits) {
  const double scale = std::ldexp(1.0, bits);
  const auto snap = [scale](double x) { return std::floor(x * scale + 0.5) / scale; };
  for (Vec3d& p : positions) p = {snap(p.x), snap(p.y), snap(p.z)};
}

Mesh triangle_soup(const SoupOptions& options) {
  Random random(options.seed);
  Mesh mesh;
  for (std::uint32_t i = 0; i < options.triangle_count; ++i) {
    Triangle triangle = new_soup_triangle(mesh, options, random);
    if (random.chance(options.degenerate_share)) degenerate(mesh, triangle, random);
    if (i > 0 && random.chance(options.joined_share)) join_to_earlier(mesh, triangle, random);
    mesh.triangles.push_back(triangle);
  }
  snap_to_grid(mesh.positions, options.grid_bits);
  return mesh;
}

Mesh grid_cloth(std::uint32_t columns, std::uint32_t rows, double spacing) {
  Mesh mesh;
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      add_vertex(mesh, {spacing * (column - 0.5 * (columns - 1)), spacing * (row - 0.5 * (rows - 1)), 0.0});
    }
  }
  add_lattice_triangles(mesh, columns, rows, false, false);
  return mesh;
}

Mesh crumpled_cloth(std::uint32_t columns, std::uint32_t rows, double spacing, double gap, std::uint64_t seed) {
  Random random(seed);
  Mesh mesh = grid_cloth(columns, rows, spacing);
  const double fold = 8.0 * spacing;
  for (Vec3d& p : mesh.positions) {
    const double along = p.x / fold;
    const double layer = std::floor(along);
    const double within = along - layer;
    const bool backwards = std::fmod(std::abs(layer), 2.0) == 1.0;
    p = {fold * (backwards ? 1.0 - within : within), p.y, gap * along};
    p = p + random.in_box(0.2 * gap);
    p.z += gap * std::sin(3.0 * p.y / fold);
  }
  snap_to_grid(mesh.positions, 17);
  return mesh;
}

Mesh icosphere(int level, double radius) {
  Mesh mesh = icosahedron(radius);
  for (int i = 0; i < level; ++i) mesh = subdivided(mesh, radius);
  return mesh;
}

Mesh torus(double major_radius, double minor_radius, std::uint32_t major_count, std::uint32_t minor_count) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < major_count; ++i) {
    const double u = 2.0 * kPi * i / major_count;
    for (std::uint32_t j = 0; j < minor_count; ++j) {
      const double v = 2.0 * kPi * j / minor_count;
      const double distance = major_radius + minor_radius * std::cos(v);
      add_vertex(mesh, {distance * std::cos(u), distance * std::sin(u), minor_radius * std::sin(v)});
    }
  }
  add_lattice_triangles(mesh, minor_count, major_count, true, true);
  return mesh;
}

Mesh tube(double radius, double length, std::uint32_t around, std::uint32_t along) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < along; ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const double u = 2.0 * kPi * j / around;
      add_vertex(mesh, {radius * std::cos(u), radius * std::sin(u), length * (i / (along - 1.0) - 0.5)});
    }
  }
  add_lattice_triangles(mesh, around, along, true, false);
  return mesh;
}

Mesh moved(Mesh mesh, Vec3d offset) {
  mesh.positions = translated(mesh.positions, offset);
  return mesh;
}

Mesh scaled(Mesh mesh, double factor) {
  mesh.positions = contracted(mesh.positions, factor);
  return mesh;
}

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  const auto first = static_cast<std::uint32_t>(a.positions.size());
  both.positions.insert(both.positions.end(), b.positions.begin(), b.positions.end());
  for (const Triangle& t : b.triangles) both.triangles.push_back({{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
  return both;
}

double mean_edge_length(const Mesh& mesh) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      sum += std::sqrt(squared_norm(mesh.positions[t.v[i]] - mesh.positions[t.v[(i + 1) % 3]]));
    }
  }
  return sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

Positions3 translated(const Positions3& x, Vec3d offset) {
  Positions3 result = x;
  for (Vec3d& p : result) p = p + offset;
  return result;
}

Positions3 rotated(const Positions3& x, Vec3d centre, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Positions3 result = x;
  for (Vec3d& p : result) {
    const Vec3d d = p - centre;
    p = centre + Vec3d{c * d.x - s * d.y, s * d.x + c * d.y, d.z};
  }
  return result;
}

Positions3 jittered(const Positions3& x, double amplitude, std::uint64_t seed) {
  Random random(seed);
  Positions3 result = x;
  for (Vec3d& p : result) {
    // Before the length, so that the compiler's order of operands does not matter.
    const Vec3d direction = random.direction();
    p = p + (amplitude * random.unit()) * direction;
  }
  return result;
}

Positions3 scattered(const Mesh& mesh, double amplitude, std::uint64_t seed) {
  Random random(seed);
  Positions3 result = mesh.positions;
  for (const Triangle& t : mesh.triangles) {
    const double speed = amplitude * random.unit() * (random.chance(0.125) ? 1.0 : 0.05);
    const Vec3d step = speed * random.direction();
    for (const std::uint32_t v : t.v) result[v] = mesh.positions[v] + step;
  }
  return result;
}

Positions3 contracted(const Positions3& x, double factor) {
  Positions3 result = x;
  for (Vec3d& p : result) p = factor * p;
  return result;
}

}  // namespace softcd::test
