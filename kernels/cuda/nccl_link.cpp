#include <nccl.h>

#include <algorithm>
#include <string>
#include <thread>
#include <utility>

#include "check.hpp"
#include "device_guard.hpp"
#include "device_memory.hpp"
#include "softcd/core/loaded_library.hpp"
#include "softcd/pipeline/meeting_point.hpp"
#include "softcd/pipeline/rank_link.hpp"

namespace softcd {
namespace {

#if defined(_WIN32)
constexpr const char* kNcclLibrary = "nccl.dll";
#else
constexpr const char* kNcclLibrary = "libnccl.so.2";
#endif

/// The functions of the NCCL library that the program has loaded, or else of the one that the system finds.
class Nccl {
 public:
  static const Nccl& instance() {
    static const Nccl nccl;
    return nccl;
  }
  const std::string& problem() const { return library_.problem(); }

  decltype(&ncclAllGather) all_gather = nullptr;
  decltype(&ncclBroadcast) broadcast = nullptr;
  decltype(&ncclGroupStart) group_start = nullptr;
  decltype(&ncclGroupEnd) group_end = nullptr;
  decltype(&ncclCommInitAll) init_all = nullptr;
  decltype(&ncclCommDestroy) destroy = nullptr;
  decltype(&ncclCommAbort) abort = nullptr;
  decltype(&ncclCommCount) count = nullptr;
  decltype(&ncclCommUserRank) user_rank = nullptr;
  decltype(&ncclCommCuDevice) device = nullptr;
  decltype(&ncclCommGetAsyncError) async_error = nullptr;
  decltype(&ncclGetErrorString) error_string = nullptr;

 private:
  Nccl() {
    library_.find("ncclAllGather", all_gather);
    library_.find("ncclBroadcast", broadcast);
    library_.find("ncclGroupStart", group_start);
    library_.find("ncclGroupEnd", group_end);
    library_.find("ncclCommInitAll", init_all);
    library_.find("ncclCommDestroy", destroy);
    library_.find("ncclCommAbort", abort);
    library_.find("ncclCommCount", count);
    library_.find("ncclCommUserRank", user_rank);
    library_.find("ncclCommCuDevice", device);
    library_.find("ncclCommGetAsyncError", async_error);
    library_.find("ncclGetErrorString", error_string);
  }

