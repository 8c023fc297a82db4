#include "detector_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

#include "ground_truth.hpp"
#include "mesh_tools/mesh_io.hpp"

// The scenes are formulas, not simulations: they are the same for every user, at any size, without files and without
// Bullet.

namespace softcd::benchmarks {
namespace {

using std::numbers::pi;

struct Surface {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;
};

/// Returns a pseudo-random number in [-1, 1): splitmix64 of the index.
double noise(std::uint64_t index) {
  std::uint64_t bits = (index + 1) * 0x9E3779B97F4A7C15U;
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9U;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBU;
  bits ^= bits >> 31;
  return static_cast<double>(bits >> 11) * 0x1p-52 - 1.0;
}

Vec3d noise_vector(std::uint64_t index) {
  return {noise(3 * index), noise(3 * index + 1), noise(3 * index + 2)};
}

Vec3d normalized(Vec3d a) {
  return (1.0 / std::sqrt(squared_norm(a))) * a;
}

int scaled_count(int count, double scale, int least) {
  return std::max(least, static_cast<int>(std::lround(count * std::sqrt(scale))));
}

void append_quad(std::vector<Triangle>& triangles, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d,
                 bool diagonal) {
  if (diagonal) {
    triangles.insert(triangles.end(), {{{a, b, c}}, {{a, c, d}}});
  } else {
    triangles.insert(triangles.end(), {{{a, b, d}}, {{b, c, d}}});
  }
}

/// Returns a flat square of 2 cells^2 triangles in y = 0, centred on the origin.
Surface make_square(int cells, double side) {
  Surface square;
  const auto node = [cells](int column, int row) { return static_cast<std::uint32_t>(row * (cells + 1) + column); };
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column) {
      square.positions.push_back({side * (column / double(cells) - 0.5), 0.0, side * (row / double(cells) - 0.5)});
    }
  }
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      append_quad(square.triangles, node(column, row), node(column + 1, row), node(column + 1, row + 1),
                  node(column, row + 1), (column + row) % 2 == 0);
    }
  }
  return square;
}

