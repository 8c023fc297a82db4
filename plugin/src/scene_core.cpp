#include "scene_core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>

#include "detection_settings.hpp"
#include "startable_threads.hpp"
#include "validation.hpp"

namespace softcd::detail {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

std::string topology_problem(BodyId id, const BodyDesc& desc) {
  return fmt::format(
      "body {}: memory ran out for the edges of its {} triangles, or for the arrays of all bodies. Free memory, or "
      "give fewer triangles.",
      id.value, desc.triangles.size());
}

std::string positions_problem(BodyId id, const Positions& positions) {
  return fmt::format("body {}: memory ran out for a copy of its positions, {} bytes for each end. Free memory.",
                     id.value, positions.count() * position_size(positions));
}

std::string filters_problem(BodyId id) {
  return fmt::format("body {}: memory ran out for its vertex filters or rest positions. Free memory.", id.value);
}

}  // namespace

SceneCore::SceneCore(const SceneOptions& options, LogCallback log, DetectorFactories factories)
    : options_(options), log_(std::move(log)), arena_(options.max_threads) {
  validate_options(options);
  const std::string warning = keep_to_startable_threads();
  if (!warning.empty()) this->log(LogLevel::warning, warning);
  const std::shared_ptr<RankLink>& link = options.communicator.link();
  if (link != nullptr && link->size() > 1) ranks_ = std::make_unique<RankExchange>(link);
  use(detector_for(options, std::move(factories)));
}

BodyId SceneCore::add_body(const BodyDesc& desc) {
  finish_predicted();
  const BodyId id = store_->layout().next_id();
  validate_mesh(id, desc);
  validate_rank(id, desc);
  return guarded([&] { return topology_problem(id, desc); }, [&] { return store_->add_body(desc); });
}

void SceneCore::update_body(BodyId id, const BodyDesc& desc) {
  Body& body = find(id);
  validate_mesh(id, desc);
  validate_rank(id, desc);
  guarded([&] { return topology_problem(id, desc); }, [&] { store_->update_body(body, desc); });
  if (ranks_ != nullptr) ranks_->forget(id);
}

void SceneCore::update_body(BodyId id, const BodyDesc& desc, Span<const std::uint32_t> changed) {
  Body& body = find(id);
  if (body.has_segments() || !desc.segments.empty()) {
    update_body(id, desc);
    return;
  }
  guarded([&] { return topology_problem(id, desc); },
          [&] {
            validate_change(id, desc, changed, store_->layout().changing_mesh(body));
            validate_rank(id, desc);
            store_->update_body(body, desc, changed);
          });
  if (ranks_ != nullptr) ranks_->forget(id);
}

void SceneCore::set_settings(BodyId id, const BodySettings& settings) {
  Body& body = find(id);
  validate_settings(id, settings);
  store_->set_settings(body, settings);
}

void SceneCore::remove_body(BodyId id) {
  store_->remove_body(find(id));
  if (ranks_ != nullptr) ranks_->forget(id);
}

void SceneCore::set_positions(BodyId id, const Positions& x_t0, const Positions& x_t1, bool has_step_end) {
  Body& body = find(id);
  validate_positions(id, body.vertex_count(), x_t0, x_t1);
  if (ranks_ != nullptr && ranks_->is_given_elsewhere(body)) {
    throw InvalidInput(fmt::format("body {}: its positions are rank {}'s to set; this is rank {}.", id.value, body.rank,
                                   options_.communicator.rank()));
  }
  guarded([&] { return positions_problem(id, x_t1); },
          [&] {
            if (x_t1.is_on_device()) validate_on_device(body, x_t0, x_t1, detector_->position_reader());
            if (ranks_ != nullptr && ranks_->is_exchanged(body)) {
              ranks_->set_positions(body, x_t0, x_t1);
            } else {
              store_->set_positions(body, x_t0, x_t1);
            }
          });
  was_given_step_end_ |= has_step_end;
}

void SceneCore::set_ignored_pairs(Span<const BodyPair> pairs) {
  finish_predicted();
  for (const BodyPair& pair : pairs) {
    find(pair.a);
    find(pair.b);
  }
  guarded([] { return kNoMemoryForPairs; }, [&] { store_->set_ignored_pairs(BodyPairList(pairs)); });
}

void SceneCore::set_vertex_filters(BodyId id, Span<const VertexFilter> filters) {
  Body& body = find(id);
  validate_vertex_filters(id, body.vertex_count(), filters);
  guarded([&] { return filters_problem(id); }, [&] { store_->set_vertex_filters(body, filters); });
}

