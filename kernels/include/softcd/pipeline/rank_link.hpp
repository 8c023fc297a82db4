#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "softcd/core/span.hpp"

namespace softcd {

/// Ranks could not communicate, and will not be able to any more.
class LinkError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Memory on all ranks' devices that one rank broadcasts. `given` is where the root has it, as `count` elements of
/// `element` bytes each, `stride` bytes apart, on its device or the host. `data` is memory of allocate().
struct DeviceBroadcast {
  int root;
  void* data;
  const void* given;
  bool is_given_on_device;
  std::uint64_t count, element, stride;
};

/// The connection of one rank with the others. All ranks call the same functions in the same order. Throws LinkError.
class RankLink {
 public:
  virtual ~RankLink() = default;

  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// Gathers as Communicator::AllGather does, in the host's memory.
  virtual void all_gather(const void* mine, std::uint64_t bytes, void* all) = 0;

  /// The rank's CUDA device, if it has one and devices exchange positions; else -1.
  virtual int device() const { return -1; }
  /// Allocates memory on the device.
  virtual std::shared_ptr<void> allocate(std::uint64_t /*bytes*/) { return nullptr; }
  /// Makes work that is enqueued later wait for this cudaEvent_t.
  virtual void wait_for(void* /*event*/) {}
  /// Broadcasts. When it returns, all data have arrived, and nothing reads the given memory any more.
  virtual void broadcast(Span<const DeviceBroadcast> /*all*/) {}
};

/// Returns a link by NCCL; see Communicator. Null if the library was built without it. Throws LinkError.
std::shared_ptr<RankLink> make_nccl_link(void* comm, void* stream, std::chrono::milliseconds patience);
std::vector<std::shared_ptr<RankLink>> make_nccl_links(Span<const int> devices, std::chrono::milliseconds patience);
/// Returns why there is no NCCL; empty if there is.
const char* nccl_problem();

}  // namespace softcd