/// Returns a unit sphere of 20 frequency^2 triangles: each face of the icosahedron is divided into frequency^2.
Surface make_icosphere(int frequency) {
  constexpr double kPhi = std::numbers::phi;
  constexpr Vec3d kCorners[12] = {{-1, kPhi, 0}, {1, kPhi, 0}, {-1, -kPhi, 0}, {1, -kPhi, 0},
                                  {0, -1, kPhi}, {0, 1, kPhi}, {0, -1, -kPhi}, {0, 1, -kPhi},
                                  {kPhi, 0, -1}, {kPhi, 0, 1}, {-kPhi, 0, -1}, {-kPhi, 0, 1}};
  constexpr int kFaces[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  Surface sphere;
  // A node's corners and their weights, sorted, so that all faces around it find the same node.
  std::map<std::array<std::pair<int, int>, 3>, std::uint32_t> nodes;
  const auto node = [&](const int(&face)[3], int i, int j) {
    const int weights[3] = {frequency - i - j, i, j};
    std::array<std::pair<int, int>, 3> key;
    Vec3d sum{};
    for (std::size_t c = 0; c < 3; ++c) {
      key[c] = weights[c] > 0 ? std::pair(face[c], weights[c]) : std::pair(-1, 0);
      sum = sum + static_cast<double>(weights[c]) * kCorners[face[c]];
    }
    std::sort(key.begin(), key.end());
    const auto [entry, is_new] = nodes.try_emplace(key, static_cast<std::uint32_t>(sphere.positions.size()));
    if (is_new) sphere.positions.push_back(normalized(sum));
    return entry->second;
  };
  for (const auto& face : kFaces) {
    for (int i = 0; i < frequency; ++i) {
      for (int j = 0; i + j < frequency; ++j) {
        sphere.triangles.push_back({{node(face, i, j), node(face, i + 1, j), node(face, i, j + 1)}});
        if (i + j + 2 > frequency) continue;
        sphere.triangles.push_back({{node(face, i + 1, j), node(face, i + 1, j + 1), node(face, i, j + 1)}});
      }
    }
  }
  return sphere;
}

/// A point of a curve, and the direction from the surface to the cloth. Turned about the y axis, the curve gives the
/// surface on which the cloth lies.
struct ProfilePoint {
  double radius, height;
  double normal_radius, normal_height;
};

/// Computes the points of a cloth that covers a surface of revolution. The cloth is wider than the surface; the excess
/// lies in Z-shaped folds of three layers.
struct Drape {
  double edge;
  int fold_count;
  double least_gap, more_gap;  ///< to the surface, in edges; it varies in between
  double thickness;            ///< of a fold, relative
  double turn;                 ///< radians

  Vec3d place(const ProfilePoint& profile, double distance, double angle) const {
    const double fold = 2 * pi / fold_count;
    const double slack = std::max(0.0, fold * (distance - profile.radius));
    const double place_in_fold = angle / fold - std::floor(angle / fold);
    const double height_in_fold = 0.5 - 0.5 * std::cos(2 * pi * place_in_fold);
    // 0.3 to 0.8 edges, three layers; 3 and 5: folds differ around and along the cloth.
    const double layers = edge * thickness * (0.55 + 0.25 * std::sin(3 * angle + distance / (5 * edge)));
    const double gap = edge * (least_gap + more_gap * (0.5 + 0.5 * std::sin(5 * angle + distance / (7 * edge))));
    const double height = gap + layers * height_in_fold * slack / (slack + edge);
    // Half of the slack goes forth and half back. The factor 0.6 preserves the cloth's length for the sine's speeds.
    const double sideways = profile.radius > 0 ? 0.6 * slack * height_in_fold / profile.radius : 0.0;
    const double radius = profile.radius + profile.normal_radius * height;
    const double phi = angle + sideways + turn;
    return {radius * std::cos(phi), profile.height + profile.normal_height * height, radius * std::sin(phi)};
  }
};

/// Returns the number of folds: one for about six edges of circumference, which are up to 18 edges of cloth where it is
/// three times too wide.
int fold_count_for(double circumference, double edge) {
  return std::max(3, static_cast<int>(std::lround(circumference / (6 * edge))));
}

template <class Profile>
std::vector<Vec3f> drape(const Surface& square, const Drape& drape, const Profile& profile, double shake,
                         std::uint64_t first_noise) {
  std::vector<Vec3f> positions;
  positions.reserve(square.positions.size());
  for (const Vec3d& p : square.positions) {
    const double distance = std::hypot(p.x, p.z);
    const Vec3d place = drape.place(profile(distance), distance, std::atan2(p.z, p.x) + pi);
    const Vec3d moved = shake * drape.edge * noise_vector(first_noise + positions.size());
    positions.push_back(vec3_cast<float>(place + moved));
  }
  return positions;
}

std::vector<Vec3f> moved(const std::vector<Vec3f>& positions, Vec3d offset) {
  std::vector<Vec3f> result;
  result.reserve(positions.size());
  for (const Vec3f& p : positions) result.push_back(vec3_cast<float>(vec3_cast<double>(p) + offset));
  return result;
}

BodySettings self_colliding() {
  BodySettings settings;
  settings.self_collision = true;
  return settings;
}

BodySettings clear_of_itself() {
  BodySettings settings;
  settings.self_collision = false;
  return settings;
}

BodySettings kinematic() {
  BodySettings settings;
  settings.kinematic = true;
  return settings;
}

// The funnel: a tube, open below, under a cone.
constexpr double kTubeRadius = 0.22;
constexpr double kTubeLength = 0.4;
constexpr double kConeLength = 0.75;  // along its side
constexpr double kConeSlope = 0.85;   // radians from the horizontal

/// Returns the point at `distance` from the tube's lower end, along the tube and then along the cone's side. The cloth
/// is inside.
ProfilePoint funnel_profile(double distance) {
  if (distance < kTubeLength) return {kTubeRadius, distance - kTubeLength, -1, 0};
  const double up = distance - kTubeLength;
  return {kTubeRadius + up * std::cos(kConeSlope), up * std::sin(kConeSlope), -std::sin(kConeSlope),
          std::cos(kConeSlope)};
}

/// Returns a point of the cloth, whose middle hangs out of the tube as half a ball.
ProfilePoint cloth_in_funnel_profile(double distance) {
  const double angle = distance / kTubeRadius;
  if (angle > pi / 2) return funnel_profile(distance - kTubeRadius * pi / 2);
  return {kTubeRadius * std::sin(angle), -kTubeLength - kTubeRadius * std::cos(angle), -std::sin(angle),
          std::cos(angle)};
}

Surface make_funnel_surface(int columns, int rows) {
  Surface funnel;
  for (int row = 0; row <= rows; ++row) {
    const ProfilePoint point = funnel_profile((kTubeLength + kConeLength) * row / rows);
    for (int column = 0; column < columns; ++column) {
      const double phi = 2 * pi * column / columns;
      funnel.positions.push_back({point.radius * std::cos(phi), point.height, point.radius * std::sin(phi)});
    }
  }
  const auto node = [columns](int column, int row) {
    return static_cast<std::uint32_t>(row * columns + column % columns);
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      append_quad(funnel.triangles, node(column, row), node(column + 1, row), node(column + 1, row + 1),
                  node(column, row + 1), false);
    }
  }
  return funnel;
}

