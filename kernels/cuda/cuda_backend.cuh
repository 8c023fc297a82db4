#pragma once

#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include <array>
#include <vector>

#include "check.hpp"
#include "device_memory.hpp"
#include "generic_kernels.cuh"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/output.hpp"
#include "softcd/pipeline/stage_clock.hpp"
#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// The stages' primitives on one CUDA stream. Counts stay on the device: the host enqueues a whole detection and
/// synchronises once, in finish.
class CudaBackend {
 public:
  static constexpr bool kKnowsCounts = false;

  CudaBackend() {
    check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
    int device = 0;
    check_cuda(cudaGetDevice(&device), "cudaGetDevice");
    check_cuda(cudaDeviceGetAttribute(&processors_, cudaDevAttrMultiProcessorCount, device), "cudaDeviceGetAttribute");
    for (cudaEvent_t& event : events_) check_cuda(cudaEventCreate(&event), "cudaEventCreate");
    read_back_.reserve(1);
  }
  CudaBackend(const CudaBackend&) = delete;
  CudaBackend& operator=(const CudaBackend&) = delete;
  ~CudaBackend() {
    cudaStreamSynchronize(stream_);
    for (cudaEvent_t event : events_) cudaEventDestroy(event);
    cudaStreamDestroy(stream_);
  }

  template <class T>
  class Buffer {
   public:
    void reserve(CudaBackend& backend, std::uint64_t capacity, std::uint64_t kept) {
      if (capacity <= capacity_) return;
      DeviceMemory<T> grown(capacity);
      if (kept > 0) {
        check_cuda(cudaMemcpyAsync(grown.get(), memory_.get(), std::min(kept, capacity_) * sizeof(T),
                                   cudaMemcpyDeviceToDevice, backend.stream_),
                   "growing a buffer");
      }
      check_cuda(cudaStreamSynchronize(backend.stream_), "growing a buffer");
      backend.bytes_ += (capacity - capacity_) * sizeof(T);
      memory_ = std::move(grown);
      capacity_ = capacity;
    }
    T* data() const { return memory_.get(); }
    std::uint64_t capacity() const { return capacity_; }

   private:
    DeviceMemory<T> memory_;
    std::uint64_t capacity_ = 0;
  };

  template <class T>
  class SortBuffer {
   public:
    void reserve(CudaBackend& backend, std::uint64_t capacity, std::uint64_t kept) {
      current_.reserve(backend, capacity, kept);
      scratch_.reserve(backend, capacity, 0);
    }
    T* data() const { return current_.data(); }
    cub::DoubleBuffer<T> both() { return {current_.data(), scratch_.data()}; }
    /// After a sort that left its result in `buffers`.
    void take(const cub::DoubleBuffer<T>& buffers) {
      if (buffers.selector != 0) std::swap(current_, scratch_);
    }

   private:
    Buffer<T> current_;
    Buffer<T> scratch_;
  };

  template <class F>
  void for_each(const char* label, Count count, const F& f) {
    if (count.capacity == 0) return;
    cuda::for_each<<<blocks_for(count.capacity), cuda::kBlockSize, 0, stream_>>>(count, f);
    check_cuda(cudaGetLastError(), label);
  }

  template <class F, class... Targets>
  void for_each_append(const char* label, Count count, const F& f, Appender<Targets>... lists) {
    if (count.capacity == 0) return;
    cuda::for_each_append<<<blocks_for(count.capacity), cuda::kBlockSize, 0, stream_>>>(count, f, lists...);
    check_cuda(cudaGetLastError(), label);
  }

  template <class F, class... Targets>
  void for_each_work(const char* label, Count items, const std::uint64_t* offsets, const std::uint64_t* total,
                     const F& f, Appender<Targets>... lists) {
    if (items.capacity == 0) return;
    cuda::for_each_work<<<static_cast<unsigned>(processors_ * 8), cuda::kBlockSize, 0, stream_>>>(items, offsets, total,
                                                                                                  f, lists...);
    check_cuda(cudaGetLastError(), label);
  }

