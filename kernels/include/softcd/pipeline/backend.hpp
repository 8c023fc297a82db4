#pragma once

#include <concepts>
#include <cstdint>

#include "softcd/core/contact.hpp"
#include "softcd/core/count.hpp"
#include "softcd/core/span.hpp"
#include "softcd/core/statistics.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/output.hpp"
#include "softcd/pipeline/stage_clock.hpp"
#include "softcd/pipeline/workspace.hpp"

/// The primitives that a detection needs of a backend. cpu/cpu_backend.hpp, the shorter one, describes each of them.
/// tests/kernels/primitives run those of every backend. Labels name the work in errors, profiles and timelines.
namespace softcd {
namespace probe {

/// Stands for any functor of a stage, and for any callable.
struct Functor {};
using Target = ArrayTarget<std::uint32_t>;

}  // namespace probe

/// Memory of the backend that owns itself and only grows. rewind() undoes what sorting did to addresses.
template <class M, class B, class T>
concept BackendMemory = std::default_initializable<M> && std::movable<M> && requires(M memory, B& backend) {
  memory.reserve(backend, std::uint64_t{}, std::uint64_t{});
  { memory.data() } -> std::convertible_to<const T*>;
  memory.rewind();
};

/// Memory: Buffer; SortBuffer, a buffer with scratch memory for sorting; Mirror, which follows an array of the host;
/// Readback, where the host reads a buffer.
template <class B>
concept HasMemory = BackendMemory<typename B::template Buffer<std::uint32_t>, B, std::uint32_t> &&
    BackendMemory<typename B::template SortBuffer<std::uint64_t>, B, std::uint64_t> &&
    requires(B b, typename B::template Buffer<std::uint32_t> buffer, typename B::template Mirror<std::uint32_t> mirror,
             typename B::template Readback<std::uint32_t> readback, Span<const std::uint32_t> values,
             Span<const Range> changes) {
  { buffer.capacity() } -> std::same_as<std::uint64_t>;
  mirror.follow(b, values, changes);
  { mirror.data() } -> std::same_as<const std::uint32_t*>;
  b.upload(buffer, values);
  { readback.read(b, buffer, std::uint64_t{}) } -> std::same_as<Span<const std::uint32_t>>;
  b.give_scratch_back();
};

/// Primitives of stages, enqueued in order. Lists are appended to as Appender says.
template <class B>
concept RunsStages = requires(B b, const char* label, Count count, Share share, probe::Functor f,
                              Appender<probe::Target> list, const std::uint64_t* offsets, const std::uint64_t* total) {
  b.run_once(label, f);
  b.for_each(label, count, f);
  b.for_each_append(label, count, f, list, list);
  b.for_each_search(label, count, f, list, list);
  b.for_each_work(label, count, offsets, total, f, list, list);
  b.for_each_work_filtered(label, count, offsets, total, share, f, list, list);
  b.for_each_part(label, count, f, list, list);
  b.for_each_part_filtered(label, count, f, list, list);
  b.concurrently(f, f);
};

/// Primitives that sort, scan or reduce values, enqueued like stages.
template <class B>
concept RunsOrders = requires(B b, const char* label, Count count, probe::Functor f, const std::uint32_t* values,
                              std::uint64_t* sums, std::uint32_t* bins, float* least,
                              typename B::template SortBuffer<std::uint64_t> keys,
                              typename B::template SortBuffer<std::uint32_t> items) {
  b.exclusive_scan(label, count, values, sums, sums);
  b.sort_keys(label, count, keys, int{});
  b.sort_pairs(label, count, keys, items, int{});
  b.histogram(label, count, bins, int{}, int{}, f);
  b.minimum(label, count, f, least);
};

/// A detection from its beginning to its results. launch() runs a callable that enqueues work, and may return early.
/// read() and finish() wait. mark_end() returns an event that others can wait for, or null if they need not. Session is
/// a query's memory on the backend.
template <class B>
concept RunsDetections = std::default_initializable<typename B::Session> &&
    requires(B b, const B& observed, typename B::Session session, const Signature& signature, probe::Functor f,
             Count count, typename B::template Buffer<Counters> counters,
             typename B::template Buffer<Contact> contacts) {
  { B::kKnowsCounts } -> std::convertible_to<bool>;
  { B::kHasPatches } -> std::convertible_to<bool>;
  b.begin_detection(session);
  b.begin(Stage::volumes);
  b.launch(signature, f);
  { b.read(counters) } -> std::same_as<Counters>;
  { b.mark_end() } -> std::same_as<void*>;
  b.download(counters, contacts, count, bool{});
  { b.finish() } -> std::same_as<Counters>;
  { b.contacts(std::uint64_t{}) } -> std::same_as<Span<const Contact>>;
  b.count_rerun();
  { observed.reruns() } -> std::same_as<std::uint64_t>;
  { observed.times() } -> std::convertible_to<const StageTimes&>;
};

template <class B>
concept DetectionBackend = HasMemory<B> && RunsStages<B> && RunsOrders<B> && RunsDetections<B>;

}  // namespace softcd
