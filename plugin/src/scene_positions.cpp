#include "scene_positions.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "scene_layout.hpp"
#include "softcd/core/parallel.hpp"

namespace softcd {
namespace {

/// Vertices that a thread reads at once on the host, and a block of threads on the device.
constexpr std::size_t kHostBlock = 512;
constexpr std::size_t kDeviceBlock = 2048;

bool is_new_on_host(const Body& body) {
  return body.positions.are_new() && !body.positions.are_on_device();
}

bool is_new_on_device(const Body& body) {
  return body.positions.are_new() && body.positions.are_on_device();
}

bool is_read_on_host(const Body& body) {
  return body.positions.are_set() && !body.positions.are_on_device();
}

bool has_strays(const StepSurvey& survey) {
  return survey.t0.stray_count + survey.t1.stray_count > 0;
}

/// Appends one end of a body's positions at its place on the host or on the device.
void append_end(const Body& body, const Positions& end, std::vector<Range>& ranges,
                std::vector<DevicePositions>& on_device) {
  if (body.positions.are_on_device()) {
    on_device.push_back({given(end), body.vertices.first, body.vertices.count});
  } else {
    append(ranges, body.vertices.range());
  }
}

}  // namespace

void ScenePositions::share() {
  layout_.share_positions();
  full_t0_.share();
  full_t1_.share();
}

bool ScenePositions::are_on_device() const {
  const std::vector<Body>& bodies = layout_.bodies();
  return std::any_of(bodies.begin(), bodies.end(), [](const Body& body) { return body.positions.are_on_device(); });
}

bool ScenePositions::has_new_doubles_on_device() const {
  const std::vector<Body>& bodies = layout_.bodies();
  return std::any_of(bodies.begin(), bodies.end(),
                     [](const Body& body) { return is_new_on_device(body) && body.positions.given_t1().is_double(); });
}

bool ScenePositions::are_rounded_at(bool t0) const {
  const std::vector<Body>& bodies = layout_.bodies();
  return std::any_of(bodies.begin(), bodies.end(), [t0](const Body& body) {
    const StepSurvey& survey = body.positions.survey();
    return body.positions.are_set() && (t0 ? survey.t0 : survey.t1).is_rounded;
  });
}

Extent ScenePositions::extent_at(bool t0) const {
  Extent extent;
  for (const Body& body : layout_.bodies()) {
    if (!body.positions.are_set()) continue;
    const StepSurvey& survey = body.positions.survey();
    extent.extend((t0 ? survey.t0 : survey.t1).extent);
  }
  return extent;
}

void ScenePositions::read(const NeededPositions& needs, DevicePositionReader* reader, bool may_predict) {
  bodies_with_new_strays_.clear();
  if (may_predict && reader != nullptr && can_predict(needs)) {
    predict(*reader);
    return;
  }
  selection_number_ = 0;
  predicted_bodies_.clear();
  needs_ = needs;
  read_and_survey(reader);
}

/// Reads new positions, and all positions if they move the scene's origin. Reading on the host cannot fail, and is done
/// even if surveying on a device fails.
void ScenePositions::read_and_survey(DevicePositionReader* reader) {
  std::vector<Body>& bodies = layout_.bodies();
  const bool learns = std::any_of(bodies.begin(), bodies.end(), is_new_on_device);
  prepare_reading();
  read_on_host(origin_);
  std::exception_ptr problem =
      survey_on_device(reader, origin_, [&](const Body& body) { return body.positions.are_new() || lacks_t0(body); });
  Extent extent = extent_at(/*t0=*/false);
  if (needs_.t0) extent.extend(extent_at(/*t0=*/true));
  const Vec3d origin = origin_of(extent);
  if (!(origin == origin_)) {
    read_on_host(origin);
    const auto is_rounded = [](const Body& body) { return body.positions.given_t1().is_double(); };
    if (!problem) problem = survey_on_device(reader, origin, is_rounded);
  }
  for (Body& body : bodies) {
    if (body.positions.are_set()) finish_reading(body, origin);
    if (problem) body.positions.distrust_device();
  }
  origin_ = origin;
  if (problem) std::rethrow_exception(problem);
  if (reader == nullptr) return;
  for (Body& body : bodies) {
    // The host finds the indices of these vertices.
    if (body.positions.are_on_device() && has_strays(body.positions.survey())) take_to_host(body, *reader);
  }
  if (learns) prediction_.learn(bodies);
}

void ScenePositions::prepare_reading() {
  for (Body& body : layout_.bodies()) {
    if (is_new_on_host(body)) {
      body.positions.prepare_reading();
    } else if (!body.positions.are_on_device() && lacks_t0(body)) {
      body.positions.survey_t0(origin_, body.vertices.count, layout_.positions_of(body));
    }
  }
}

void ScenePositions::read_on_host(Vec3d origin) {
  try {
    const std::vector<Block> blocks = blocks_of(is_new_on_host, kHostBlock);
    std::vector<StepSurvey> surveys(blocks.size());
    parallel::for_each(blocks.size(), [&](std::size_t i) { surveys[i] = read_block(blocks[i], origin); });
    merge_surveys(blocks, surveys);
  } catch (...) {
    // Runs without parallelism, where memory or threads are lacking.
    for (Body& body : layout_.bodies()) {
      if (is_new_on_host(body)) body.positions.set_survey(read_block({&body, 0, body.vertices.count}, origin));
    }
  }
}

StepSurvey ScenePositions::read_block(const Block& block, Vec3d origin) {
  return block.body->positions.read(block.begin, block.end, origin, needs_.needs_t0(),
                                    layout_.positions_of(*block.body));
}

/// Surveys the bodies on the device for which is_concerned(body). Returns the reader's exception, if any.
template <class IsConcerned>
std::exception_ptr ScenePositions::survey_on_device(DevicePositionReader* reader, Vec3d origin,
                                                    const IsConcerned& is_concerned) {
  if (reader == nullptr) return nullptr;
  try {
    const std::vector<Block> blocks =
        blocks_of([&](const Body& body) { return body.positions.are_on_device() && is_concerned(body); }, kDeviceBlock);
    for (const Block& block : blocks) {
      if (block.begin == 0) wait_until_ready(*block.body, *reader);
    }
    if (!blocks.empty()) merge_surveys(blocks, reader->survey(surveyed(blocks), origin, needs_.needs_t0()));
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

/// Returns whether the body's positions at t0 are needed, and were not before.
bool ScenePositions::lacks_t0(const Body& body) const {
  return needs_.needs_t0() && body.positions.are_set() && !body.positions.is_t0_placed();
}

void ScenePositions::finish_reading(Body& body, Vec3d origin) {
  BodyPositions& positions = body.positions;
  const bool has_moved = !(origin == origin_);
  const bool are_new = positions.are_new();
  const bool gets_t0 = lacks_t0(body);
  if (are_new || has_moved || gets_t0) ++revision_;
  body.unsent.x_t0 |= are_new || has_moved || gets_t0;
  body.unsent.x_t1 |= are_new || has_moved;
  if (are_new || positions.are_on_device()) {
    positions.finish_reading(needs_.needs_t0());
  } else if (has_moved) {
    positions.move_origin(origin_, origin, body.vertices.count, layout_.positions_of(body));
  }
  if (!positions.are_on_device() && lacks_t0(body)) {
    positions.place_t0(origin, body.vertices.count, layout_.positions_of(body));
  }
}

template <class IsConcerned>
std::vector<ScenePositions::Block> ScenePositions::blocks_of(const IsConcerned& is_concerned, std::size_t size) const {
  std::vector<Block> blocks;
  for (Body& body : layout_.bodies()) {
    if (is_concerned(body)) append_blocks(body, size, blocks);
  }
  return blocks;
}

void ScenePositions::append_blocks(Body& body, std::size_t size, std::vector<Block>& blocks) {
  for (std::size_t begin = 0; begin < body.vertices.count; begin += size) {
    blocks.push_back({&body, begin, std::min<std::size_t>(begin + size, body.vertices.count)});
  }
}

void ScenePositions::merge_surveys(const std::vector<Block>& blocks, Span<const StepSurvey> surveys) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    StepSurvey survey = blocks[i].begin == 0 ? StepSurvey() : blocks[i].body->positions.survey();
    survey.merge(surveys[i]);
    blocks[i].body->positions.set_survey(survey);
  }
}

void ScenePositions::wait_until_ready(const Body& body, DevicePositionReader& reader) {
  for (const Positions* const end : {&body.positions.given_t0(), &body.positions.given_t1()}) {
    if (end->ready() != nullptr) reader.wait_for(end->ready());
  }
}

std::vector<SurveyedVertices> ScenePositions::surveyed(const std::vector<Block>& blocks) {
  std::vector<SurveyedVertices> vertices(blocks.size());
  std::transform(blocks.begin(), blocks.end(), vertices.begin(), [](const Block& block) {
    const BodyPositions& positions = block.body->positions;
    return SurveyedVertices{given(positions.given_t0()), given(positions.given_t1()), block.begin, block.end,
                            positions.have_two_ends()};
  });
  return vertices;
}

/// Returns whether a prediction can be used. Only positions on a device may have changed since they were surveyed. The
/// origin, relative to which doubles are rounded, is predicted, too.
bool ScenePositions::can_predict(const NeededPositions& needs) const {
  bool has_new = false;
  for (const Body& body : layout_.bodies()) {
    if (lacks_t0(body) || is_new_on_host(body)) return false;
    has_new |= body.positions.are_new();
  }
  return has_new && prediction_.is_known() && needs == needs_;
}

/// Works as read_and_survey(), but uses predictions for positions on the device.
void ScenePositions::predict(DevicePositionReader& reader) {
  std::vector<Body>& bodies = layout_.bodies();
  std::vector<Block> blocks;
  std::vector<StepSurvey> predicted;
  std::vector<std::size_t> predicted_bodies;
  Predicted scene;
  scene.origin = origin_;
  scene.uses_t0 = needs_.t0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Body& body = bodies[b];
    if (!body.positions.are_set()) continue;
    if (body.positions.are_new()) {
      predicted_bodies.push_back(b);
      append_blocks(body, kDeviceBlock, blocks);
      predicted.resize(blocks.size(), prediction_.of(b));
      scene.moves |= prediction_.of(b).moves;
      wait_until_ready(body, reader);
    } else {
      scene.others.extend(body.positions.survey().t1.extent);
      if (needs_.t0) scene.others.extend(body.positions.survey().t0.extent);
    }
  }
  verdict_ = reader.look(surveyed(blocks), predicted, scene, needs_.needs_t0());
  predicted_blocks_ = std::move(blocks);
  for (const std::size_t b : predicted_bodies) {
    bodies[b].positions.set_survey(prediction_.of(b));
    finish_reading(bodies[b], origin_);
  }
  if (predicted_number_ != prediction_.number() || predicted_bodies_ != predicted_bodies) ++last_selection_number_;
  selection_number_ = last_selection_number_;
  predicted_number_ = prediction_.number();
  predicted_bodies_ = std::move(predicted_bodies);
}

