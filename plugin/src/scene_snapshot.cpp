#include "scene_snapshot.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace softcd {
namespace {

/// Beyond this, sums of two coordinates might overflow float32.
constexpr double kLargestCoordinate = 1.0e37;
constexpr std::size_t kBlockSize = 8192;

/// A run of one body's vertices, the unit of parallel work.
struct Block {
  std::size_t body;
  std::size_t begin, end;
  std::size_t first_vertex;  ///< of the body, in the scene
};

std::vector<Block> split_into_blocks(const std::vector<Body>& bodies) {
  std::vector<Block> blocks;
  std::size_t first_vertex = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::size_t count = bodies[b].topology.vertex_count;
    for (std::size_t begin = 0; begin < count; begin += kBlockSize) {
      blocks.push_back({b, begin, std::min(begin + kBlockSize, count), first_vertex});
    }
    first_vertex += count;
  }
  return blocks;
}

template <class T>
Vec3d read(const Positions& positions, Vec3d offset, std::size_t i) {
  const T* x = reinterpret_cast<const T*>(static_cast<const std::byte*>(positions.data()) + i * positions.stride());
  return Vec3d{static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])} + offset;
}

bool is_usable(Vec3d p) {
  return std::abs(p.x) <= kLargestCoordinate && std::abs(p.y) <= kLargestCoordinate &&
         std::abs(p.z) <= kLargestCoordinate;
}

void extend(BodyExtent& extent, Vec3d p) {
  if (extent.is_empty) {
    extent.is_empty = false;
    extent.lo = extent.hi = p;
    return;
  }
  extent.lo = {std::min(extent.lo.x, p.x), std::min(extent.lo.y, p.y), std::min(extent.lo.z, p.z)};
  extent.hi = {std::max(extent.hi.x, p.x), std::max(extent.hi.y, p.y), std::max(extent.hi.z, p.z)};
}

template <class T>
BodySurvey survey_block(const Body& body, const Block& block, bool both_ends, bool measure_moves) {
  BodySurvey survey;
  for (std::size_t i = block.begin; i < block.end; ++i) {
    const Vec3d x_t1 = read<T>(body.x_t1, body.offset, i);
    const Vec3d x_t0 = both_ends || measure_moves ? read<T>(body.x_t0, body.offset, i) : x_t1;
    if (!is_usable(x_t1) || !is_usable(x_t0)) {
      survey.stray_vertices.push_back(static_cast<std::uint32_t>(i));
      continue;
    }
    extend(survey.extent, x_t1);
    if (both_ends) {
      extend(survey.extent, x_t0);
      survey.moves |= !(x_t0 == x_t1);
    }
    if (measure_moves) {
      survey.extent.furthest_move = std::max(survey.extent.furthest_move, std::sqrt(squared_norm(x_t1 - x_t0)));
    }
  }
  return survey;
}

constexpr Vec3f kStray = {NAN, NAN, NAN};

double rounding_of(double x) {
  // g++ 12 forgets to round where it vectorises the conversion to and fro.
  const volatile float rounded = static_cast<float>(x);
  return x - static_cast<double>(rounded);
}

/// Keeps a block's positions relative to `origin`; what is not usable stays recognisable. Returns the most that
/// rounding has moved one of them by, where kMayRound.
template <class T, bool kMayRound>
double keep_block(const Positions& positions, Vec3d offset, const Block& block, Vec3d origin,
                  std::vector<Vec3f>& kept) {
  double most = 0;
  for (std::size_t i = block.begin; i < block.end; ++i) {
    const Vec3d x = read<T>(positions, offset, i);
    kept[i] = is_usable(x) ? vec3_cast<float>(x - origin) : kStray;
    if (!kMayRound || !is_usable(x)) continue;
    const Vec3d exact = x - origin;
    most = std::max(most, squared_norm(Vec3d{rounding_of(exact.x), rounding_of(exact.y), rounding_of(exact.z)}));
  }
  return std::sqrt(most);
}

double keep_block(const Positions& positions, Vec3d offset, const Block& block, Vec3d origin,
                  std::vector<Vec3f>& kept) {
  if (positions.is_double()) return keep_block<double, true>(positions, offset, block, origin, kept);
  // What was kept before may be rounded once more.
  const bool is_exact = offset == Vec3d{0, 0, 0};
  return is_exact ? keep_block<float, false>(positions, offset, block, origin, kept)
                  : keep_block<float, true>(positions, offset, block, origin, kept);
}

void write_block(const std::vector<Vec3f>& kept, const Block& block, Vec3f* out) {
  for (std::size_t i = block.begin; i < block.end; ++i) {
    out[block.first_vertex + i] = kept[i].x == kept[i].x ? kept[i] : Vec3f{0, 0, 0};
  }
}

double origin_of(double lo, double hi) {
  const auto centre = static_cast<double>(static_cast<float>(0.5 * (lo + hi)));
  const bool is_far = centre > 0 ? lo >= 0.5 * centre && hi <= 2 * centre : hi <= 0.5 * centre && lo >= 2 * centre;
  return is_far ? centre : 0.0;
}

/// Appends pairs of features, each index moved on by how many the bodies before have.
void append(std::vector<std::uint64_t>& out, const std::vector<std::uint64_t>& pairs, std::uint64_t first,
            std::uint64_t second) {
  const std::uint64_t offset = (first << 32) | second;
  std::transform(pairs.begin(), pairs.end(), std::back_inserter(out),
                 [&](std::uint64_t pair) { return pair + offset; });
}

}  // namespace

