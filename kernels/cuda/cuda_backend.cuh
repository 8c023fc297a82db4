#pragma once

#include <cub/device/device_radix_sort.cuh>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "block_team.cuh"
#include "check.hpp"
#include "device_memory.hpp"
#include "generic_kernels.cuh"
#include "graph.hpp"
#include "handles.hpp"
#include "place_positions.cuh"
#include "side_stream.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/memory_account.hpp"
#include "softcd/pipeline/output.hpp"
#include "softcd/pipeline/stage_clock.hpp"
#include "softcd/pipeline/workspace.hpp"
#include "timeline_range.hpp"

namespace softcd {

/// The stages' primitives on one CUDA stream. Counts stay on the device. The host enqueues a whole detection and
/// synchronises once, in finish(). It synchronises earlier only where it needs counts to decide what to enqueue.
class CudaBackend {
 public:
  static constexpr bool kKnowsCounts = false;
  /// Sorting entries costs so little on a GPU that patches did not pay: an H100 took 1.2 to 1.5 times as long with
  /// them.
  static constexpr bool kHasPatches = false;

  /// Enqueues on the caller's stream, or, when that is null, on one of its own.
  CudaBackend(MemoryAccount& account, cudaStream_t stream) : account_(account), stream_(stream) {
    if (stream == nullptr) stream_ = own_stream_.emplace(cudaStreamNonBlocking).get();
    int device = 0;
    check_cuda(cudaGetDevice(&device), "cudaGetDevice");
    check_cuda(cudaDeviceGetAttribute(&processors_, cudaDevAttrMultiProcessorCount, device), "cudaDeviceGetAttribute");
    int major = 0;
    check_cuda(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device), "cudaDeviceGetAttribute");
    starts_early_ = major >= 9;
    host_counters_.reserve(1);
    host_times_.reserve(kMostParts + 1);
    check_cuda(cudaMemsetAsync(done_blocks_.get(), 0, sizeof(std::uint32_t), stream_), "cudaMemset");
  }
  CudaBackend(const CudaBackend&) = delete;
  CudaBackend& operator=(const CudaBackend&) = delete;
  ~CudaBackend() { cudaStreamSynchronize(stream_); }

  /// The backend's data for one query: its graphs, and contacts on the host.
  struct Session {
    struct Key {
      Signature signature;
      std::uint64_t allocations;
      std::size_t first_part;  ///< index in the clock

      friend bool operator==(const Key&, const Key&) = default;
    };
    /// The last launch of one part of detections, and its graph.
    struct Launched {
      std::optional<Key> last_key;   ///< key of the last launch without a graph
      std::optional<Key> graph_key;  ///< key of the captured launch
      ExecutableGraph graph;
      std::vector<Stage> graph_parts;
    };

    std::array<Launched, kLaunchPartCount> launched;
    PinnedBuffer<Contact> contacts;
    const Contact* found = nullptr;  ///< in `contacts`, or on the device
    std::optional<Event> end;        ///< happens after the work that was enqueued last
  };

  template <class T>
  class Buffer {
   public:
    /// Grows the buffer and keeps the first `kept` values. If none are kept, frees the old memory first.
    void reserve(CudaBackend& backend, std::uint64_t capacity, std::uint64_t kept) {
      if (capacity <= capacity_) return;
      if (kept == 0) release(backend);
      const std::uint64_t bytes = capacity * sizeof(T);
      Memory grown(backend.account_, bytes, [&] { return DeviceMemory<T>(capacity); });
      // Sorts move values behind the last one, and 16-byte copies read the gaps between. Zeros keep these bytes
      // defined.
      check_cuda(cudaMemsetAsync(grown.get(), 0, bytes, backend.stream_), "growing a buffer");
      if (kept > 0) {
        check_cuda(cudaMemcpyAsync(grown.get(), memory_.get(), std::min(kept, capacity_) * sizeof(T),
                                   cudaMemcpyDeviceToDevice, backend.stream_),
                   "growing a buffer");
      }
      check_cuda(cudaStreamSynchronize(backend.stream_), "growing a buffer");
      ++backend.allocations_;
      memory_ = std::move(grown);
      capacity_ = capacity;
    }
    void release(CudaBackend& backend) {
      if (capacity_ == 0) return;
      check_cuda(cudaStreamSynchronize(backend.stream_), "giving memory back");
      ++backend.allocations_;
      memory_ = {};
      capacity_ = 0;
    }
    T* data() const { return memory_.get(); }
    std::uint64_t capacity() const { return capacity_; }
    void rewind() {}