void SceneCore::set_rest_positions(BodyId id, const Positions& x) {
  Body& body = find(id);
  if (x.count() > 0) validate_rest_positions(id, body.vertex_count(), x);
  guarded([&] { return filters_problem(id); }, [&] { store_->set_rest_positions(body, x); });
}

void SceneCore::set_options(const SceneOptions& options) {
  validate_options(options);
  if (options.communicator != options_.communicator) {
    throw InvalidInput("a Scene keeps its communicator for as long as it lives; make another Scene.");
  }
  const SceneOptions before = options_;
  const bool is_elsewhere = options.backend != before.backend || options.cuda_device != before.cuda_device ||
                            options.cuda_stream != before.cuda_stream;
  std::unique_ptr<SelectedDetector> detector;
  if (is_elsewhere) {
    guarded([] { return kNoMemoryAtAll; }, [&] { detector = detector_for(options, machine_factories(options)); });
  }
  drop_detections();
  // Contacts and results count towards the limit. Otherwise one query's results could keep all others from their
  // memory.
  const bool is_less_memory =
      options.memory_limit > 0 && (before.memory_limit == 0 || options.memory_limit < before.memory_limit);
  if (is_elsewhere || is_less_memory) {
    for (SceneUser* const user : users_) user->drop_memories();
  }
  if (is_elsewhere) use(std::move(detector));
  if (options.max_threads != before.max_threads) arena_.limit(options.max_threads);
  options_ = options;
}

std::unique_ptr<SelectedDetector> SceneCore::detector_for(const SceneOptions& options, DetectorFactories factories) {
  return std::make_unique<SelectedDetector>(
      options.backend, [this](LogLevel level, std::string_view message) { log(level, message); }, std::move(factories));
}

void SceneCore::use(std::unique_ptr<SelectedDetector> detector) {
  detector_ = std::move(detector);
  if (detector_->may_use_device()) store_->positions().share();
}

void SceneCore::validate_rank(BodyId id, const BodyDesc& desc) const {
  const int size = options_.communicator.size();
  if (desc.rank >= -1 && desc.rank < size) return;
  throw InvalidInput(
      fmt::format("body {}: rank is {}; ranks count from 0 to {}, and -1 is all.", id.value, desc.rank, size - 1));
}

/// Returns a body that is about to be changed.
Body& SceneCore::find(BodyId id) {
  finish_predicted();
  if (Body* const body = store_->layout().find(id)) return *body;
  throw InvalidInput(fmt::format("body {} is not in the scene; it was removed, or never added.", id.value));
}

/// Calls guarded(), and fills the memory counters where memory runs out.
template <class MemoryProblem, class F>
void SceneCore::guarded_in_memory(Statistics& statistics, const MemoryProblem& memory_problem, const F& f) {
  guarded(
      [&] {
        detector_->report_memory(statistics);
        return memory_problem();
      },
      [&] { arena_.execute(f); });
}

PendingDetection SceneCore::start(const DetectionRequest& request) {
  if (request.options.contacts_on_device && options_.backend != Backend::cuda) {
    throw BackendError("contacts_on_device needs a Scene with Backend::cuda; with another one the CPU may detect.");
  }
  const Clock::time_point begin = Clock::now();
  if (ranks_ != nullptr) meet_ranks(request.options, request.pairs);
  PendingDetection detection;
  try {
    start_detector(request, detection);
  } catch (...) {
    store_->positions().doubt_predicted();
    if (ranks_ == nullptr) throw;
    // The other ranks have started their detection. All report the error when they wait.
    detection.has_work = false;
    detection.problem = std::current_exception();
  }
  if (detection.has_work) running_ = &request.user;
  detection.statistics.backend = detector_->backend();
  detection.statistics.ms.transfer = detection.statistics.ms.total = milliseconds_since(begin);
  return detection;
}

/// Makes sure, before a detection, that all ranks make the same one and have all positions.
void SceneCore::meet_ranks(const QueryOptions& options, Pairs pairs) {
  const auto set = [&](BodyId id, const Positions& x_t0, const Positions& x_t1) {
    store_->set_positions(find(id), x_t0, x_t1);
  };
  guarded([&] { return preparation_problem(); }, [&] { ranks_->meet(store_->bodies(), options, pairs, set); });
}

