#include "scene_snapshot.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

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
BodySurvey survey_block(const BodyPositions& positions, const Block& block, bool both_ends, bool measure_moves) {
  BodySurvey survey;
  for (std::size_t i = block.begin; i < block.end; ++i) {
    const Vec3d x_t1 = positions.t1<T>(i);
    const Vec3d x_t0 = both_ends || measure_moves ? positions.t0<T>(i) : x_t1;
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

/// In float32, relative to the scene's origin.
Vec3f placed(Vec3d x, Vec3d origin) {
  return is_usable(x) ? vec3_cast<float>(x - origin) : Vec3f{0, 0, 0};
}

double rounding_of(double x) {
  // g++ 12 forgets to round where it vectorises the conversion to and fro.
  const volatile float rounded = static_cast<float>(x);
  return x - static_cast<double>(rounded);
}

/// How far it moves a vertex, squared, that it becomes float32 relative to the scene's origin.
double squared_rounding(Vec3d x, Vec3d origin) {
  if (!is_usable(x)) return 0;
  const Vec3d exact = x - origin;
  return squared_norm(Vec3d{rounding_of(exact.x), rounding_of(exact.y), rounding_of(exact.z)});
}

/// Returns how far rounding has moved a vertex at most, squared: floats, see scene_origin, not at all.
template <class T>
double write_block(const BodyPositions& positions, const Block& block, Vec3d origin, bool write_t0,
                   PositionArrays out) {
  constexpr bool kMayRound = std::is_same_v<T, double>;
  Vec3f* const out_t0 = out.x_t0 + block.first_vertex;
  Vec3f* const out_t1 = out.x_t1 + block.first_vertex;
  double most = 0;
  for (std::size_t i = block.begin; i < block.end; ++i) {
    const Vec3d x_t1 = positions.t1<T>(i);
    out_t1[i] = placed(x_t1, origin);
    if (kMayRound) most = std::max(most, squared_rounding(x_t1, origin));
    if (!write_t0) continue;
    const Vec3d x_t0 = positions.t0<T>(i);
    out_t0[i] = placed(x_t0, origin);
    if (kMayRound) most = std::max(most, squared_rounding(x_t0, origin));
  }
  return most;
}

void write_nothing(const Block& block, bool write_t0, PositionArrays out) {
  const std::size_t first = block.first_vertex + block.begin;
  std::fill_n(out.x_t1 + first, block.end - block.begin, Vec3f{0, 0, 0});
  if (write_t0) std::fill_n(out.x_t0 + first, block.end - block.begin, Vec3f{0, 0, 0});
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

bool is_without_neighbours(const Body& body) {
  return body.settings.self_collision && !body.participation.neighbours;
}

/// Serially and without allocating anything, so that it cannot fail.
void read_positions(std::vector<Body>& bodies) {
  for (Body& body : bodies) {
    if (body.positions.are_set()) body.positions.read(0, body.topology.vertex_count);
    body.positions.finish_reading();
  }
}

/// One survey for each block.
std::vector<BodySurvey> survey_blocks(std::vector<Body>& bodies, const std::vector<Block>& blocks, bool both_ends,
                                      bool measure_moves) {
  std::vector<BodySurvey> parts(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    const Block& block = blocks[i];
    BodyPositions& positions = bodies[block.body].positions;
    if (!positions.are_set()) return;
    positions.read(block.begin, block.end);
    parts[i] = positions.are_double() ? survey_block<double>(positions, block, both_ends, measure_moves)
                                      : survey_block<float>(positions, block, both_ends, measure_moves);
  });
  return parts;
}

/// Of the surveys of its blocks each body's.
std::vector<BodySurvey> merged(const std::vector<BodySurvey>& parts, const std::vector<Block>& blocks,
                               std::size_t body_count) {
  std::vector<BodySurvey> surveys(body_count);
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

}  // namespace

bool lacks_neighbours(const std::vector<Body>& bodies) {
  return std::any_of(bodies.begin(), bodies.end(), is_without_neighbours);
}

void list_neighbours(std::vector<Body>& bodies) {
  std::vector<Body*> unlisted;
  for (Body& body : bodies) {
    if (is_without_neighbours(body)) unlisted.push_back(&body);
  }
  // When one body's list fails, oneTBB cuts short the loops of the others without a word.
  std::vector<NeighbourFeatures> listed(unlisted.size());
  tbb::parallel_for(std::size_t{0}, unlisted.size(), [&](std::size_t i) {
    listed[i] = neighbour_features(unlisted[i]->topology, unlisted[i]->participation.ownership);
  });
  for (std::size_t i = 0; i < unlisted.size(); ++i) unlisted[i]->participation.neighbours = std::move(listed[i]);
}

SceneArrays concatenate(const std::vector<Body>& bodies) {
  SceneArrays scene;
  std::uint32_t first_vertex = 0;
  for (std::uint32_t b = 0; b < bodies.size(); ++b) {
    const Topology& mesh = bodies[b].topology;
    const auto first_edge = static_cast<std::uint32_t>(scene.edges.size());
    if (bodies[b].participation.neighbours) {
      append(scene.vertex_triangle_neighbours, bodies[b].participation.neighbours->vertex_triangle, first_vertex,
             scene.triangles.size());
      append(scene.edge_edge_neighbours, bodies[b].participation.neighbours->edge_edge, first_edge, first_edge);
    }
    for (const Triangle& t : mesh.triangles) {
      scene.triangles.push_back({{t.v[0] + first_vertex, t.v[1] + first_vertex, t.v[2] + first_vertex}});
    }
    for (Triangle edges : mesh.triangle_edges) {
      for (std::uint32_t& edge : edges.v) edge = edge == kNoIndex ? kNoIndex : edge + first_edge;
      scene.triangle_edges.push_back(edges);
    }
    for (const Edge& e : mesh.edges) scene.edges.push_back({{e.v[0] + first_vertex, e.v[1] + first_vertex}});
    scene.ownership.insert(scene.ownership.end(), bodies[b].participation.ownership.begin(),
                           bodies[b].participation.ownership.end());
    scene.triangle_body.insert(scene.triangle_body.end(), mesh.triangles.size(), b);
    scene.vertex_body.insert(scene.vertex_body.end(), mesh.vertex_count, b);
    first_vertex += mesh.vertex_count;
  }
  return scene;
}

std::vector<BodySurvey> survey_bodies(std::vector<Body>& bodies, bool both_ends, bool measure_moves) {
  try {
    const std::vector<Block> blocks = split_into_blocks(bodies);
    const std::vector<BodySurvey> parts = survey_blocks(bodies, blocks, both_ends, measure_moves);
    for (Body& body : bodies) body.positions.finish_reading();
    return merged(parts, blocks, bodies.size());
  } catch (...) {
    read_positions(bodies);
    throw;
  }
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

void write_positions(const std::vector<Body>& bodies, Vec3d origin, bool write_t0, PositionArrays out,
                     std::vector<BodySurvey>& surveys) {
  const std::vector<Block> blocks = split_into_blocks(bodies);
  std::vector<double> squared_roundings(blocks.size(), 0);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    const BodyPositions& positions = bodies[blocks[i].body].positions;
    if (!positions.are_set()) {
      write_nothing(blocks[i], write_t0, out);
    } else if (positions.are_double()) {
      squared_roundings[i] = write_block<double>(positions, blocks[i], origin, write_t0, out);
    } else {
      squared_roundings[i] = write_block<float>(positions, blocks[i], origin, write_t0, out);
    }
  });
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    double& rounding = surveys[blocks[i].body].rounding;
    rounding = std::max(rounding, std::sqrt(squared_roundings[i]));
  }
}

}  // namespace softcd