/// A pyramid that approximates a cone: convex, its tip up.
struct Cone {
  static constexpr int kSides = 6;

  Vec3d foot;  ///< the middle of its base
  double radius, height;

  Surface surface() const {
    Surface cone;
    for (int side = 0; side < kSides; ++side) cone.positions.push_back(corner(side));
    cone.positions.push_back(tip());
    for (std::uint32_t side = 0; side < kSides; ++side) {
      cone.triangles.push_back({{side, kSides, (side + 1) % kSides}});
      if (side > 0 && side + 1 < kSides) cone.triangles.push_back({{0, side, side + 1}});
    }
    return cone;
  }

  /// Returns the side whose plane is furthest below `point`: its outward normal and the signed distance.
  std::pair<Vec3d, double> nearest_side(Vec3d point) const {
    std::pair<Vec3d, double> nearest{{}, -INFINITY};
    for (int side = 0; side < kSides; ++side) {
      const Vec3d normal = normalized(cross(tip() - corner(side), corner(side + 1) - corner(side)));
      const double distance = dot(normal, point - corner(side));
      if (distance > nearest.second) nearest = {normal, distance};
    }
    return nearest;
  }

 private:
  Vec3d corner(int side) const {
    const double phi = 2 * pi * side / kSides;
    return foot + Vec3d{radius * std::cos(phi), 0.0, radius * std::sin(phi)};
  }
  Vec3d tip() const { return foot + Vec3d{0.0, height, 0.0}; }
};

std::vector<Vec3f> to_floats(const std::vector<Vec3d>& positions) {
  std::vector<Vec3f> result;
  result.reserve(positions.size());
  for (const Vec3d& p : positions) result.push_back(vec3_cast<float>(p));
  return result;
}

