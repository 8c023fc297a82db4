#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

using Corners = std::array<Vec3d, 3>;

void add_triangle(Mesh& mesh, const Corners& corners, Vec3d offset) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3d& corner : corners) mesh.positions.push_back(corner + offset);
  mesh.triangles.push_back({{first, first + 1, first + 2}});
}

/// Returns half the diagonal of the box, whose mean determines the cell size.
double radius_of(const Corners& c) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::min({c[0][axis], c[1][axis], c[2][axis]});
    const double high = std::max({c[0][axis], c[1][axis], c[2][axis]});
    sum += (high - low) * (high - low);
  }
  return 0.5 * std::sqrt(sum);
}

// Pairs of intersecting triangles that the published control bits lose, for cells of size 1 at the origin. The four
// reasons are:
// - Without the factor sqrt(2) on radii, the only shared cell is home to neither triangle.
// - Home types that repeat every second cell are mistaken for each other.
// - A test is left to a sibling's cell, which the other triangle never touches.
// - One representative for each cell and root need not overlap the other triangle's.
struct CounterExample {
  const char* name;
  Corners a;
  Corners b;
};

const CounterExample kCounterExamples[] = {
    {"unscaled_spheres",
     {{{1.89, 2.22, 1.5}, {1.34, 2.07, 1.5}, {1.74, 1.67, 1.5}}},
     {{{1.78, 2.11, 1.45}, {2.12, 2.45, 1.78}, {2.12, 2.45, 1.22}}}},
    {"parity_alias",
     {{{1.78, 1.5, 1.5}, {1.29, 1.78, 1.5}, {1.29, 1.22, 1.5}}},
     {{{1.69, 1.5, 1.45}, {2.18, 1.52, 1.78}, {2.18, 1.5, 1.22}}}},
    {"sibling_bits",
     {{{3.52, 2.64, 2.94}, {3.06, 2.76, 2.58}, {3.04, 2.44, 2.74}}},
     {{{3.36, 2.6, 2.88}, {4.14, 2.56, 2.98}, {4.4, 3.34, 3}}}},
    {"sibling_bits_scaled_spheres",
     {{{2.9, 2.56, 2.9}, {2.64, 2.86, 2.86}, {2.78, 2.66, 2.6}}},
     {{{2.88, 2.64, 2.88}, {2.98, 1.76, 2.94}, {2.98, 1.78, 3.2}}}},
    {"representatives",
     {{{3.22, 2.5, 3.86}, {3.24, 2.88, 4.22}, {3, 2.3, 4.12}}},
     {{{3.22, 2.5, 3.88}, {2.96, 2.56, 3}, {3.38, 2.38, 3.08}}}},
};

std::ostream& operator<<(std::ostream& out, const CounterExample& example) {
  return out << example.name;
}

/// Returns copies of the pair on a lattice whose period is a whole number of cells, half of them moved off it at
/// random. Lone triangles bring the mean radius to 1 / 1.8. The scene is symmetric about the origin, so cells start
/// there.
Scene scattered_copies(const CounterExample& example, float margin) {
  constexpr int kSide = 8;
  constexpr double kPeriod = 8.0;
  constexpr double kTargetRadius = 1.0 / 1.8;
  Random random(1);
  Mesh first;
  Mesh second;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const int row = i / kSide % kSide;
    const int layer = i / kSide / kSide;
    const Vec3d lattice = kPeriod * Vec3d{i % kSide - 0.5 * kSide, row - 0.5 * kSide, layer - 0.5 * kSide};
    const Vec3d offset = i % 2 == 0 ? lattice : lattice + random.in_box(1.0);
    add_triangle(first, example.a, offset);
    add_triangle(second, example.b, offset);
  }
  const double half = 0.5 * kSide * kPeriod + 8.0;
  for (const double sign : {-1.0, 1.0}) {
    add_triangle(first, {{{sign * half, sign * half, sign * half}, {sign * half, 0, 0}, {0, sign * half, 0}}}, {});
  }
  const double mean = 0.5 * (radius_of(example.a) + radius_of(example.b));
  const double filler_radius = mean < kTargetRadius ? 0.95 : 0.25;
  const double pairs = 2.0 * kSide * kSide * kSide;
  const auto filler_count = static_cast<int>(pairs * (kTargetRadius - mean) / (filler_radius - kTargetRadius));
  for (int i = 0; i < filler_count; ++i) {
    const double side = filler_radius / std::sqrt(0.75);
    add_triangle(second, {{{0, 0, 0}, {side, side, 0}, {0, side, side}}}, random.in_box(0.5 * kSide * kPeriod));
  }
  BodySettings settings = everything(0.5F * margin);
  settings.self_collision = false;
  return {still(first, settings), still(second, settings)};
}

class ControlBits : public testing::TestWithParam<CounterExample> {};