bool list_neighbours(std::vector<Body>& bodies) {
  std::vector<Body*> unlisted;
  for (Body& body : bodies) {
    if (body.settings.self_collision && !body.neighbours) unlisted.push_back(&body);
  }
  tbb::parallel_for(std::size_t{0}, unlisted.size(), [&](std::size_t i) {
    unlisted[i]->neighbours = neighbour_features(unlisted[i]->topology, unlisted[i]->ownership);
  });
  return !unlisted.empty();
}

SceneArrays concatenate(const std::vector<Body>& bodies) {
  SceneArrays scene;
  std::uint32_t first_vertex = 0;
  for (std::uint32_t b = 0; b < bodies.size(); ++b) {
    const Topology& mesh = bodies[b].topology;
    const auto first_edge = static_cast<std::uint32_t>(scene.edges.size());
    if (bodies[b].neighbours) {
      append(scene.vertex_triangle_neighbours, bodies[b].neighbours->vertex_triangle, first_vertex,
             scene.triangles.size());
      append(scene.edge_edge_neighbours, bodies[b].neighbours->edge_edge, first_edge, first_edge);
    }
    for (const Triangle& t : mesh.triangles) {
      scene.triangles.push_back({{t.v[0] + first_vertex, t.v[1] + first_vertex, t.v[2] + first_vertex}});
    }
    for (Triangle edges : mesh.triangle_edges) {
      for (std::uint32_t& edge : edges.v) edge = edge == kNoIndex ? kNoIndex : edge + first_edge;
      scene.triangle_edges.push_back(edges);
    }
    for (const Edge& e : mesh.edges) scene.edges.push_back({{e.v[0] + first_vertex, e.v[1] + first_vertex}});
    scene.ownership.insert(scene.ownership.end(), bodies[b].ownership.begin(), bodies[b].ownership.end());
    scene.triangle_body.insert(scene.triangle_body.end(), mesh.triangles.size(), b);
    scene.vertex_body.insert(scene.vertex_body.end(), mesh.vertex_count, b);
    first_vertex += mesh.vertex_count;
  }
  return scene;
}

std::vector<BodySurvey> survey_bodies(const std::vector<Body>& bodies, bool both_ends, bool measure_moves) {
  const std::vector<Block> blocks = split_into_blocks(bodies);
  std::vector<BodySurvey> parts(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    const Body& body = bodies[blocks[i].body];
    if (!body.has_positions) return;
    parts[i] = body.x_t1.is_double() ? survey_block<double>(body, blocks[i], both_ends, measure_moves)
                                     : survey_block<float>(body, blocks[i], both_ends, measure_moves);
  });

  std::vector<BodySurvey> surveys(bodies.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    BodySurvey& survey = surveys[blocks[i].body];
    const BodySurvey& part = parts[i];
    survey.stray_vertices.insert(survey.stray_vertices.end(), part.stray_vertices.begin(), part.stray_vertices.end());
    survey.moves |= part.moves;
    if (part.extent.is_empty) continue;
    extend(survey.extent, part.extent.lo);
    extend(survey.extent, part.extent.hi);
    survey.extent.furthest_move = std::max(survey.extent.furthest_move, part.extent.furthest_move);
  }
  return surveys;
}

Vec3d scene_origin(const std::vector<BodySurvey>& surveys) {
  BodyExtent scene;
  for (const BodySurvey& survey : surveys) {
    if (survey.extent.is_empty) continue;
    extend(scene, survey.extent.lo);
    extend(scene, survey.extent.hi);
  }
  return {origin_of(scene.lo.x, scene.hi.x), origin_of(scene.lo.y, scene.hi.y), origin_of(scene.lo.z, scene.hi.z)};
}

void write_positions(std::vector<Body>& bodies, Vec3d origin, bool write_t0, PositionArrays out) {
  for (Body& body : bodies) {
    body.kept_t1.resize(body.topology.vertex_count, kStray);
    if (body.moves) body.kept_t0.resize(body.topology.vertex_count, kStray);
  }
  const std::vector<Block> blocks = split_into_blocks(bodies);
  std::vector<double> roundings(blocks.size(), 0);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    const Block& block = blocks[i];
    Body& body = bodies[block.body];
    if (body.has_positions) {
      roundings[i] = keep_block(body.x_t1, body.offset, block, origin, body.kept_t1);
      if (body.moves) {
        roundings[i] = std::max(roundings[i], keep_block(body.x_t0, body.offset, block, origin, body.kept_t0));
      }
    }
    write_block(body.kept_t1, block, out.x_t1);
    if (write_t0) write_block(body.moves ? body.kept_t0 : body.kept_t1, block, out.x_t0);
  });
  std::vector<double> largest(bodies.size(), 0);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    largest[blocks[i].body] = std::max(largest[blocks[i].body], roundings[i]);
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Body& body = bodies[b];
    body.rounding += largest[b];
    body.x_t1 = Span<const Vec3f>(body.kept_t1);
    body.x_t0 = body.moves ? Positions(Span<const Vec3f>(body.kept_t0)) : body.x_t1;
    body.offset = origin;
  }
}

}  // namespace softcd
