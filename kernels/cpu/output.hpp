#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>

#include "softcd/pipeline/output.hpp"

namespace softcd::cpu {

/// Collects a task's values, and reserves places for them in the shared list a block at a time.
template <class Target>
class Output {
 public:
  explicit Output(const Appender<Target>& list) : list_(list) {}
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  ~Output() { flush(); }

  void push(const typename Target::Value& value) {
    if (size_ == kBlock) flush();
    block_[size_++] = value;
  }

  /// Places for `count` values, written one after the other.
  class Room {
   public:
    explicit Room(Output& output) : output_(output) {}
    void put(const typename Target::Value& value) { output_.push(value); }

   private:
    Output& output_;
  };
  Room allocate(std::uint32_t /*count*/) { return Room(*this); }

 private:
  static constexpr std::uint64_t kBlock = 64;

  /// Returns the counter's value before.
  static std::uint64_t add(std::uint64_t& counter, std::uint64_t count) {
#ifdef __cpp_lib_atomic_ref
    return std::atomic_ref<std::uint64_t>(counter).fetch_add(count, std::memory_order_relaxed);
#else  // libc++ before 19
    return __atomic_fetch_add(&counter, count, __ATOMIC_RELAXED);
#endif
  }

  void flush() {
    const std::uint64_t at = add(*list_.count, size_);
    const std::uint64_t end = std::min(at + size_, list_.capacity);
    for (std::uint64_t i = at; i < end; ++i) list_.target.store(i, block_[i - at]);
    size_ = 0;
  }

  Appender<Target> list_;
  std::uint64_t size_ = 0;
  std::array<typename Target::Value, kBlock> block_;
};

}  // namespace softcd::cpu
