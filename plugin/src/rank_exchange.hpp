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

/// Exchanges data between the ranks of one scene, see Communicator. All ranks must call the same functions in the same
/// order. An error on one rank becomes the same Error on all. Owned by SceneCore.
class RankExchange {
 public:
  using SetPositions = std::function<void(BodyId body, const Positions& x_t0, const Positions& x_t1)>;

  explicit RankExchange(std::shared_ptr<RankLink> link);

  /// Returns whether another rank sets the body's positions.
  bool is_given_elsewhere(const Body& body) const { return body.rank >= 0 && body.rank != link_->rank(); }
  /// Returns whether the body's positions are exchanged at the next detection.
  bool is_exchanged(const Body& body) const { return body.rank >= 0; }
  /// Takes positions of a body that this rank sets. exchange_positions() reads them.
  void set_positions(const Body& body, const Positions& x_t0, const Positions& x_t1);
  /// Forgets the positions of a body that was removed, or has another mesh.
  void forget(BodyId id);

  /// Prepares a detection. Throws unless all ranks are about to make the same detection in the same scene. Calls set()
  /// for all bodies whose positions were set on their rank; its arguments are valid until the next call. Even when it
  /// throws, it no longer needs the caller's memory.
  void meet(const std::vector<Body>& bodies, const QueryOptions& options, Pairs pairs, const SetPositions& set);

  /// Returns whether this rank takes part in a detection of so many triangles.
  bool has_part(std::uint64_t triangles) const;
  Partition partition(std::uint64_t triangles) const;
  /// Returns the number of triangles below which one rank detects the scene alone.
  std::uint64_t fewest_triangles() const;
  /// Ends a detection that is done, or has failed with `problem`. Throws the errors of all ranks.
  void conclude(const std::exception_ptr& problem, const TestSamples& tests);
  /// Returns this rank's share of all tests of the last detection.
  double share_of_tests() const { return share_of_tests_; }

  /// Returns all ranks' contacts, in order.
  std::vector<Contact> gather(Span<const Contact> mine);

 private:
  struct Given {
    Positions t0, t1;
  };
  using GivenByRank = std::map<std::uint32_t, Given>;  ///< by body id
  /// Flags that ranks exchange about a body's positions.
  enum Flag : std::uint8_t { is_new = 1, is_double = 2, has_two_ends = 4 };

  /// Calls f, which communicates with the other ranks.
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
  std::vector<std::byte> mine_, all_;  ///< host memory of the last exchange
  std::map<std::uint32_t, DeviceBlock> blocks_;
  std::vector<DeviceBlock> retired_;  ///< memory that bodies use until their new positions are set
  double share_of_tests_ = 1.0;
};

}  // namespace softcd
