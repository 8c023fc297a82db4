#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <utility>

#include "scene_store.hpp"

// Positions: read once from the host's memory, surveyed where they are in a device's.
namespace softcd {
namespace {

constexpr std::size_t kBlockSize = 2048;

bool is_new_on_host(const Body& body) {
  return body.positions.are_new() && !body.positions.are_on_device();
}

}  // namespace

bool SceneStore::has_positions_on_device() const {
  return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.positions.are_on_device(); });
}

bool SceneStore::has_new_doubles_on_device() const {
  return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) {
    const BodyPositions& positions = body.positions;
    return positions.are_new() && positions.are_on_device() && positions.given_t1().is_double();
  });
}

PositionArrays SceneStore::positions_of(const Body& body) {
  return {x_t0_.data() + body.vertices.first, x_t1_.data() + body.vertices.first};
}

Extent SceneStore::extent_at(bool t0) const {
  Extent extent;
  for (const Body& body : bodies_) {
    if (!body.positions.are_set()) continue;
    const StepSurvey& survey = body.positions.survey();
    extent.extend((t0 ? survey.t0 : survey.t1).extent);
  }
  return extent;
}

/// Of all positions at t1, and at t0.
Extent SceneStore::extent(bool t0) const {
  Extent extent = extent_at(false);
  if (t0) extent.extend(extent_at(true));
  return extent;
}

/// Reads what was set, once, unless the scene's origin moves. What is on the host cannot fail, and is read even where
/// what is on a device does.
void SceneStore::read_positions(const LookedAt& looked_at, DevicePositionReader* reader) {
  selection_number_ = 0;
  foreseen_bodies_.clear();
  looked_at_ = looked_at;
  const bool needs_t0 = needs_t0_ = looked_at.needs_t0();
  const bool are_new = std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) {
    return body.positions.are_on_device() && body.positions.are_new();
  });
  for (Body& body : bodies_) {
    if (body.positions.are_on_device()) continue;
    if (body.positions.are_new()) {
      body.positions.prepare_reading();
    } else if (lacks_t0(body)) {
      body.positions.survey_t0(origin_, body.vertices.count, positions_of(body));
    }
  }
  read_new_positions(origin_, needs_t0);
  std::exception_ptr device_problem;
  const auto survey_on_device = [&](Vec3d origin, const auto& is_concerned) {
    if (reader == nullptr || device_problem) return;
    try {
      survey_device_bodies(*reader, origin, is_concerned);
    } catch (...) {
      device_problem = std::current_exception();
    }
  };
  survey_on_device(origin_, [&](const Body& body) { return body.positions.are_new() || lacks_t0(body); });
  const Vec3d origin = origin_of(extent(looked_at.t0));
  const bool has_moved = !(origin == origin_);
  if (has_moved) {
    read_new_positions(origin, needs_t0);
    survey_on_device(origin, [](const Body& body) { return body.positions.given_t1().is_double(); });
  }
  for (Body& body : bodies_) {
    if (body.positions.are_set()) finish_reading(body, origin);
  }
  origin_ = origin;
  if (device_problem) {
    for (Body& body : bodies_) body.positions.distrust_device();
    std::rethrow_exception(device_problem);
  }
  if (reader == nullptr) return;
  take_strays_to_host(*reader);
  if (are_new) foresight_.learn(bodies_);
}

/// Only what is new on a device has not been seen. The origin, which doubles are rounded from, is foreseen, too.
bool SceneStore::can_foresee(const LookedAt& looked_at) const {
  bool has_new = false;
  for (const Body& body : bodies_) {
    const BodyPositions& positions = body.positions;
    if (lacks_t0(body)) return false;
    if (!positions.are_new()) continue;
    if (!positions.are_on_device()) return false;
    has_new = true;
  }
  return has_new && foresight_.is_known() && looked_at == looked_at_;
}