bool ScenePositions::judge_predicted(DevicePositionReader& reader) {
  bool is_so = false;
  try {
    const SeenPositions seen = reader.seen();
    merge_surveys(predicted_blocks_, seen.surveys);
    is_so = seen.are_as_predicted;
  } catch (...) {
    doubt_predicted();
    throw;
  }
  if (!is_so) {
    prediction_.fail();
    doubt_predicted();
    return false;
  }
  predicted_blocks_.clear();
  verdict_ = {};
  prediction_.confirm();
  prediction_.learn(layout_.bodies());
  return true;
}

void ScenePositions::doubt_predicted() noexcept {
  for (const Block& block : predicted_blocks_) block.body->positions.distrust_device();
  predicted_blocks_.clear();
  verdict_ = {};
}

void ScenePositions::take_to_host(DevicePositionReader& reader) {
  for (Body& body : layout_.bodies()) {
    if (body.positions.are_on_device()) take_to_host(body, reader);
  }
}

void ScenePositions::take_to_host(Body& body, DevicePositionReader& reader) {
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
  positions.set_survey(read_block({&body, 0, count}, origin_));
  positions.finish_reading(needs_.needs_t0());
  if (lacks_t0(body)) positions.place_t0(origin_, count, layout_.positions_of(body));
  body.unsent.x_t0 = body.unsent.x_t1 = true;
  full_revision_ = 0;
}

