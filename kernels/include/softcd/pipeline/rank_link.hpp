#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "softcd/core/span.hpp"

namespace softcd {

/// Ranks could not talk with each other, and will not be able to any more.
class LinkError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Memory on a rank's device, which one rank gives to all. `given` is where the root has it, as `count` elements of
/// `element` bytes each, `stride` bytes apart, on its device or the host; `data` is memory of allocate().
struct DeviceBroadcast {
  int root;
  void* data;
  const void* given;
  bool is_given_on_device;
  std::uint64_t count, element, stride;
};

/// What connects one rank with the others. All ranks call the same functions in the same order. Throws LinkError.
class RankLink {
 public:
  virtual ~RankLink() = default;

  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// As Communicator::AllGather; the host's memory.
  virtual void all_gather(const void* mine, std::uint64_t bytes, void* all) = 0;

  /// The rank's CUDA device, where it has one, and positions are exchanged between devices; else -1.
  virtual int device() const { return -1; }
  /// Memory on the device.
  virtual std::shared_ptr<void> allocate(std::uint64_t /*bytes*/) { return nullptr; }
  /// What is enqueued from now on waits for this cudaEvent_t.
  virtual void wait_for(void* /*event*/) {}
  /// All data are there when the call returns, and nothing reads what was given any more.
  virtual void broadcast(Span<const DeviceBroadcast> /*all*/) {}
};

/// Ranks by NCCL; see Communicator. Null where the library was built without it. Throws LinkError.
std::shared_ptr<RankLink> make_nccl_link(void* comm, void* stream, std::chrono::milliseconds patience);
std::vector<std::shared_ptr<RankLink>> make_nccl_links(Span<const int> devices, std::chrono::milliseconds patience);
/// Why there is no NCCL; empty where there is.
const char* nccl_problem();

}  // namespace softcd