TEST_P(ControlBits, counter_example_is_found) {
  const Scene pair{still(Mesh{{{{0, 1, 2}}}, {GetParam().a.begin(), GetParam().a.end()}}, everything()),
                   still(Mesh{{{{0, 1, 2}}}, {GetParam().b.begin(), GetParam().b.end()}}, everything())};
  double closest = INFINITY;
  const SceneGeometry geometry(pair);
  for (std::uint32_t i = 0; i < 3; ++i) {
    closest = std::min({closest, geometry.distance({ContactKind::vertex_triangle, 0, i, 1, 0}, 1.0),
                        geometry.distance({ContactKind::vertex_triangle, 1, i, 0, 0}, 1.0)});
  }
  const auto margin = static_cast<float>(closest + 1e-3);
  const Scene scene = scattered_copies(GetParam(), margin);
  PipelineOptions options = test_options(Detection::dcd);
  options.cell_size_factor = 1.8F;
  LoadedScene loaded = load(scene, options);
  loaded.pipeline.detect();
  const double unit = loaded.pipeline.query.statistics().cell_size / 1.8;
  DiscreteRules rules;
  rules.absolute_band = 1e-5;
  for (const double factor : {1.0, 0.9, 0.97, 1.03, 1.1}) {
    options.cell_size_factor = static_cast<float>(factor / unit);
    loaded.pipeline.set_options(options);
    loaded.pipeline.detect();
    EXPECT_NEAR(loaded.pipeline.query.statistics().cell_size, factor, 1e-5);
    EXPECT_GE(expect_discrete_contacts(scene, options, rules), 512U) << "every copy touches";
  }
}

INSTANTIATE_TEST_SUITE_P(Published, ControlBits, testing::ValuesIn(kCounterExamples),
                         [](const auto& test) { return std::string(test.param.name); });

// Corners and cells' walls are at multiples of 1/2, where slack moves a volume into the next cell.
TEST(CellWalls, corners_on_them) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SoupOptions soup;
    soup.triangle_count = 150;
    soup.half_extent = 3.0;
    soup.largest = 4.0;
    soup.size_ratio = 10.0;
    soup.joined_share = 0.3;
    soup.grid_bits = 1;
    soup.seed = seed;
    const Mesh mesh = triangle_soup(soup);
    Positions3 end = jittered(mesh.positions, 1.0, seed);
    snap_to_grid(end, 1);
    const Scene scene{moving(mesh, end, everything())};
    LoadedScene loaded = load(scene, test_options(Detection::ccd));
    loaded.pipeline.detect();
    const double mean_radius = loaded.pipeline.query.statistics().mean_radius;
    for (const double cell_size : {0.25, 0.5, 1.0}) {
      PipelineOptions options = test_options(Detection::ccd);
      options.cell_size_factor = static_cast<float>(cell_size / mean_radius);
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", cell size " << cell_size);
      expect_continuous_contacts(scene, options);
    }
  }
}

/// Many pairs of triangles. The two of a pair are in bodies 0 and 1 under the same index. They penetrate each other
/// near one known pair of features at t1, and were apart at t0.
class PairBatch {
 public:
  static constexpr double kDepth = 1e-3;
  static constexpr float kMargin = 4e-3F;

  PairBatch(std::uint32_t pair_count, std::uint64_t seed) : random_(seed) {
    const BodySettings settings = [] {
      BodySettings s = everything(0.5F * kMargin);
      s.self_collision = false;
      return s;
    }();
    scene_.resize(2);
    scene_[0].settings = scene_[1].settings = settings;
    const auto side = static_cast<std::uint32_t>(std::ceil(std::cbrt(pair_count)));
    for (std::uint32_t i = 0; i < pair_count; ++i) add_pair(lattice_point(i, side));
  }

  const Scene& scene() const { return scene_; }
  const std::vector<FeaturePair>& expected() const { return expected_; }

 private:
  /// Returns a place for a triangle. Small triangles are separated from large ones, or every large pair would meet
  /// hundreds of small ones.
  Vec3d lattice_point(std::uint32_t i, std::uint32_t side) {
    const double kind = random_.unit();
    small_a_ = kind < 0.93;
    small_b_ = kind < 0.86 || kind >= 0.97;
    const bool both_small = small_a_ && small_b_;
    const double period = both_small ? 4.0 : 48.0;
    const Vec3d corner{both_small ? 0.0 : -48.0 * side, 0.0, 0.0};
    const std::uint32_t row = i / side % side;
    const std::uint32_t layer = i / side / side;
    return corner + period * Vec3d{double(i % side), double(row), double(layer)} + random_.in_box(1.0);
  }

  double radius(bool is_small) { return is_small ? random_.uniform(0.3, 1.0) : random_.uniform(3.0, 20.0); }

  /// Returns a triangle that is no sliver: the known features must cross well inside.
  Corners random_triangle(double size) {
    while (true) {
      const Corners c{size * random_.direction(), size * random_.direction(), size * random_.direction()};
      if (squared_norm(cross(c[1] - c[0], c[2] - c[0])) > 0.25 * size * size * size * size) return c;
    }
  }

  static Vec3d unit(Vec3d a) { return (1.0 / std::sqrt(squared_norm(a))) * a; }

