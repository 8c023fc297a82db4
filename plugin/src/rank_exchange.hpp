#pragma once

#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "cell_shares.hpp"
#include "scene_store.hpp"
#include "softcd/pipeline/rank_link.hpp"
#include "softcd/query.hpp"

namespace softcd {

/// What the ranks of one scene tell each other, see Communicator. All ranks call the same functions of it in the same
/// order. What goes wrong on one of them becomes the same Error on all.
class RankExchange {
 public:
  using SetPositions = std::function<void(BodyId body, const Positions& x_t0, const Positions& x_t1)>;

  explicit RankExchange(std::shared_ptr<RankLink> link);

  /// Whether another rank sets the body's positions.
  bool is_given_elsewhere(const Body& body) const { return body.rank >= 0 && body.rank != link_->rank(); }
  /// Whether they are exchanged at the next detection.
  bool is_exchanged(const Body& body) const { return body.rank >= 0; }
  /// Positions of a body that this rank has, which are read by exchange_positions().
  void set_positions(const Body& body, const Positions& x_t0, const Positions& x_t1);
  /// A body that was removed, or has another mesh.
  void forget(BodyId id);

  /// Before a detection. Throws unless all ranks are about to make the same in the same scene; calls set() for all
  /// bodies whose positions were set on their rank, with what is valid until the next call. Whatever is thrown, the
  /// caller's memory is not needed afterwards.
  void meet(const std::vector<Body>& bodies, const QueryOptions& options, Pairs pairs, const SetPositions& set);

  /// Whether this rank has a part in a detection of so many triangles.
  bool has_part(std::uint64_t triangles) const;
  Partition partition(std::uint64_t triangles) const;
  /// Fewer triangles than this are one rank's.
  std::uint64_t fewest_triangles() const;
  /// Once the detection is done, or has failed with `problem`: throws what has gone wrong on any rank.
  void conclude(const std::exception_ptr& problem, const TestSamples& tests);
  /// This rank's part of all tests of the last detection.
  double share_of_tests() const { return share_of_tests_; }

  /// All ranks' contacts, in order.
  std::vector<Contact> gather(Span<const Contact> mine);

 private:
  struct Given {
    Positions t0, t1;
  };
  using GivenByRank = std::map<std::uint32_t, Given>;  ///< by ids
  /// What was set for a body, as the ranks tell each other.
  enum Flag : std::uint8_t { is_new = 1, is_double = 2, has_two_ends = 4 };

  /// Calls f, which talks to the others.
  template <class F>
  void talk(const F& f);
  template <class T>
  std::vector<T> gathered(const T& mine);
  void compare(const std::vector<Body>& bodies, const QueryOptions& options, Pairs pairs);
  std::vector<std::uint8_t> gathered_flags(const std::vector<Body>& bodies, const GivenByRank& given);
  void exchange_on_host(const std::vector<Body>& bodies, const std::vector<std::uint8_t>& flags,
                        const GivenByRank& given, const SetPositions& set);
  void exchange_on_device(const std::vector<Body>& bodies, const std::vector<std::uint8_t>& flags,
                          const GivenByRank& given, const SetPositions& set);
  static std::uint64_t bytes_of(const Body& body, std::uint8_t flags);
  void reserve_on_host(std::uint64_t bytes);
  void reserve_on_device(const std::vector<Body>& bodies, const std::vector<std::uint8_t>& flags);
  std::vector<TestSamples> agree(const std::exception_ptr& problem, const TestSamples& tests);

  struct DeviceBlock {
    std::shared_ptr<void> memory;
    std::uint64_t bytes = 0;
  };

  std::shared_ptr<RankLink> link_;
  CellShares shares_;
  GivenByRank given_;                  ///< since the last exchange
  std::vector<std::byte> mine_, all_;  ///< the host's memory that was exchanged last
  std::map<std::uint32_t, DeviceBlock> blocks_;
  std::vector<DeviceBlock> retired_;  ///< which bodies are in as long as they have not been set to their new ones
  double share_of_tests_ = 1.0;
};

}  // namespace softcd