std::vector<std::uint32_t> ScenePositions::find_strays(Body& body, const NeededPositions& needs) {
  std::vector<std::uint32_t> strays;
  std::vector<std::uint32_t>& named = body.named_strays;
  const StepSurvey& survey = body.positions.survey();
  if (!has_strays(survey)) named.clear();
  const bool t0 = needs.needs_t0() && survey.t0.stray_count > 0;
  const bool t1 = needs.needs_t1() && survey.t1.stray_count > 0;
  if (!body.positions.are_set() || (!t0 && !t1)) return strays;
  const PositionArrays x = layout_.positions_of(body);
  for (std::uint32_t i = 0; i < body.vertices.count; ++i) {
    if ((t0 && !std::isfinite(x.x_t0[i].x)) || (t1 && !std::isfinite(x.x_t1[i].x))) strays.push_back(i);
  }
  if (std::includes(named.begin(), named.end(), strays.begin(), strays.end())) return strays;
  bodies_with_new_strays_.push_back(&body);
  std::vector<std::uint32_t> all;
  std::set_union(named.begin(), named.end(), strays.begin(), strays.end(), std::back_inserter(all));
  named = std::move(all);
  return strays;
}

std::uint64_t ScenePositions::fill_full() {
  const std::uint64_t revision = 1 + layout_.revision() + revision_;
  if (full_revision_ == revision) return revision;
  full_revision_ = 0;
  for (HostArray<Vec3d>* const full : {&full_t0_, &full_t1_}) {
    if (full == &full_t0_ && !needs_.needs_t0()) continue;
    full->reserve(layout_.vertex_count());
    full->resize(layout_.vertex_count());
  }
  try {
    const std::vector<Block> blocks = blocks_of(is_read_on_host, kHostBlock);
    parallel::for_each(blocks.size(), [&](std::size_t i) { copy_full(blocks[i]); });
  } catch (...) {
    // Runs without parallelism, where memory or threads are lacking.
    for (Body& body : layout_.bodies()) {
      if (is_read_on_host(body)) copy_full({&body, 0, body.vertices.count});
    }
  }
  full_revision_ = revision;
  return revision;
}