/// As read_positions(), but takes positions on the device to be where they are foreseen.
void SceneStore::foresee(const LookedAt& looked_at, DevicePositionReader& reader) {
  std::vector<Block> blocks;
  std::vector<StepSurvey> foreseen;
  std::vector<std::size_t> bodies;
  Foreseen scene;
  scene.origin = origin_;
  scene.looks_at_t0 = looked_at.t0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    if (!body.positions.are_set()) continue;
    if (body.positions.are_new()) {
      bodies.push_back(b);
      append_blocks(body, blocks);
      foreseen.resize(blocks.size(), foresight_.of(b));
      scene.moves |= foresight_.of(b).moves;
      wait_until_ready(body, reader);
    } else {
      scene.others.extend(body.positions.survey().t1.extent);
      if (looked_at.t0) scene.others.extend(body.positions.survey().t0.extent);
    }
  }
  verdict_ = reader.look(surveyed(blocks), foreseen, scene, needs_t0_);
  foreseen_blocks_ = std::move(blocks);
  for (const std::size_t b : bodies) {
    bodies_[b].positions.set_survey(foresight_.of(b));
    finish_reading(bodies_[b], origin_);
  }
  const bool is_same = foreseen_number_ == foresight_.number() && foreseen_bodies_ == bodies;
  if (!is_same) ++last_selection_number_;
  selection_number_ = last_selection_number_;
  foreseen_number_ = foresight_.number();
  foreseen_bodies_ = std::move(bodies);
}

bool SceneStore::judge_foreseen(DevicePositionReader& reader) {
  bool is_so = false;
  try {
    const SeenPositions seen = reader.seen();
    merge_surveys(foreseen_blocks_, seen.surveys);
    is_so = seen.are_as_foreseen;
  } catch (...) {
    doubt_foreseen();
    throw;
  }
  if (!is_so) {
    foresight_.fail();
    doubt_foreseen();
    return false;
  }
  foreseen_blocks_.clear();
  verdict_ = {};
  foresight_.confirm();
  foresight_.learn(bodies_);
  return true;
}

void SceneStore::doubt_foreseen() noexcept {
  for (const Block& block : foreseen_blocks_) block.body->positions.distrust_device();
  foreseen_blocks_.clear();
  verdict_ = {};
}

/// Somebody looks at t0 who did not before.
bool SceneStore::lacks_t0(const Body& body) const {
  return needs_t0_ && body.positions.are_set() && !body.positions.is_t0_placed();
}

void SceneStore::finish_reading(Body& body, Vec3d origin) {
  const bool has_moved = !(origin == origin_);
  const bool are_new = body.positions.are_new();
  if (are_new || has_moved || lacks_t0(body)) ++position_revision_;
  if (body.positions.are_on_device()) {
    body.unsent.x_t0 |= are_new || has_moved || lacks_t0(body);
    body.positions.finish_reading(needs_t0_);
  } else {
    if (are_new) {
      body.positions.finish_reading(needs_t0_);
    } else if (has_moved) {
      body.positions.move_origin(origin_, origin, body.vertices.count, positions_of(body));
    }
    const bool gets_t0 = lacks_t0(body);
    if (gets_t0) body.positions.place_t0(origin, body.vertices.count, positions_of(body));
    body.unsent.x_t0 |= are_new || has_moved || gets_t0;
  }
  body.unsent.x_t1 |= are_new || has_moved;
}

void SceneStore::read_new_positions(Vec3d origin, bool needs_t0) {
  try {
    read_in_parallel(origin, needs_t0);
  } catch (...) {
    // Without memory, or threads.
    for (Body& body : bodies_) {
      if (!is_new_on_host(body)) continue;
      body.positions.set_survey(body.positions.read(0, body.vertices.count, origin, needs_t0, positions_of(body)));
    }
  }
}

void SceneStore::read_in_parallel(Vec3d origin, bool needs_t0) {
  std::vector<Block> blocks;
  for (Body& body : bodies_) {
    if (!is_new_on_host(body)) continue;
    append_blocks(body, blocks);
  }
  std::vector<StepSurvey> surveys(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    const Block& block = blocks[i];
    surveys[i] = block.body->positions.read(block.begin, block.end, origin, needs_t0, positions_of(*block.body));
  });
  merge_surveys(blocks, surveys);
}

std::uint64_t SceneStore::fill_full_positions() {
  if (full_revision_ == revision()) return full_revision_;
  full_revision_ = 0;
  for (HostArray<Vec3d>* const full : {&full_t0_, &full_t1_}) {
    if (full == &full_t0_ && !needs_t0_) continue;
    full->reserve(vertex_body_.size());
    full->resize(vertex_body_.size());
  }
  const auto is_here = [](const Body& body) { return body.positions.are_set() && !body.positions.are_on_device(); };
  try {
    std::vector<Block> blocks;
    for (Body& body : bodies_) {
      if (is_here(body)) append_blocks(body, blocks);
    }
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) { copy_full_positions(blocks[i]); });
  } catch (...) {
    // Without memory, or threads.
    for (Body& body : bodies_) {
      if (is_here(body)) copy_full_positions({&body, 0, body.vertices.count});
    }
  }
  full_revision_ = revision();
  return full_revision_;
}