  void add_pair(Vec3d centre) {
    const double size_a = radius(small_a_);
    const double size_b = radius(small_b_);
    const Corners a = random_triangle(size_a);
    Corners b = random_triangle(size_b);
    if (random_.chance(0.5)) {
      add_vertex_in_triangle(a, b, centre);
    } else {
      add_crossing_edges(a, b, centre);
    }
  }

  /// Adds a pair: vertex 0 of b ends kDepth below an inner point of a, the rest of b above it.
  void add_vertex_in_triangle(const Corners& a, Corners b, Vec3d centre) {
    const Vec3d normal = unit(cross(a[1] - a[0], a[2] - a[0]));
    const double u = random_.uniform(0.2, 0.4);
    const double v = random_.uniform(0.2, 0.4);
    const Vec3d target = a[0] + u * (a[1] - a[0]) + v * (a[2] - a[0]);
    for (std::size_t i = 1; i < 3; ++i) {
      const Vec3d arm = b[i] - b[0];
      b[i] = b[0] + (dot(arm, normal) < 0.0 ? arm - (2.0 * dot(arm, normal)) * normal : arm);
    }
    const Vec3d shift = target - kDepth * normal - b[0];
    for (Vec3d& corner : b) corner = corner + shift;
    const std::uint32_t index = append(a, b, normal, centre);
    expected_.push_back({ContactKind::vertex_triangle, 1, 3 * index, 0, index});
  }

  /// Adds a pair: the edges 0-1 of both cross at inner points, b's kDepth below a's.
  void add_crossing_edges(const Corners& a, Corners b, Vec3d centre) {
    Vec3d normal = cross(a[1] - a[0], b[1] - b[0]);
    while (squared_norm(normal) < 0.05 * squared_norm(a[1] - a[0]) * squared_norm(b[1] - b[0])) {
      b = random_triangle(radius(small_b_));
      normal = cross(a[1] - a[0], b[1] - b[0]);
    }
    normal = unit(normal);
    const Vec3d on_a = lerp(a[0], a[1], random_.uniform(0.2, 0.8));
    const Vec3d on_b = lerp(b[0], b[1], random_.uniform(0.2, 0.8));
    const Vec3d shift = on_a - kDepth * normal - on_b;
    for (Vec3d& corner : b) corner = corner + shift;
    const std::uint32_t index = append(a, b, normal, centre);
    expected_.push_back({ContactKind::edge_edge, 0, 3 * index, 1, 3 * index});
  }

  /// Appends a pair. b comes from the side that `normal` points to. The vertices of triangle i are 3 i to 3 i + 2. The
  /// edge between its first two vertices is the body's edge 3 i.
  std::uint32_t append(const Corners& a, const Corners& b, Vec3d normal, Vec3d centre) {
    const auto index = static_cast<std::uint32_t>(scene_[0].triangles.size());
    const double distance = random_.uniform(0.1, 2.0);
    const Vec3d approach = distance * (normal + random_.unit() * unit(cross(normal, random_.direction())));
    for (std::size_t i = 0; i < 3; ++i) {
      scene_[0].x_t0.push_back(centre + a[i]);
      scene_[0].x_t1.push_back(centre + a[i]);
      scene_[1].x_t0.push_back(centre + b[i] + approach);
      scene_[1].x_t1.push_back(centre + b[i]);
    }
    for (SceneBody& body : scene_) body.triangles.push_back({{3 * index, 3 * index + 1, 3 * index + 2}});
    return index;
  }

  Random random_;
  Scene scene_;
  std::vector<FeaturePair> expected_;
  bool small_a_ = true;
  bool small_b_ = true;
};

std::vector<FeaturePair> sorted(std::vector<FeaturePair> pairs) {
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

constexpr std::uint32_t kPairsPerBatch = 50000;

class MillionPairs : public testing::TestWithParam<int> {};

TEST_P(MillionPairs, none_is_missed) {
  constexpr float kCellSizeFactors[] = {0.0F, 1.2F, 2.4F, 1.8F, 0.8F};
  const auto number = static_cast<std::uint64_t>(GetParam());
  const PairBatch batch(kPairsPerBatch, 77 + number);
  PipelineOptions options = test_options(number % 2 == 0 ? Detection::dcd : Detection::ccd);
  options.cell_size_factor = kCellSizeFactors[number % 5];
  LoadedScene loaded = load(batch.scene(), options);
  const Span<const Contact> contacts = loaded.pipeline.detect();
  const Difference difference = compare({sorted(batch.expected()), {}}, features_of(contacts));
  EXPECT_TRUE(difference.missed.empty()) << describe(difference);
  EXPECT_TRUE(difference.repeated.empty()) << describe(difference);
  EXPECT_GT(loaded.pipeline.query.statistics().split_triangles, kPairsPerBatch / 50) << "the batch must split some";
}

INSTANTIATE_TEST_SUITE_P(Batches, MillionPairs, testing::Range(0, 20));

}  // namespace
}  // namespace softcd::test
