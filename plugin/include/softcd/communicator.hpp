#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "softcd/core/span.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd {

class RankLink;

inline namespace SOFTCD_VERSION_NAMESPACE {

/// By which several ranks, processes or threads with a Scene each, detect in one scene together. Every rank adds the
/// same bodies in the same order, and makes the same calls in the same order; BodyDesc::rank says which of them sets a
/// body's positions. Each rank finds the contacts in its part of the space, so that all together have those, byte for
/// byte, that a single one would find, each once.
///
/// A copy is the same rank. One Scene at a time may use it. What goes wrong on one rank becomes the same Error on all;
/// a rank that does not take part within `patience` is one, too, after which the communicator cannot be used any more.
class SOFTCD_EXPORT Communicator {
 public:
  /// The `patience` of those who name none.
  static constexpr std::chrono::milliseconds kPatience{60'000};

  /// Gives `bytes` bytes at `mine` to all ranks: rank r's are at all + r * bytes afterwards, as with MPI_Allgather. All
  /// ranks call it together, with as many bytes.
  using AllGather = std::function<void(const void* mine, std::size_t bytes, void* all)>;

  /// No other ranks.
  Communicator() = default;
  /// Ranks that exchange the host's memory by a function of the caller's, which leaves in exceptions of its own where
  /// it fails. Throws InvalidInput unless 0 <= rank < size.
  Communicator(int rank, int size, AllGather all_gather);
  /// Of ranks that are threads of this process, one for each.
  static std::vector<Communicator> of_threads(int size, std::chrono::milliseconds patience = kPatience);
  /// Of processes with a CUDA device each. `comm` is an ncclComm_t, and `stream` a cudaStream_t of its device, which
  /// the caller keeps as long as this is used, and destroys. The scene is on that device. Throws BackendError where the
  /// library was built without NCCL, or libnccl.so.2 cannot be loaded.
  static Communicator of_nccl(void* comm, void* stream, std::chrono::milliseconds patience = kPatience);
  /// Of threads of this process with a CUDA device each, as cudaGetDeviceCount counts them, by NCCL. Throws as of_nccl.
  static std::vector<Communicator> of_devices(Span<const int> devices, std::chrono::milliseconds patience = kPatience);

  /// This rank's number, in [0, size()).
  int rank() const;
  /// How many ranks there are.
  int size() const;

  friend bool operator==(const Communicator& a, const Communicator& b) { return a.link_ == b.link_; }
  friend bool operator!=(const Communicator& a, const Communicator& b) { return !(a == b); }

  /// For softcd itself.
  const std::shared_ptr<RankLink>& link() const { return link_; }

 private:
  explicit Communicator(std::shared_ptr<RankLink> link);

  std::shared_ptr<RankLink> link_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
