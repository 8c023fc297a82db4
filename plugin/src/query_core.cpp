#include "query_core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "detection_settings.hpp"
#include "validation.hpp"

namespace softcd::detail {

QueryCore::QueryCore(std::shared_ptr<SceneCore> scene, const QueryOptions& options)
    : scene_(std::move(scene)), options_(options) {
  validate_options(options);
  scene_->finish_predicted();
  scene_->enter(*this);
}

QueryCore::~QueryCore() {
  close();
}

void QueryCore::close() noexcept {
  if (std::exchange(is_closed_, true)) return;
  end();
  scene_->leave(*this);
}

/// Ends the query's detection. Its contacts and its failure are no longer of interest.
void QueryCore::end() noexcept {
  if (scene_->is_running(*this)) scene_->finish_running();
  scene_->finish_predicted();
  detection_.reset();
}

void QueryCore::require_scene() const {
  if (scene_->is_closed()) throw Error("the Scene of this Query is gone; make a Query of a Scene that lives as long.");
}

std::uint64_t QueryCore::start(Pairs pairs) {
  require_scene();
  if (pairs > Pairs::changed) {
    throw InvalidInput(fmt::format("pairs is {}, which is none of its values; they count from 0 to 1.",
                                   static_cast<std::uint32_t>(pairs)));
  }
  scene_->finish_running();
  detection_.reset();
  has_contacts_ = false;
  detection_ = scene_->start(request(pairs));
  last_change_ = scene_->store().last_change();
  return ++last_number_;
}

DetectionRequest QueryCore::request(Pairs pairs) {
  return {*this, options_, pairs, last_change_, filter_, only_pairs_, pairs_, statistics_};
}

/// Finishes the detection. If it must be repeated, all pairs are compared.
void QueryCore::finish_detection() noexcept {
  detection_ = scene_->finish(request(Pairs::all), std::move(*detection_));
}

NeededPositions QueryCore::needed_positions() const {
  return {uses_t0(options_), uses_t1(options_), measures_moves(options_)};
}

Span<const Contact> QueryCore::wait(std::uint64_t number) {
  if (options_.contacts_on_device) {
    throw Error("a Ticket's contacts are on the device; use wait_on_device(), or a Query without contacts_on_device.");
  }
  return finished(number).contacts;
}

DeviceContacts QueryCore::wait_on_device(std::uint64_t number) {
  require_contacts_on_device();
  const PendingDetection found = finished(number);
  return {found.contacts.data(), found.contacts.size(), scene_->cuda_device(), found.staying.body_begin,
          found.staying.body_ids};
}

PendingContacts QueryCore::on_device(std::uint64_t number) {
  require_contacts_on_device();
  require_unread(number);
  if (scene_->is_running(*this) && detection_->staying.counts == nullptr) scene_->finish_running();
  if (detection_->problem) std::rethrow_exception(detection_->problem);
  const StayingContacts& found = detection_->staying;
  return {found.data,     found.capacity, found.counts,         found.body_begin,
          found.body_ids, found.ready,    scene_->cuda_device()};
}

void QueryCore::require_contacts_on_device() const {
  if (options_.contacts_on_device) return;
  throw Error("a Ticket's contacts are on the host; use wait(), or a Query with contacts_on_device.");
}

/// Throws Error where the detection is unknown, or its contacts are gone.
void QueryCore::require_unread(std::uint64_t number) const {
  if (is_closed_) throw Error("a Ticket was waited for, but its Query is gone; keep the Query until then.");
  if (number != last_number_) {
    throw Error(
        "a Ticket was waited for, but its Query has started another detection since; wait before the next start().");
  }
  if (!detection_ && scene_->is_closed()) throw Error("a Ticket was waited for, but its Scene is gone.");
  if (!detection_) {
    throw Error(
        "a Ticket was waited for twice, or options were set that have ended its detection; call start() again.");
  }
}

/// Finishes the detection and returns it. It can be called once.
PendingDetection QueryCore::finished(std::uint64_t number) {
  require_unread(number);
  if (scene_->is_running(*this)) scene_->finish_running();
  PendingDetection detection = *std::exchange(detection_, std::nullopt);
  scene_->conclude(detection);
  statistics_ = detection.statistics;
  decisions_ = detection.decisions;
  has_contacts_ = true;
  contacts_ = detection.contacts;
  return detection;
}

std::vector<Contact> QueryCore::gather_contacts() {
  if (!has_contacts_ || options_.contacts_on_device) {
    throw Error(
        "a Query has no contacts on the host to gather; wait for a detection first, and gather before the next "
        "one is started.");
  }
  return scene_->gather(contacts_);
}

void QueryCore::set_pair_filter(PairFilter filter) {
  scene_->finish_predicted();
  filter_ = std::move(filter);
}

void QueryCore::set_only_pairs(Span<const BodyPair> pairs) {
  scene_->finish_predicted();
  guarded([] { return kNoMemoryForPairs; }, [&] { only_pairs_ = BodyPairList(pairs); });
}

void QueryCore::set_options(const QueryOptions& options) {
  require_scene();
  validate_options(options);
  end();
  has_contacts_ = false;
  options_ = options;
}

std::shared_ptr<const void> QueryCore::hold_contacts() {
  const bool will_have_contacts = detection_ && detection_->staying.counts != nullptr;
  if (!has_contacts_ && !will_have_contacts) {
    throw Error("a Query has no contacts to hold; wait for a detection, and hold before the next one is started.");
  }
  if (memories_.empty()) return {};
  return memories_.back();
}

QueryMemories& QueryCore::free_memories() {
  const auto is_held = [](const std::shared_ptr<QueryMemories>& memories) { return memories.use_count() > 1; };
  const auto free = std::partition(memories_.begin(), memories_.end(), is_held);
  if (free == memories_.end()) {
    memories_.push_back(std::make_shared<QueryMemories>());
  } else {
    memories_.erase(free + 1, memories_.end());
  }
  return *memories_.back();
}

void QueryCore::drop_memories() noexcept {
  memories_.clear();
  has_contacts_ = false;
}

std::vector<StageReport> QueryCore::explain() const {
  return guarded([] { return kNoMemoryAtAll; },
                 [&] { return explain_stages(options_, decisions_, scene_->backend_reason(), statistics_); });
}

}  // namespace softcd::detail
