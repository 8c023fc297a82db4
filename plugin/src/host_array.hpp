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

/// Who reads an array's memory: the host, or CUDA devices, too, again and again.
enum class ArrayUse : bool { host, shared };

/// Elements that detections read where they are. Room for more is taken ahead and apart from them, so that what runs
/// keeps its array, and what is done once nothing runs cannot fail.
template <class T>
class HostArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  std::size_t size() const { return size_; }
  T* data() { return memory_.get(); }
  const T* data() const { return memory_.get(); }
  Span<const T> view() const { return {memory_.get(), size_}; }

  /// Memory that is taken from now on is a CUDA device's, too.
  void share() { use_ = ArrayUse::shared; }

  /// Takes room for `count` elements, and for a quarter more than there was, so that growing slowly is seldom done.
  void reserve(std::size_t count) {
    if (count <= std::max(capacity_, room_capacity_)) return;
    const std::size_t before = std::max(capacity_, room_capacity_);
    const std::size_t capacity = std::max(count, before + before / 4);
    room_ = allocate(capacity, use_);
    room_capacity_ = capacity;
  }

  /// Now has `count` elements, of which room is taken; those beyond the ones that there were are undefined.
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