void SceneCore::start_detector(const DetectionRequest& request, PendingDetection& detection) {
  guarded_in_memory(
      request.statistics, [&] { return preparation_problem(); },
      [&] {
        prepare(request, detection, may_predict(request));
        // A detection without work is never finished, so the prediction behind that is judged here.
        if (detection.has_work || !store_->positions().has_predicted() || judge_predicted()) return;
        prepare(request, detection, /*may_predict=*/false);
      });
  if (!detection.has_work) return;
  guarded_in_memory(
      request.statistics, [&] { return detection_problem(); },
      [&] {
        detector_->start(*store_, request.user.free_memories(), detection.input);
        if (request.options.contacts_on_device) detection.staying = detector_->staying();
      });
}

/// Waits for the started detection. Repeats it where its predicted positions were wrong.
void SceneCore::finish_detector(const DetectionRequest& request, PendingDetection& detection, Statistics& found) {
  detection.contacts = detector_->finish(found);
  if (store_->positions().has_predicted() && !judge_predicted()) {
    prepare(request, detection, /*may_predict=*/false);
    detection.contacts = {};
    detection.staying = {};
    if (!detection.has_work) return;
    detector_->start(*store_, request.user.free_memories(), detection.input);
    detection.contacts = detector_->finish(found);
  }
  if (request.options.contacts_on_device) detection.staying = detector_->staying();
}

void SceneCore::conclude(PendingDetection& detection) {
  if (ranks_ != nullptr) {
    guarded([] { return kNoMemoryAtAll; }, [&] { ranks_->conclude(detection.problem, detection.tests); });
    detection.decisions.share_of_tests = ranks_->share_of_tests();
  } else if (detection.problem) {
    std::rethrow_exception(detection.problem);
  }
}

std::vector<Contact> SceneCore::gather(Span<const Contact> contacts) {
  return guarded([] { return "memory ran out for the contacts of all ranks. Free memory, or gather none."; },
                 [&] {
                   return ranks_ != nullptr ? ranks_->gather(contacts)
                                            : std::vector<Contact>(contacts.begin(), contacts.end());
                 });
}

/// Returns whether predicted positions may be used. The caller must not notice a repetition, and the result must not
/// depend on the prediction. Margins that compensate the rounding of doubles would depend on it.
bool SceneCore::may_predict(const DetectionRequest& request) const {
  const bool covers_rounding = store_->positions().has_new_doubles_on_device() &&
                               chosen_accuracy(request.options, store_->bodies()).accuracy == Accuracy::conservative;
  return options_.backend == Backend::cuda && ranks_ == nullptr && request.pairs == Pairs::all && !request.filter &&
         !covers_rounding;
}

/// Prepares everything for a detection, apart from the detector's start.
void SceneCore::prepare(const DetectionRequest& request, PendingDetection& detection, bool may_predict) {
  QueryOptions options = request.options;
  apply_changes(request.user.needed_positions(), may_predict, /*lists_neighbours=*/true);
  warn_of_strays();
  warn_of_missing_positions(options);
  const std::vector<Body>& bodies = store_->bodies();
  const SceneSize size = count_elements(detection.statistics);
  const ChosenAccuracy chosen = chosen_accuracy(options, bodies);
  options.accuracy = chosen.accuracy;
  const bool moves = something_moves(options, bodies);
  const std::uint64_t changed_since = request.pairs == Pairs::changed ? request.last_change : 0;
  if (options.neighbour_filters) require_rest_positions();
  const PairSelection& selected =
      request.selector.select(bodies, store_->positions().origin(), selecting(options, moves, changed_since),
                              pair_filter(request), store_->positions().selection_number());
  detection.decisions = {size.bodies,
                         selected.pair_count,
                         selected.self_count,
                         selected.vertex_triangle,
                         selected.edge_edge,
                         moves,
                         size.bodies_without_positions,
                         chosen.accuracy,
                         chosen.reason};
  const bool is_idle = ranks_ != nullptr && !ranks_->has_part(size.triangles);
  const Partition partition = ranks_ != nullptr ? ranks_->partition(size.triangles) : Partition{};
  detection.decisions.rank_count = options_.communicator.size();
  detection.decisions.rank = options_.communicator.rank();
  detection.decisions.fewest_triangles_of_ranks = ranks_ != nullptr ? ranks_->fewest_triangles() : 0;
  const DetectionSettings settings = detection_settings(options, selected, moves, partition);
  detection.input = {selected.view(), settings, settings.both_ends || settings.at_t0, size.triangles};
  detection.has_work = selected.pair_count + selected.self_count > 0 && !is_idle;
  detector_->set_memory_limit(options_.memory_limit);
}