   private:
    using Memory = AccountedMemory<DeviceMemory<T>>;

    Memory memory_;
    std::uint64_t capacity_ = 0;
  };

  /// A device copy of a host array.
  template <class T>
  class Mirror {
   public:
    void follow(CudaBackend& backend, Span<const T> values, Span<const Range> changes) {
      const std::uint64_t size = values.size();
      // From its second growth on, reserves a quarter more, so that slowly growing arrays seldom move.
      if (size > copy_.capacity()) copy_.reserve(backend, copy_.capacity() == 0 ? size : size + size / 4, size);
      for (const Range& range : changes) {
        if (range.begin == range.end) continue;
        check_cuda(cudaMemcpyAsync(copy_.data() + range.begin, values.data() + range.begin,
                                   (range.end - range.begin) * sizeof(T), cudaMemcpyHostToDevice, backend.stream_),
                   "copying the scene");
      }
    }
    /// Places positions that are already in device memory. Must not be called while earlier work still reads the
    /// previous list.
    void place(CudaBackend& backend, const std::vector<DevicePositions>& positions, Vec3d origin) {
      if (positions.empty()) return;
      runs_.clear();
      for (const DevicePositions& x : positions) {
        for (std::uint64_t begin = 0; begin < x.count; begin += kRunSize) runs_.push_back(part_of(x, begin));
      }
      shared_runs_.reserve(runs_.size());
      std::copy(runs_.begin(), runs_.end(), shared_runs_.data());
      backend.enqueue("placing positions", [&](cuda::Marks /*marks*/) {
        cuda::place_positions<<<static_cast<unsigned>(runs_.size()), cuda::kBlockSize, 0, backend.stream_>>>(
            shared_runs_.data(), origin, copy_.data());
      });
    }
    const T* data() const { return copy_.data(); }

   private:
    static constexpr std::uint64_t kRunSize = 2048;  ///< number of vertices that one block places

    static DevicePositions part_of(const DevicePositions& x, std::uint64_t begin) {
      GivenPositions given = x.positions;
      given.data = static_cast<const std::byte*>(given.data) + begin * given.stride;
      return {given, x.first + begin, std::min(kRunSize, x.count - begin)};
    }

    Buffer<T> copy_;
    std::vector<DevicePositions> runs_;
    PinnedBuffer<DevicePositions> shared_runs_;
  };

  /// A page-locked host copy of a buffer.
  template <class T>
  class Readback {
   public:
    Span<const T> read(CudaBackend& backend, const Buffer<T>& buffer, std::uint64_t count) {
      copy_.reserve(count);
      if (count > 0) {
        check_cuda(
            cudaMemcpyAsync(copy_.data(), buffer.data(), count * sizeof(T), cudaMemcpyDeviceToHost, backend.stream_),
            "reading answers");
      }
      check_cuda(cudaStreamSynchronize(backend.stream_), "reading answers");
      return {copy_.data(), count};
    }

   private:
    PinnedBuffer<T> copy_;
  };

  template <class T>
  class SortBuffer {
   public:
    void reserve(CudaBackend& backend, std::uint64_t capacity, std::uint64_t kept) {
      rewind();
      if (capacity > scratch_.capacity()) scratch_.release(backend);
      current_.reserve(backend, capacity, kept);
      scratch_.reserve(backend, capacity, 0);
    }
    T* data() const { return current_.data(); }
    T* scratch() const { return scratch_.data(); }
    cub::DoubleBuffer<T> both() { return {current_.data(), scratch_.data()}; }
    /// Selects the buffer that holds the result of a sort.
    void take(const cub::DoubleBuffer<T>& buffers) {
      if (buffers.selector != 0) swap();
    }
    /// Selects the buffer of the detection's start again, so that every detection runs on the same addresses.
    void rewind() {
      if (is_swapped_) swap();
    }

   private:
    void swap() {
      std::swap(current_, scratch_);
      is_swapped_ = !is_swapped_;
    }

    Buffer<T> current_;
    Buffer<T> scratch_;
    bool is_swapped_ = false;
  };

