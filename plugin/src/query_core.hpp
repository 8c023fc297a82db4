#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "scene_core.hpp"

namespace softcd::detail {

/// The implementation of a Query. It has at most one detection: a running one, a finished one, or one that the caller
/// has waited for. Owned by the Query and its tickets.
class QueryCore final : public SceneUser {
 public:
  QueryCore(std::shared_ptr<SceneCore> scene, const QueryOptions& options);
  ~QueryCore();

  /// Starts a detection and returns its number.
  std::uint64_t start(Pairs pairs);
  Span<const Contact> wait(std::uint64_t number);
  DeviceContacts wait_on_device(std::uint64_t number);
  PendingContacts on_device(std::uint64_t number);
  /// Drops the detection, as the Query is gone.
  void close() noexcept;

  void set_options(const QueryOptions& options);
  const QueryOptions& options() const { return options_; }
  void set_pair_filter(PairFilter filter);
  void set_only_pairs(Span<const BodyPair> pairs);
  std::shared_ptr<const void> hold_contacts();
  std::vector<Contact> gather_contacts();
  const Statistics& statistics() const { return statistics_; }
  std::vector<StageReport> explain() const;

  NeededPositions needed_positions() const override;
  /// Keeps memories that the caller holds, and one free memory.
  QueryMemories& free_memories() override;
  void drop_memories() noexcept override;
  void finish_detection() noexcept override;
  void drop_detection() noexcept override { detection_.reset(); }

 private:
  DetectionRequest request(Pairs pairs);
  void end() noexcept;
  /// Throws Error when the scene is gone.
  void require_scene() const;
  void require_contacts_on_device() const;
  void require_unread(std::uint64_t number) const;
  PendingDetection finished(std::uint64_t number);

  std::shared_ptr<SceneCore> scene_;
  QueryOptions options_;
  PairFilter filter_;
  BodyPairList only_pairs_;  ///< empty: all pairs
  PairSelector pairs_;       ///< its selection belongs to the last detection
  /// The last one belongs to the last detection; the others are held by the caller.
  std::vector<std::shared_ptr<QueryMemories>> memories_;
  bool has_contacts_ = false;  ///< the caller has waited for contacts, and they are valid
  Span<const Contact> contacts_;
  std::uint64_t last_number_ = 0;
  std::uint64_t last_change_ = 0;  ///< number of the scene's last change when the last detection was started
  std::optional<PendingDetection> detection_;
  Statistics statistics_;  ///< of the last detection that the caller has waited for
  Decisions decisions_;
  bool is_closed_ = false;
};

}  // namespace softcd::detail