void SceneStore::copy_full_positions(const Block& block) {
  const std::size_t first = block.body->vertices.first;
  block.body->positions.copy_full(block.begin, block.end, origin_, positions_of(*block.body), needs_t0_,
                                  full_t0_.data() + (needs_t0_ ? first : 0), full_t1_.data() + first);
}

void SceneStore::append_blocks(Body& body, std::vector<Block>& blocks) {
  for (std::size_t begin = 0; begin < body.vertices.count; begin += kBlockSize) {
    blocks.push_back({&body, begin, std::min<std::size_t>(begin + kBlockSize, body.vertices.count)});
  }
}

void SceneStore::merge_surveys(const std::vector<Block>& blocks, Span<const StepSurvey> surveys) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    StepSurvey survey = blocks[i].begin == 0 ? StepSurvey() : blocks[i].body->positions.survey();
    survey.merge(surveys[i]);
    blocks[i].body->positions.set_survey(survey);
  }
}

template <class IsConcerned>
void SceneStore::survey_device_bodies(DevicePositionReader& reader, Vec3d origin, const IsConcerned& is_concerned) {
  std::vector<Block> blocks;
  for (Body& body : bodies_) {
    if (!body.positions.are_on_device() || !is_concerned(body)) continue;
    append_blocks(body, blocks);
    wait_until_ready(body, reader);
  }
  if (!blocks.empty()) merge_surveys(blocks, reader.survey(surveyed(blocks), origin, needs_t0_));
}

void SceneStore::wait_until_ready(const Body& body, DevicePositionReader& reader) {
  for (const Positions* const end : {&body.positions.given_t0(), &body.positions.given_t1()}) {
    if (end->ready() != nullptr) reader.wait_for(end->ready());
  }
}

std::vector<SurveyedVertices> SceneStore::surveyed(const std::vector<Block>& blocks) {
  std::vector<SurveyedVertices> vertices(blocks.size());
  std::transform(blocks.begin(), blocks.end(), vertices.begin(), [](const Block& block) {
    const BodyPositions& positions = block.body->positions;
    return SurveyedVertices{given(positions.given_t0()), given(positions.given_t1()), block.begin, block.end,
                            positions.have_two_ends()};
  });
  return vertices;
}

void SceneStore::take_to_host(DevicePositionReader& reader) {
  for (Body& body : bodies_) {
    if (body.positions.are_on_device()) take_to_host(body, reader);
  }
}

void SceneStore::take_strays_to_host(DevicePositionReader& reader) {
  for (Body& body : bodies_) {
    const StepSurvey& survey = body.positions.survey();
    if (body.positions.are_on_device() && survey.t0.stray_count + survey.t1.stray_count > 0) take_to_host(body, reader);
  }
}

void SceneStore::take_to_host(Body& body, DevicePositionReader& reader) {
  BodyPositions& positions = body.positions;
  const std::size_t size = position_size(positions.given_t1());
  const std::size_t count = body.vertices.count;
  std::vector<std::byte> x_t0(positions.have_two_ends() ? count * size : 0);
  std::vector<std::byte> x_t1(count * size);
  if (!x_t0.empty()) reader.copy(given(positions.given_t0()), count, x_t0.data());
  reader.copy(given(positions.given_t1()), count, x_t1.data());
  const bool is_double = positions.given_t1().is_double();
  const auto on_host = [&](const std::vector<std::byte>& x) {
    return is_double ? Positions(reinterpret_cast<const double*>(x.data()), count, size)
                     : Positions(reinterpret_cast<const float*>(x.data()), count, size);
  };
  positions.set(on_host(x_t0.empty() ? x_t1 : x_t0), on_host(x_t1));
  positions.prepare_reading();
  positions.set_survey(positions.read(0, count, origin_, needs_t0_, positions_of(body)));
  positions.finish_reading(needs_t0_);
  if (lacks_t0(body)) positions.place_t0(origin_, count, positions_of(body));
  body.unsent.x_t0 = body.unsent.x_t1 = true;
  full_revision_ = 0;
}

}  // namespace softcd