  template <class F>
  void for_each(const char* label, Count count, const F& f) {
    if (count.capacity == 0) return;
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::for_each<F>, blocks_for(count.capacity), cuda::kBlockSize, 0, marks, count, f);
    });
  }

  template <class F>
  void run_once(const char* label, const F& f) {
    enqueue(label, [&](cuda::Marks marks) { start(cuda::run_once<F>, 1, cuda::kTeamSize, 0, marks, f); });
  }

  template <class F, class... Targets>
  void for_each_append(const char* label, Count count, const F& f, Appender<Targets>... lists) {
    if (count.capacity == 0) return;
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::for_each_append<F, Targets...>, blocks_for(count.capacity), cuda::kBlockSize, 0, marks, count, f,
            lists...);
    });
  }

  template <class F, class... Targets>
  void for_each_search(const char* label, Count count, const F& f, Appender<Targets>... lists) {
    if (count.capacity == 0) return;
    const unsigned blocks = std::min(blocks_for(count.capacity), static_cast<unsigned>(processors_ * 8));
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::for_each_search<F, Targets...>, blocks, cuda::kBlockSize, 0, marks, count, f, lists...);
    });
  }

  template <class F, class... Targets>
  void for_each_work(const char* label, Count items, const std::uint64_t* offsets, const std::uint64_t* total,
                     const F& f, Appender<Targets>... lists) {
    if (items.capacity == 0) return;
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::for_each_work<F, Targets...>, static_cast<unsigned>(processors_ * 8), cuda::kBlockSize, 0, marks,
            items, offsets, total, f, lists...);
    });
  }

  template <class F, class... Targets>
  void for_each_work_filtered(const char* label, Count items, const std::uint64_t* offsets, const std::uint64_t* total,
                              Share share, const F& f, Appender<Targets>... lists) {
    if (items.capacity == 0) return;
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::for_each_work_filtered<F, Targets...>, static_cast<unsigned>(processors_ * 12), cuda::kBlockSize, 0,
            marks, items, offsets, total, share, f, lists...);
    });
  }

  template <class F, class... Targets>
  void for_each_part(const char* label, Count count, const F& f, Appender<Targets>... lists) {
    if (count.capacity == 0) return;
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::for_each_part<F, Targets...>, blocks_for(count.capacity, cuda::kItemsAtOnce<F>), cuda::kBlockSize, 0,
            marks, count, f, lists...);
    });
  }

  template <class F, class... Targets>
  void for_each_part_filtered(const char* label, Count count, const F& f, Appender<Targets>... lists) {
    if (count.capacity == 0) return;
    const unsigned blocks =
        std::min(blocks_for(count.capacity, cuda::kItemsAtOnce<F>), static_cast<unsigned>(processors_ * 8));
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::for_each_part_filtered<F, Targets...>, blocks, cuda::kBlockSize, 0, marks, count, f, lists...);
    });
  }

  /// Runs the work of f and g at the same time. g must not reserve memory, sort or scan.
  template <class F, class G>
  void concurrently(const F& f, const G& g) {
    SideStream::Fork fork(side_, stream_);
    {
      const OnStream on_side(stream_, fork.stream());
      g();
    }
    f();
    fork.join();
  }

  void exclusive_scan(const char* label, Count count, const std::uint32_t* values, std::uint64_t* sums,
                      std::uint64_t* total) {
    if (count.capacity == 0) return;
    const std::uint64_t tiles = count.capacity / cuda::kScanTile + 1;
    scan_state_.reserve(*this, tiles + 1, 0);
    const cuda::ScanState state = {scan_state_.data() + 1, reinterpret_cast<unsigned*>(scan_state_.data())};
    const auto blocks = static_cast<unsigned>(std::min<std::uint64_t>(tiles, static_cast<unsigned>(processors_) * 4U));
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::scan, blocks, cuda::kBlockSize, 0, marks, count, values, sums, total, state);
    });
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
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::histogram<F>, blocks, cuda::kBlockSize, bytes, marks, count, bins, histograms, bins_per_histogram, f);
    });
  }

  template <class F>
  void minimum(const char* label, Count count, const F& f, float* least) {
    if (count.capacity == 0) return;
    const unsigned blocks = std::min(blocks_for(count.capacity), static_cast<unsigned>(processors_ * 2));
    enqueue(label,
            [&](cuda::Marks marks) { start(cuda::minimum<F>, blocks, cuda::kBlockSize, 0, marks, count, f, least); });
  }

  template <class T>
  void upload(Buffer<T>& buffer, Span<const T> values) {
    if (values.empty()) return;
    check_cuda(
        cudaMemcpyAsync(buffer.data(), values.data(), values.size() * sizeof(T), cudaMemcpyHostToDevice, stream_),
        "upload");
  }

  /// Enqueues a part of a detection. The second of equal launches in a row is captured as a graph, and all further ones
  /// replay it. Host time and gaps between kernels then shrink to those of one launch. Only the first launch allocates
  /// memory. The legacy default stream cannot be captured.
  template <class F>
  void launch(const Signature& signature, const F& f) {
    const bool is_first = signature.part == LaunchPart::whole || signature.part == LaunchPart::comparison;
    if (is_first) {
      parts_.clear();
      begun_ = 0;
    }
    typename Session::Launched& launched = session_->launched[static_cast<std::size_t>(signature.part)];
    const typename Session::Key key = {signature, allocations_, parts_.size()};
    if (launched.graph && key == launched.graph_key) {
      parts_.insert(parts_.end(), launched.graph_parts.begin(), launched.graph_parts.end());
    } else if (key == launched.last_key && stream_ != cudaStreamLegacy) {
      capture(launched.graph, f);
      launched.graph_key = key;
      launched.graph_parts.assign(parts_.begin() + static_cast<std::ptrdiff_t>(key.first_part), parts_.end());
    } else {
      f();
      launched.last_key = {signature, allocations_, key.first_part};
      return;
    }
    const TimelineRange range("launching a graph");
    check_cuda(cudaGraphLaunch(launched.graph.get(), stream_), "launching a graph");
  }

  /// Waits for all enqueued work and returns the counters.
  Counters read(const Buffer<Counters>& counters) {
    hand_out("reading counters", 1, counters, Count{&counters.data()->contacts, 0}, nullptr);
    const TimelineRange range("reading counters");
    check_cuda(cudaStreamSynchronize(stream_), "reading counters");
    return *host_counters_.data();
  }

  /// Enqueues the reading of counters, and of contacts if `to_host`; else contacts stay on the device.
  void download(const Buffer<Counters>& counters, const Buffer<Contact>& contacts, Count count, bool to_host) {
    if (to_host) session_->contacts.reserve(count.capacity);
    session_->found = to_host ? session_->contacts.data() : contacts.data();
    const unsigned blocks = to_host ? static_cast<unsigned>(processors_ * 4) : 1U;
    if (!to_host) count.capacity = 0;
    hand_out("reading results", blocks, counters, count, contacts.data());
  }

  /// Lets work that is enqueued from now on wait for a cudaEvent_t.
  void wait_for(void* event) {
    check_cuda(cudaStreamWaitEvent(stream_, static_cast<cudaEvent_t>(event), 0), "waiting for positions");
  }

  /// Returns an event after all enqueued work.
  void* mark_end() {
    if (!session_->end) session_->end.emplace(cudaEventDisableTiming);
    check_cuda(cudaEventRecord(session_->end->get(), stream_), "marking the end of a detection");
    return session_->end->get();
  }

  Counters finish() {
    const TimelineRange range("finishing a detection");
    check_cuda(cudaStreamSynchronize(stream_), "finishing a detection");
    replaced_graphs_.clear();
    return *host_counters_.data();
  }

  Span<const Contact> contacts(std::uint64_t count) {
    read_clock();
    return {session_->found, count};
  }

  void begin_detection(Session& session) {
    session_ = &session;
    reruns_ = 0;
  }
  void begin(Stage stage) {
    if (parts_.size() == kMostParts) return;
    parts_.push_back(stage);
    ++begun_;
  }

  void count_rerun() { ++reruns_; }
  /// Frees the scratch memory, once no enqueued work uses it, or memory that the caller is about to free.
  void give_scratch_back() {
    check_cuda(cudaStreamSynchronize(stream_), "giving memory back");
    scratch_.release(*this);
    scan_state_.release(*this);
  }
  std::uint64_t reruns() const { return reruns_; }
  const StageTimes& times() const { return stage_times_; }

 private:
  /// Enqueues work on another stream for the lifetime of this object.
  class OnStream {
   public:
    OnStream(cudaStream_t& current, cudaStream_t other) : current_(current), before_(std::exchange(current, other)) {}
    OnStream(const OnStream&) = delete;
    OnStream& operator=(const OnStream&) = delete;
    ~OnStream() { current_ = before_; }

   private:
    cudaStream_t& current_;
    cudaStream_t before_;
  };

  /// Most parts whose times are taken. Later ones, of a detection in very many chunks, count as the last of them.
  static constexpr std::size_t kMostParts = 1024;

  /// Calls f(marks), which launches a kernel, and checks for errors.
  template <class F>
  void enqueue(const char* label, const F& f) {
    const TimelineRange range(label);
    f(cuda::Marks{times_.get() + (parts_.size() - begun_), begun_});
    begun_ = 0;
    check_cuda(cudaGetLastError(), label);
  }

  /// Launches a kernel. From compute capability 9.0 on, the kernel may start before the one before it has ended; it
  /// then waits (see cuda::Marks::begin). So the device need not start it afterwards.
  template <class... Parameters, class... Arguments>
  void start(void (*kernel)(cuda::Marks, Parameters...), unsigned blocks, unsigned threads, std::size_t shared_bytes,
             cuda::Marks marks, const Arguments&... arguments) {
    cudaLaunchAttribute early{};
    early.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    early.val.programmaticStreamSerializationAllowed = 1;
    cudaLaunchConfig_t config{};
    config.gridDim = dim3(blocks);
    config.blockDim = dim3(threads);
    config.dynamicSmemBytes = shared_bytes;
    config.stream = stream_;
    config.attrs = &early;
    config.numAttrs = starts_early_ ? 1 : 0;
    cudaLaunchKernelEx(&config, kernel, marks, Parameters(arguments)...);
  }

  void hand_out(const char* label, unsigned blocks, const Buffer<Counters>& counters, Count count,
                const Contact* contacts) {
    enqueue(label, [&](cuda::Marks marks) {
      const cuda::Results results = {counters.data(),
                                     host_counters_.data(),
                                     times_.get(),
                                     host_times_.data(),
                                     static_cast<std::uint32_t>(parts_.size()),
                                     done_blocks_.get()};
      start(cuda::hand_out<Contact>, blocks, cuda::kBlockSize, 0, marks, results, count, contacts,
            session_->contacts.data());
    });
  }

  unsigned blocks_for(std::uint64_t items, std::uint64_t items_per_block = cuda::kBlockSize) const {
    const std::uint64_t blocks = (items + items_per_block - 1) / items_per_block;
    return static_cast<unsigned>(std::min<std::uint64_t>(blocks, static_cast<std::uint64_t>(processors_) * 64));
  }

  template <class Key>
  void fill_tail(const char* label, Count count, Key* keys) {
    enqueue(label, [&](cuda::Marks marks) {
      start(cuda::fill_tail<Key>, blocks_for(count.capacity), cuda::kBlockSize, 0, marks, count, keys);
    });
  }

  /// Runs a CUB call, which first reports the scratch memory that it needs. Calls follow each other on the stream, so
  /// they share the scratch memory.
  template <class F>
  void with_scratch(const char* label, const F& f) {
    const TimelineRange range(label);
    std::size_t bytes = 0;
    check_cuda(f(nullptr, bytes), label);
    scratch_.reserve(*this, bytes, 0);
    bytes = scratch_.capacity();
    check_cuda(f(scratch_.data(), bytes), label);
  }

  /// Captures the work of f as a graph. The replaced graph is destroyed only when a detection has finished: earlier
  /// destruction may block on work that the stream waits for.
  template <class F>
  void capture(ExecutableGraph& graph, const F& f) {
    if (graph) replaced_graphs_.push_back(std::exchange(graph, {}));
    StreamCapture capture(stream_);
    f();
    graph = capture.finish();
  }

  void read_clock() {
    stage_times_ = {};
    for (std::size_t part = 0; part < parts_.size(); ++part) {
      const std::uint64_t* const begin = host_times_.data() + part;
      const double ms = 1e-6 * static_cast<double>(static_cast<std::int64_t>(begin[1] - begin[0]));
      stage_time(stage_times_, parts_[part]) += ms;
      stage_times_.total += ms;
    }
  }

  MemoryAccount& account_;
  std::optional<Stream> own_stream_;
  cudaStream_t stream_;
  SideStream side_;
  int processors_ = 0;
  bool starts_early_ = false;  ///< see start()
  Buffer<std::byte> scratch_;
  Buffer<unsigned long long> scan_state_;  ///< the first word is cuda::ScanState::done_blocks
  PinnedBuffer<Counters> host_counters_;
  std::vector<Stage> parts_;                       ///< of the detection, in order
  std::uint32_t begun_ = 0;                        ///< parts whose first kernel is still to come
  DeviceMemory<std::uint64_t> times_{kMostParts};  ///< at which parts begin; see cuda::Marks
  PinnedBuffer<std::uint64_t> host_times_;         ///< and, behind the last, the end
  DeviceMemory<std::uint32_t> done_blocks_{1};     ///< see cuda::Results
  StageTimes stage_times_;
  std::uint64_t reruns_ = 0;

  std::uint64_t allocations_ = 0;                 ///< changes when any buffer moves
  Session* session_ = nullptr;                    ///< session of the detection that began last
  std::vector<ExecutableGraph> replaced_graphs_;  ///< may still run
};

}  // namespace softcd
