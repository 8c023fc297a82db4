#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>

#include "softcd/core/span.hpp"
#include "softcd/pipeline/detector.hpp"

namespace softcd {

/// The readers of an array's memory: only the host, or also CUDA devices, repeatedly.
enum class ArrayUse : bool { host, shared };

/// An array that detections read in place. More capacity is reserved in separate memory. A running detection thus keeps
/// its array, and the change that follows it cannot fail.
template <class T>
class HostArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  std::size_t size() const { return size_; }
  T* data() { return memory_.get(); }
  const T* data() const { return memory_.get(); }
  Span<const T> view() const { return {memory_.get(), size_}; }

  /// Makes memory that is reserved from now on accessible to CUDA devices, too.
  void share() { use_ = ArrayUse::shared; }

  /// Reserves capacity for `count` elements, and at least a quarter more than before, so that slow growth seldom
  /// reallocates.
  void reserve(std::size_t count) {
    if (count <= std::max(capacity_, room_capacity_)) return;
    const std::size_t before = std::max(capacity_, room_capacity_);
    const std::size_t capacity = std::max(count, before + before / 4);
    room_ = allocate(capacity, use_);
    room_capacity_ = capacity;
  }

  /// Changes the size to `count`, for which capacity is reserved. New elements are undefined.
  void resize(std::size_t count) noexcept {
    if (room_ != nullptr) {
      if (size_ > 0) std::memcpy(room_.get(), memory_.get(), size_ * sizeof(T));
      memory_ = std::move(room_);
      capacity_ = room_capacity_;
      room_capacity_ = 0;
    }
    size_ = count;
  }

 private:
  struct Free {
    ArrayUse use;
    void operator()(T* memory) const {
      if (use == ArrayUse::shared) {
        free_shared_memory(memory);
      } else {
        ::operator delete(memory);
      }
    }
  };
  using Memory = std::unique_ptr<T, Free>;

  static Memory allocate(std::size_t count, ArrayUse use) {
    if (use == ArrayUse::shared) {
      if (void* const memory = allocate_shared_memory(count * sizeof(T))) return Memory(static_cast<T*>(memory), {use});
    }
    return Memory(static_cast<T*>(::operator new(count * sizeof(T))), {ArrayUse::host});
  }

  ArrayUse use_ = ArrayUse::host;
  Memory memory_, room_;
  std::size_t size_ = 0, capacity_ = 0, room_capacity_ = 0;
};

}  // namespace softcd
