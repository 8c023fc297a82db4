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

/// Connects several ranks that detect contacts in one scene together. A rank is a process or a thread with a Scene of
/// its own.
/// - Every rank adds the same bodies, and makes the same calls, in the same order. BodyDesc::rank names the rank that
///   sets a body's positions.
/// - Each rank finds the contacts in its part of the space. Together they find the contacts that a single rank would
///   find, byte for byte, each once.
/// - An error on one rank becomes the same Error on all ranks. A rank that does not take part within `patience` is such
///   an error; afterwards the communicator can no longer be used.
///
/// A copy is the same rank. One Scene at a time may use it.
class SOFTCD_EXPORT Communicator {
 public:
  /// The default `patience`.
  static constexpr std::chrono::milliseconds kPatience{60'000};

  /// Gives `bytes` bytes at `mine` to all ranks. Rank r's bytes are at all + r * bytes afterwards, as with
  /// MPI_Allgather. All ranks call it together, with equal `bytes`.
  using AllGather = std::function<void(const void* mine, std::size_t bytes, void* all)>;

  /// Makes a single rank, without others.
  Communicator() = default;
  /// Makes a rank that exchanges host memory by the caller's function, which throws an exception of its own when it
  /// fails. Throws InvalidInput unless 0 <= rank < size.
  Communicator(int rank, int size, AllGather all_gather);
  /// Makes ranks for threads of this process, one for each thread. Throws InvalidInput unless size is at least 1.
  static std::vector<Communicator> of_threads(int size, std::chrono::milliseconds patience = kPatience);
  /// Makes a rank of several processes that have a CUDA device each. `comm` is an ncclComm_t, and `stream` is a
  /// cudaStream_t of its device. The caller keeps both while the rank is in use, and destroys them. The scene must be
  /// on that device. Throws BackendError where the library was built without NCCL, or libnccl.so.2 cannot be loaded.
  static Communicator of_nccl(void* comm, void* stream, std::chrono::milliseconds patience = kPatience);
  /// Makes ranks for threads of this process that have a CUDA device each, connected by NCCL. Devices are numbered as
  /// cudaGetDeviceCount counts them. Throws the exceptions of of_nccl().
  static std::vector<Communicator> of_devices(Span<const int> devices, std::chrono::milliseconds patience = kPatience);

  /// Returns this rank's number, in [0, size()).
  int rank() const;
  /// Returns the number of ranks.
  int size() const;

  friend bool operator==(const Communicator& a, const Communicator& b) { return a.link_ == b.link_; }
  friend bool operator!=(const Communicator& a, const Communicator& b) { return !(a == b); }

  /// Returns the link between the ranks. Internal to softcd.
  const std::shared_ptr<RankLink>& link() const { return link_; }

 private:
  explicit Communicator(std::shared_ptr<RankLink> link);

  std::shared_ptr<RankLink> link_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