  void exclusive_scan(const char* label, Count count, const std::uint32_t* values, std::uint64_t* sums,
                      std::uint64_t* total) {
    if (count.capacity == 0) return;
    const auto input =
        thrust::make_transform_iterator(thrust::counting_iterator<std::uint64_t>(0), cuda::ValueOrZero{count, values});
    with_scratch(label, [&](void* scratch, std::size_t& bytes) {
      return cub::DeviceScan::ExclusiveSum(scratch, bytes, input, sums, static_cast<std::int64_t>(count.capacity),
                                           stream_);
    });
    cuda::last_sum<<<1, 1, 0, stream_>>>(count, values, sums, total);
    check_cuda(cudaGetLastError(), label);
  }

  template <class Key>
  void sort_keys(const char* label, Count count, SortBuffer<Key>& keys, int bits) {
    if (count.capacity == 0) return;
    fill_tail(label, count, keys.data());
    cub::DoubleBuffer<Key> key_buffers = keys.both();
    with_scratch(label, [&](void* scratch, std::size_t& bytes) {
      return cub::DeviceRadixSort::SortKeys(scratch, bytes, key_buffers, static_cast<std::int64_t>(count.capacity), 0,
                                            bits, stream_);
    });
    keys.take(key_buffers);
  }

  template <class Key, class Value>
  void sort_pairs(const char* label, Count count, SortBuffer<Key>& keys, SortBuffer<Value>& values, int bits) {
    if (count.capacity == 0) return;
    fill_tail(label, count, keys.data());
    cub::DoubleBuffer<Key> key_buffers = keys.both();
    cub::DoubleBuffer<Value> value_buffers = values.both();
    with_scratch(label, [&](void* scratch, std::size_t& bytes) {
      return cub::DeviceRadixSort::SortPairs(scratch, bytes, key_buffers, value_buffers,
                                             static_cast<std::int64_t>(count.capacity), 0, bits, stream_);
    });
    keys.take(key_buffers);
    values.take(value_buffers);
  }

  template <class F>
  void histogram(const char* label, Count count, std::uint32_t* bins, int histograms, int bins_per_histogram,
                 const F& f) {
    const std::size_t bytes = sizeof(std::uint32_t) * static_cast<std::size_t>(histograms * bins_per_histogram);
    check_cuda(cudaMemsetAsync(bins, 0, bytes, stream_), label);
    if (count.capacity == 0) return;
    const unsigned blocks = std::min(blocks_for(count.capacity), static_cast<unsigned>(processors_ * 2));
    cuda::histogram<<<blocks, cuda::kBlockSize, bytes, stream_>>>(count, bins, histograms, bins_per_histogram, f);
    check_cuda(cudaGetLastError(), label);
  }

  template <class F>
  void minimum(const char* label, Count count, const F& f, float* least) {
    if (count.capacity == 0) return;
    const unsigned blocks = std::min(blocks_for(count.capacity), static_cast<unsigned>(processors_ * 2));
    cuda::minimum<<<blocks, cuda::kBlockSize, 0, stream_>>>(count, f, least);
    check_cuda(cudaGetLastError(), label);
  }

  template <class T>
  void upload(Buffer<T>& buffer, Span<const T> values) {
    if (values.empty()) return;
    check_cuda(
        cudaMemcpyAsync(buffer.data(), values.data(), values.size() * sizeof(T), cudaMemcpyHostToDevice, stream_),
        "upload");
  }

  void reserve_positions(Buffer<Vec3f>& x_t0, Buffer<Vec3f>& x_t1, std::uint64_t count) {
    x_t0.reserve(*this, count, 0);
    x_t1.reserve(*this, count, 0);
    host_x_t0_.reserve(count);
    host_x_t1_.reserve(count);
  }
  PositionArrays position_arrays(Buffer<Vec3f>& /*x_t0*/, Buffer<Vec3f>& /*x_t1*/) {
    return {host_x_t0_.data(), host_x_t1_.data()};
  }
  void upload_positions(Buffer<Vec3f>& x_t0, Buffer<Vec3f>& x_t1, std::uint64_t count, bool both_ends) {
    upload(x_t1, Span<const Vec3f>(host_x_t1_.data(), count));
    if (both_ends) upload(x_t0, Span<const Vec3f>(host_x_t0_.data(), count));
  }