/// Returns the filter; empty where it would admit all pairs.
PairFilter SceneCore::pair_filter(const DetectionRequest& request) const {
  const BodyPairList& only = request.only_pairs;
  const BodyPairList& ignored = store_->ignored_pairs();
  if (!request.filter && only.empty() && ignored.empty()) return {};
  return [&](BodyId a, BodyId b) {
    if (ignored.has(a, b) || (!only.empty() && !only.has(a, b))) return false;
    return !request.filter || call_back(request.filter, a, b);
  };
}

/// Warns of missing positions, once a scene: they would look like missing contacts.
void SceneCore::warn_of_missing_positions(const QueryOptions& options) {
  const auto waits = [](const Body& body) {
    return !body.is_removed && body.vertex_count() > 0 && !body.positions.are_set();
  };
  const std::vector<Body>& bodies = store_->bodies();
  const auto waiting = std::find_if(bodies.begin(), bodies.end(), waits);
  if (waiting != bodies.end()) {
    if (has_warned_of_no_positions_) return;
    has_warned_of_no_positions_ = true;
    log(LogLevel::warning,
        fmt::format("body {} has no positions and is left out; use set_positions() before a detection.",
                    waiting->id.value));
  } else if (options.detection == Detection::ccd && !was_given_step_end_ && !has_warned_of_no_end_ &&
             ranks_ == nullptr && store_->layout().size().triangles > 0) {
    has_warned_of_no_end_ = true;
    log(LogLevel::warning,
        "continuous detection finds nothing where nothing moves: give set_positions() x_t0 and x_t1, or use "
        "Detection::dcd.");
  }
}

void SceneCore::require_rest_positions() const {
  for (const Body& body : store_->bodies()) {
    if (body.is_removed || !body.excludes_at_rest() || !body.x_rest.empty() || body.vertex_count() == 0) continue;
    throw InvalidInput(
        fmt::format("body {}: its rest_distance is {}, but it has no rest positions; use set_rest_positions().",
                    body.id.value, body.settings.rest_distance));
  }
}

/// Calls f, which reads positions on the device. Throws BackendError where f throws DeviceError.
template <class F>
auto SceneCore::reading(const F& f) {
  try {
    return f();
  } catch (const DeviceError& error) {
    throw BackendError(fmt::format("{}. Positions in a device's memory could not be read.", error.what()));
  }
}

void SceneCore::apply_changes(const NeededPositions& by_next, bool may_predict, bool lists_neighbours) {
  reading([&] {
    DevicePositionReader* const reader = store_->positions().are_on_device() ? &detector_->position_reader() : nullptr;
    store_->apply_changes(needed_positions(), by_next, reader, may_predict, lists_neighbours);
  });
}

bool SceneCore::judge_predicted() {
  return reading([&] { return store_->positions().judge_predicted(detector_->position_reader()); });
}

void SceneCore::answer(const ProbeRequest& request, const Questions& ask) {
  finish_running();
  Statistics unused;
  guarded_in_memory(
      unused, [&] { return answer_problem(); },
      [&] {
        const ProbedScene scene = probed_scene(request);
        detector_->set_memory_limit(options_.memory_limit);
        detector_->answer(*store_, request.user.free_memories(), store_->layout().size().triangles, scene, ask);
      });
}

void SceneCore::answer_on_host(const std::function<void(const SceneStore&)>& f) {
  Statistics unused;
  guarded_in_memory(
      unused, [&] { return answer_problem(); },
      [&] {
        if (store_->positions().are_on_device()) {
          reading([&] { store_->positions().take_to_host(detector_->position_reader()); });
          const ScenePositions& positions = store_->positions();
          if (positions.are_rounded_at(true) || positions.are_rounded_at(false)) store_->positions().fill_full();
        }
        f(*store_);
      });
}

ProbedScene SceneCore::probed_scene(const ProbeRequest& request) {
  apply_changes(request.user.needed_positions(), /*may_predict=*/false, /*lists_neighbours=*/false);
  warn_of_strays();
  if (request.needs.sides) store_->layout().find_closed_surfaces();
  request.bodies.clear();
  for (const Body& body : store_->bodies()) {
    const bool has_positions = !body.is_removed && body.positions.are_set();
    const bool is_asked = has_positions && (!request.filter || call_back(request.filter, body.id));
    request.bodies.push_back({body.id.value, body.triangles.first, body.triangles.count, body.vertices.first,
                              body.vertices.count, has_positions, is_asked, body.is_closed.value_or(false)});
  }
  const Vec3d origin = store_->positions().origin();
  const Extent extent = store_->positions().extent_at(request.at_t0);
  const Box bounds = extent.is_empty()
                         ? box_of(Vec3f{0, 0, 0})
                         : Box{vec3_cast<float>(extent.lo - origin), vec3_cast<float>(extent.hi - origin)};
  const bool covers_rounding = request.needs.given_positions && store_->positions().are_rounded_at(request.at_t0);
  return {request.bodies, origin, bounds, request.at_t0, covers_rounding, store_->revision()};
}