void ScenePositions::copy_full(const Block& block) {
  const std::size_t first = block.body->vertices.first;
  const bool with_t0 = needs_.needs_t0();
  block.body->positions.copy_full(block.begin, block.end, origin_, layout_.positions_of(*block.body), with_t0,
                                  full_t0_.data() + (with_t0 ? first : 0), full_t1_.data() + first);
}

void ScenePositions::append_full(SceneChanges& changes) const {
  for (const Body& body : layout_.bodies()) {
    const BodyPositions& positions = body.positions;
    if (needs_.needs_t0()) append_end(body, positions.given_t0(), changes.full_t0, changes.device_full_t0);
    append_end(body, positions.given_t1(), changes.full_t1, changes.device_full_t1);
  }
}

void ScenePositions::append_changes(SceneChanges& changes, bool all, bool with_t0) const {
  for (const Body& body : layout_.bodies()) {
    const BodyPositions& positions = body.positions;
    if (with_t0 && (all || body.unsent.x_t0)) {
      append_end(body, positions.given_t0(), changes.x_t0, changes.device_x_t0);
    }
    if (all || body.unsent.x_t1) append_end(body, positions.given_t1(), changes.x_t1, changes.device_x_t1);
  }
  changes.origin = origin_;
  changes.verdict = verdict_;
}

void ScenePositions::forget_changes(bool with_t0) {
  for (Body& body : layout_.bodies()) {
    body.unsent.x_t0 &= !with_t0;
    body.unsent.x_t1 = false;
  }
}

}  // namespace softcd