/// Returns the mean length of edges, except those with a vertex that is not finite. The detector leaves out their
/// triangles, too.
double mean_edge_length(const Surface& surface) {
  double sum = 0;
  std::size_t count = 0;
  for (const Triangle& t : surface.triangles) {
    for (int i = 0; i < 3; ++i) {
      const double length = std::sqrt(squared_norm(surface.positions[t.v[(i + 1) % 3]] - surface.positions[t.v[i]]));
      if (!std::isfinite(length)) continue;
      sum += length;
      ++count;
    }
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

}  // namespace

std::size_t DetectorScene::triangle_count() const {
  std::size_t count = 0;
  for (const SceneBody& body : bodies) count += body.triangles.size();
  return count;
}

DetectorScene make_funnel(double scale) {
  constexpr double kSide = 2;
  const int cells = scaled_count(88, scale, 12);
  const double edge = kSide / cells;
  const Surface square = make_square(cells, kSide);
  const int fold_count = fold_count_for(2 * pi * kTubeRadius, edge);
  // Moved down by half an edge, so the cone is a third of an edge closer.
  const Drape before{edge, fold_count, 0.05, 0.5, 1.0, 0.0};
  Drape after = before;
  after.thickness = 0.9;
  const auto sunk = [edge](double distance) {
    ProfilePoint point = cloth_in_funnel_profile(distance);
    point.height -= edge * (0.5 + 0.05 * std::sin(distance / (4 * edge)));
    return point;
  };
  const Surface funnel = make_funnel_surface(scaled_count(36, scale, 8), scaled_count(35, scale, 8));
  const std::vector<Vec3f> at_rest = to_floats(funnel.positions);
  return {"funnel",
          edge,
          {{square.triangles, drape(square, before, cloth_in_funnel_profile, 0.02, 0),
            drape(square, after, sunk, 0.06, square.positions.size()), self_colliding()},
           {funnel.triangles, at_rest, at_rest, kinematic()}}};
}

DetectorScene make_cloth_on_ball(double scale) {
  constexpr double kSide = 4.4;  // for a ball of radius 1
  const int cells = scaled_count(189, scale, 12);
  const double edge = kSide / cells;
  const Surface square = make_square(cells, kSide);
  const auto profile = [](double distance) -> ProfilePoint {
    const double angle = std::min(distance, pi / 2);
    return {std::sin(angle), std::cos(angle) - std::max(0.0, distance - pi / 2), std::sin(angle), std::cos(angle)};
  };
  // The ball turns by half an edge and drags the cloth along, which sinks towards it.
  const Drape before{edge, fold_count_for(2 * pi, edge), 0.05, 0.25, 1.0, 0.0};
  Drape after = before;
  after.least_gap = -0.05;
  after.thickness = 0.9;
  after.turn = 0.35 * edge;
  const Surface ball = make_icosphere(scaled_count(32, scale, 2));
  std::vector<Vec3d> turned;
  const double turn = 0.5 * edge;
  for (const Vec3d& p : ball.positions) {
    turned.push_back({std::cos(turn) * p.x - std::sin(turn) * p.z, p.y, std::sin(turn) * p.x + std::cos(turn) * p.z});
  }
  return {"cloth-on-ball",
          edge,
          {{square.triangles, drape(square, before, profile, 0.02, 0),
            drape(square, after, profile, 0.06, square.positions.size()), self_colliding()},
           {ball.triangles, to_floats(ball.positions), to_floats(turned), kinematic()}}};
}

DetectorScene make_n_body(double scale) {
  const Surface ball = make_icosphere(4);
  const double edge = mean_edge_length(ball);  // of balls of radius 1
  DetectorScene scene{"n-body", edge, {}};

  // Cones of 20 and 44 edges: a side has 480 squared edges, a ball's triangle 0.43.
  const int cones_per_side = scaled_count(2, scale, 1);
  const double cone_spacing = 45 * edge;
  std::vector<Cone> cones;
  for (int i = 0; i < cones_per_side * cones_per_side; ++i) {
    const int row = i / cones_per_side;
    const Vec3d foot = {(i % cones_per_side + 0.5) * cone_spacing, 0.0, (row + 0.5) * cone_spacing};
    cones.push_back({foot, 20 * edge, 44 * edge});
    const Surface surface = cones.back().surface();
    const std::vector<Vec3f> at_rest = to_floats(surface.positions);
    scene.bodies.push_back({surface.triangles, at_rest, at_rest, kinematic()});
  }

  // Layers of balls around the cones. Each layer touches the one below it; balls inside of cones are left out.
  const int ball_count = std::max(8, static_cast<int>(std::lround(450 * scale)));
  const double spacing = 2.01;
  const int per_side = static_cast<int>(cones_per_side * cone_spacing / spacing);
  int placed = 0;
  for (int cell = 0; placed < ball_count; ++cell) {
    const auto index = static_cast<std::uint64_t>(cell);
    const int row = cell / per_side % per_side;
    const int layer = cell / per_side / per_side;
    Vec3d centre = {spacing * (cell % per_side + 0.5), spacing * (layer + 0.5), spacing * (row + 0.5)};
    centre = centre + 0.05 * noise_vector(2 * index);
    bool is_inside = false;
    for (const Cone& cone : cones) {
      const auto [normal, distance] = cone.nearest_side(centre);
      is_inside = is_inside || distance < 0.85;
      if (distance < 1.15) centre = centre + (1 - distance + 0.1 * edge * noise(index)) * normal;
    }
    if (is_inside) continue;
    const Vec3d motion = 0.5 * edge * noise_vector(2 * index + 1);
    std::vector<Vec3d> positions;
    for (const Vec3d& p : ball.positions) positions.push_back(centre + p);
    const std::vector<Vec3f> x_t0 = to_floats(positions);
    scene.bodies.push_back({ball.triangles, x_t0, moved(x_t0, motion), clear_of_itself()});
    ++placed;
  }
  return scene;
}

DetectorScene make_batches(double scale) {
  constexpr double kScaleOfOne = 0.0111;
  DetectorScene one = make_cloth_on_ball(kScaleOfOne);
  DetectorScene scene;
  scene.name = "batches";
  scene.edge_length = one.edge_length;
  const auto batches = std::max<std::uint32_t>(1, static_cast<std::uint32_t>(std::lround(1024 * scale)));
  for (std::uint32_t batch = 0; batch < batches; ++batch) {
    for (SceneBody& body : one.bodies) body.settings.batch = batch;
    scene.bodies.insert(scene.bodies.end(), one.bodies.begin(), one.bodies.end());
  }
  return scene;
}

DetectorScene make_many_bodies(double scale) {
  const std::vector<Triangle> triangles = {{{0, 1, 3}}, {{0, 3, 2}}, {{4, 7, 5}}, {{4, 6, 7}},
                                           {{0, 5, 1}}, {{0, 4, 5}}, {{2, 3, 7}}, {{2, 7, 6}},
                                           {{0, 2, 6}}, {{0, 6, 4}}, {{1, 5, 7}}, {{1, 7, 3}}};
  const auto count = std::max<std::uint64_t>(8, static_cast<std::uint64_t>(std::llround(1000 * scale)));
  const double half_room = 1.25 * std::cbrt(static_cast<double>(count));  // 16 boxes' volume for each
  DetectorScene scene{"many-bodies", 1.0, {}};
  for (std::uint64_t i = 0; i < count; ++i) {
    std::vector<Vec3d> corners;
    corners.reserve(8);
    for (int c = 0; c < 8; ++c) {
      corners.push_back(half_room * noise_vector(2 * i) + Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)});
    }
    const std::vector<Vec3f> x_t0 = to_floats(corners);
    scene.bodies.push_back({triangles, x_t0, moved(x_t0, 0.1 * noise_vector(2 * i + 1)), clear_of_itself()});
  }
  return scene;
}

DetectorScene read_scene(const std::filesystem::path& t0, const std::filesystem::path& t1) {
  const mesh_tools::Mesh first = mesh_tools::read_mesh(t0);
  const mesh_tools::Mesh second = mesh_tools::read_mesh(t1);
  mesh_tools::require_same_topology(first, t0, second, t1);
  return {t0.stem().string(),
          mean_edge_length({first.positions, first.triangles}),
          {{first.triangles, to_floats(first.positions), to_floats(second.positions), self_colliding()}},
          /*is_from_files=*/true};
}

DetectorScene read_recorded_step(const std::filesystem::path& step) {
  const auto [t0, t1] = test::frames_of(step);
  DetectorScene scene = read_scene(t0, t1);
  scene.name = std::filesystem::canonical(step).filename().string();
  return scene;
}

}  // namespace softcd::benchmarks