/// Returns the positions that any of the scene's queries and probes needs.
NeededPositions SceneCore::needed_positions() const {
  NeededPositions result;
  for (const SceneUser* const user : users_) {
    const NeededPositions by_user = user->needed_positions();
    result.t0 |= by_user.t0;
    result.t1 |= by_user.t1;
    result.moves |= by_user.moves;
  }
  return result;
}

SceneSize SceneCore::count_elements(Statistics& statistics) const {
  const SceneSize size = store_->layout().size();
  statistics.bodies = size.bodies;
  statistics.triangles = size.triangles;
  statistics.vertices = size.vertices;
  statistics.edges = size.edges;
  statistics.left_out_triangles = size.left_out_triangles;
  return size;
}

void SceneCore::warn_of_strays() const {
  for (const Body* body : store_->positions().bodies_with_new_strays()) {
    log(LogLevel::warning,
        fmt::format("body {}: vertex {} is not finite or beyond 1e37 ({} such vertices); its {} triangles are left "
                    "out until it is",
                    body->id.value, body->stray_vertices.front(), body->stray_vertices.size(),
                    body->left_out_triangles));
  }
}

void SceneCore::finish_running() noexcept {
  if (SceneUser* const user = std::exchange(running_, nullptr)) user->finish_detection();
}

PendingDetection SceneCore::finish(const DetectionRequest& request, PendingDetection detection) noexcept {
  try {
    Statistics found = detection.statistics;
    guarded_in_memory(
        request.statistics, [&] { return detection_problem(); }, [&] { finish_detector(request, detection, found); });
    detection.tests = detector_->test_samples();
    found.ms.transfer += detection.statistics.ms.transfer;
    found.ms.total += detection.statistics.ms.total;
    detection.statistics = found;
  } catch (...) {
    store_->positions().doubt_predicted();
    detection.problem = std::current_exception();
  }
  return detection;
}

void SceneCore::finish_predicted() noexcept {
  if (store_->positions().has_predicted()) finish_running();
}

void SceneCore::drop_detections() noexcept {
  finish_running();
  for (SceneUser* const user : users_) user->drop_detection();
}

void SceneCore::close() noexcept {
  drop_detections();
  is_closed_ = true;
  detector_.reset();
  store_.emplace();
}

std::string SceneCore::preparation_problem() const {
  return fmt::format(
      "memory ran out for the meshes and positions of {} bodies {}. Free memory{}, or split the scene over several.",
      store_->layout().size().bodies, where(), or_raise());
}

std::string SceneCore::detection_problem() const {
  const MemoryNeed need = detector_->memory_need();
  const std::uint64_t triangles = store_->layout().size().triangles;
  const std::string bytes = need.bytes > 0 ? fmt::format(", {} bytes with what is held already", need.bytes) : "";
  switch (need.what) {
    case MemoryNeed::For::scene:
      return fmt::format(
          "memory ran out for a copy of {} triangles and their positions {}{}. Free memory, or split the scene over "
          "several{}.",
          triangles, where(), bytes, or_raise());
    case MemoryNeed::For::lists:
      return fmt::format(
          "memory ran out for lists of the cells and pairs of {} triangles {}{}. Too many triangles lie within their "
          "margins of each other, or there are too many: reduce the margins, or detect fewer bodies at a time{}.",
          triangles, where(), bytes, or_raise());
    case MemoryNeed::For::contacts:
      break;
  }
  return fmt::format(
      "memory ran out for the contacts of {} triangles {}: {} were found so far{}. Reduce the margins, or detect fewer "
      "bodies at a time{}.",
      triangles, where(), need.contacts, bytes, or_raise());
}

std::string SceneCore::answer_problem() const {
  return fmt::format(
      "memory ran out for a hierarchy of {} triangles, or for answers about them, {}. Free memory, or ask less at a "
      "time{}.",
      store_->layout().size().triangles, where(), or_raise());
}

/// Returns where the memory is, for messages.
std::string SceneCore::where() const {
  const char* const backend = detector_->backend() == Backend::cuda ? "on the GPU" : "on the CPU";
  if (options_.memory_limit == 0) return backend;
  return fmt::format("{} with a memory_limit of {} bytes", backend, options_.memory_limit);
}

void SceneCore::log(LogLevel level, std::string_view message) const {
  if (log_) call_back(log_, level, message);
}

}  // namespace softcd::detail