  LoadedLibrary library_{kNcclLibrary};
};

void check_nccl(ncclResult_t result, const char* what) {
  if (result != ncclSuccess) {
    throw LinkError(std::string(what) + " failed: " + Nccl::instance().error_string(result));
  }
}

class NcclLink final : public RankLink {
 public:
  /// Makes a rank. With `place`, the ranks are threads of this process that meet there, and the rank owns its
  /// communicator and stream.
  NcclLink(ncclComm_t comm, cudaStream_t stream, std::chrono::milliseconds patience,
           std::shared_ptr<MeetingPoint> place = nullptr)
      : comm_(comm), stream_(stream), is_own_(place != nullptr), patience_(patience), place_(std::move(place)) {
    const Nccl& nccl = Nccl::instance();
    check_nccl(nccl.user_rank(comm_, &rank_), "ncclCommUserRank");
    check_nccl(nccl.count(comm_, &size_), "ncclCommCount");
    check_nccl(nccl.device(comm_, &device_), "ncclCommCuDevice");
    const DeviceGuard guard(device_);
    if (is_own_) check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
    check_cuda(cudaEventCreateWithFlags(&done_, cudaEventDisableTiming), "cudaEventCreate");
  }
  NcclLink(const NcclLink&) = delete;
  NcclLink& operator=(const NcclLink&) = delete;
  ~NcclLink() noexcept override {
    free_on(device_, [&] {
      if (is_own_ && !is_broken_) Nccl::instance().destroy(comm_);
      cudaEventDestroy(done_);
      if (is_own_) cudaStreamDestroy(stream_);
      staged_ = {};
      gathered_ = {};
    });
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int device() const override { return device_; }

  void all_gather(const void* mine, std::uint64_t bytes, void* all) override {
    if (place_ != nullptr) return place_->all_gather(rank_, mine, bytes, all);
    const DeviceGuard guard(device_);
    const std::uint64_t all_bytes = bytes * static_cast<std::uint64_t>(size_);
    host_.reserve(all_bytes);
    if (bytes_ < bytes) {
      staged_ = {};
      gathered_ = {};
      staged_ = DeviceMemory<std::byte>(bytes);
      gathered_ = DeviceMemory<std::byte>(all_bytes);
      bytes_ = bytes;
    }
    std::copy_n(static_cast<const std::byte*>(mine), bytes, host_.data());
    check_cuda(cudaMemcpyAsync(staged_.get(), host_.data(), bytes, cudaMemcpyHostToDevice, stream_), "telling ranks");
    talk([&](const Nccl& nccl) {
      return nccl.all_gather(staged_.get(), gathered_.get(), bytes, ncclUint8, comm_, stream_);
    });
    check_cuda(cudaMemcpyAsync(host_.data(), gathered_.get(), all_bytes, cudaMemcpyDeviceToHost, stream_),
               "hearing ranks");
    wait();
    std::copy_n(host_.data(), all_bytes, static_cast<std::byte*>(all));
  }

  std::shared_ptr<void> allocate(std::uint64_t bytes) override {
    const DeviceGuard guard(device_);
    const int device = device_;
    auto memory = std::make_shared<DeviceMemory<std::byte>>(bytes);
    std::byte* const data = memory->get();
    const auto free = [memory = std::move(memory), device](std::byte* /*data*/) mutable noexcept {
      free_on(device, [&] { memory.reset(); });
    };
    return std::shared_ptr<std::byte>(data, free);
  }

  void wait_for(void* event) override {
    const DeviceGuard guard(device_);
    check_cuda(cudaStreamWaitEvent(stream_, static_cast<cudaEvent_t>(event), 0), "waiting for positions");
  }

  void broadcast(Span<const DeviceBroadcast> all) override {
    const DeviceGuard guard(device_);
    for (const DeviceBroadcast& one : all) {
      if (one.root == rank_ && one.count > 0) take(one);
    }
    // A kernel that waits for another GPU's kernel keeps that GPU's thread from allocating or freeing memory. That
    // thread may have to do so first, so all threads meet here.
    if (place_ != nullptr) place_->meet();
    talk([&](const Nccl& nccl) {
      ncclResult_t result = nccl.group_start();
      for (const DeviceBroadcast& one : all) {
        if (result != ncclSuccess) break;
        result = nccl.broadcast(one.data, one.data, one.count * one.element, ncclUint8, one.root, comm_, stream_);
      }
      const ncclResult_t end = nccl.group_end();
      return result != ncclSuccess ? result : end;
    });
    wait();
  }

 private:
  void take(const DeviceBroadcast& one) {
    const auto kind = one.is_given_on_device ? cudaMemcpyDeviceToDevice : cudaMemcpyHostToDevice;
    const std::uint64_t stride = one.count > 1 ? one.stride : one.element;
    check_cuda(stride == one.element
                   ? cudaMemcpyAsync(one.data, one.given, one.count * one.element, kind, stream_)
                   : cudaMemcpy2DAsync(one.data, one.element, one.given, stride, one.element, one.count, kind, stream_),
               "packing positions");
  }

  template <class F>
  void talk(const F& f) {
    if (is_broken_) throw LinkError("NCCL has failed before");
    const ncclResult_t result = f(Nccl::instance());
    if (result != ncclSuccess && result != ncclInProgress) fail(Nccl::instance().error_string(result));
  }

  /// Waits until all enqueued work is done.
  void wait() {
    using Clock = std::chrono::steady_clock;
    check_cuda(cudaEventRecord(done_, stream_), "waiting for ranks");
    const Clock::time_point begin = Clock::now();
    for (;;) {
      const cudaError_t status = cudaEventQuery(done_);
      if (status == cudaSuccess) return;
      if (status != cudaErrorNotReady) check_cuda(status, "waiting for ranks");
      const auto waited = Clock::now() - begin;
      if (waited < std::chrono::milliseconds(1)) continue;
      ncclResult_t problem = ncclSuccess;
      Nccl::instance().async_error(comm_, &problem);
      if (problem != ncclSuccess && problem != ncclInProgress) fail(Nccl::instance().error_string(problem));
      if (waited > patience_) {
        fail("another rank has not taken part within " + std::to_string(patience_.count()) + " ms");
      }
      std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
  }

  [[noreturn]] void fail(const std::string& problem) {
    is_broken_ = true;
    if (is_own_) Nccl::instance().abort(comm_);
    throw LinkError("NCCL: " + problem);
  }

  ncclComm_t comm_;
  cudaStream_t stream_;
  bool is_own_;
  std::chrono::milliseconds patience_;
  std::shared_ptr<MeetingPoint> place_;
  int rank_ = 0;
  int size_ = 1;
  int device_ = 0;
  bool is_broken_ = false;
  cudaEvent_t done_ = nullptr;
  PinnedBuffer<std::byte> host_;
  DeviceMemory<std::byte> staged_, gathered_;
  std::uint64_t bytes_ = 0;  ///< capacity for each rank
};

}  // namespace

std::shared_ptr<RankLink> make_nccl_link(void* comm, void* stream, std::chrono::milliseconds patience) {
  return std::make_shared<NcclLink>(static_cast<ncclComm_t>(comm), static_cast<cudaStream_t>(stream), patience);
}

std::vector<std::shared_ptr<RankLink>> make_nccl_links(Span<const int> devices, std::chrono::milliseconds patience) {
  std::vector<ncclComm_t> comms(devices.size());
  check_nccl(Nccl::instance().init_all(comms.data(), static_cast<int>(devices.size()), devices.data()),
             "ncclCommInitAll");
  std::vector<std::shared_ptr<RankLink>> links;
  links.reserve(comms.size());
  const auto place = std::make_shared<MeetingPoint>(static_cast<int>(devices.size()), patience);
  for (ncclComm_t comm : comms) links.push_back(std::make_shared<NcclLink>(comm, nullptr, patience, place));
  return links;
}

const char* nccl_problem() {
  return Nccl::instance().problem().c_str();
}

}  // namespace softcd