  template <class F>
  void launch(const F& f) {
    f();
    end_part();
  }

  Counters finish(const Buffer<Counters>& counters) {
    check_cuda(cudaMemcpyAsync(read_back_.data(), counters.data(), sizeof(Counters), cudaMemcpyDeviceToHost, stream_),
               "reading counters");
    check_cuda(cudaStreamSynchronize(stream_), "finishing a detection");
    return *read_back_.data();
  }

  Span<const Contact> download(const Buffer<Contact>& contacts, std::uint64_t count) {
    begin(Stage::transfer);
    host_contacts_.reserve(std::max(contacts.capacity(), count));
    if (count > 0) {
      check_cuda(cudaMemcpyAsync(host_contacts_.data(), contacts.data(), count * sizeof(Contact),
                                 cudaMemcpyDeviceToHost, stream_),
                 "reading contacts");
    }
    end_part();
    check_cuda(cudaStreamSynchronize(stream_), "reading contacts");
    read_clock();
    return {host_contacts_.data(), count};
  }

  void start_clock() {
    reruns_ = 0;
    part_count_ = 0;
  }
  void begin(Stage stage) {
    if (part_count_ < kMostParts) {
      parts_[part_count_] = stage;
      check_cuda(cudaEventRecord(events_[part_count_++], stream_), "recording time");
    }
  }

  void count_rerun() { ++reruns_; }
  std::uint64_t peak_bytes() const { return bytes_; }
  std::uint64_t reruns() const { return reruns_; }
  const StageTimes& times() const { return times_; }

 private:
  static constexpr std::size_t kMostParts = 63;

  unsigned blocks_for(std::uint64_t items) const {
    const std::uint64_t blocks = (items + cuda::kBlockSize - 1) / cuda::kBlockSize;
    return static_cast<unsigned>(std::min<std::uint64_t>(blocks, static_cast<std::uint64_t>(processors_) * 64));
  }

  template <class Key>
  void fill_tail(const char* label, Count count, Key* keys) {
    cuda::fill_tail<<<blocks_for(count.capacity), cuda::kBlockSize, 0, stream_>>>(count, keys);
    check_cuda(cudaGetLastError(), label);
  }

  /// Runs a CUB call that says first how much scratch it needs. Calls follow each other on the stream, so they share
  /// it.
  template <class F>
  void with_scratch(const char* label, const F& f) {
    std::size_t bytes = 0;
    check_cuda(f(nullptr, bytes), label);
    scratch_.reserve(*this, bytes, 0);
    bytes = scratch_.capacity();
    check_cuda(f(scratch_.data(), bytes), label);
  }

  void end_part() { check_cuda(cudaEventRecord(events_[part_count_], stream_), "recording time"); }

  void read_clock() {
    times_ = {};
    for (std::size_t part = 0; part < part_count_; ++part) {
      float ms = 0;
      check_cuda(cudaEventElapsedTime(&ms, events_[part], events_[part + 1]), "reading time");
      stage_time(times_, parts_[part]) += static_cast<double>(ms);
      times_.total += static_cast<double>(ms);
    }
  }

  cudaStream_t stream_ = nullptr;
  int processors_ = 0;
  Buffer<std::byte> scratch_;
  PinnedBuffer<Vec3f> host_x_t0_, host_x_t1_;
  PinnedBuffer<Counters> read_back_;
  PinnedBuffer<Contact> host_contacts_;
  std::array<cudaEvent_t, kMostParts + 1> events_{};
  std::array<Stage, kMostParts> parts_{};
  std::size_t part_count_ = 0;
  StageTimes times_;
  std::uint64_t bytes_ = 0;
  std::uint64_t reruns_ = 0;
};

}  // namespace softcd
