#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd {

/// Bytes of one position.
inline std::size_t position_size(const Positions& positions) {
  return positions.is_double() ? sizeof(Vec3d) : sizeof(Vec3f);
}

/// A body's positions at both ends of a step: the caller's memory until they are read, then a copy of them, bit for
/// bit, so that every detection starts from what the caller gave.
class BodyPositions {
 public:
  bool are_set() const { return are_set_; }
  bool are_double() const { return are_double_; }
  /// False where both ends are one and the same array.
  bool have_two_ends() const { return have_two_ends_; }

  /// Takes ends of one type and length. Changes nothing when it throws std::bad_alloc.
  void set(const Positions& x_t0, const Positions& x_t1) {
    const bool is_one = x_t0.data() == x_t1.data() && (x_t0.stride() == x_t1.stride() || x_t1.count() < 2);
    const std::size_t bytes = x_t1.count() * position_size(x_t1);
    copy_t1_.reserve(bytes);
    if (!is_one) copy_t0_.reserve(bytes);
    copy_t1_.resize(bytes);
    if (!is_one) copy_t0_.resize(bytes);
    t0_ = x_t0;
    t1_ = x_t1;
    have_two_ends_ = !is_one;
    are_double_ = x_t1.is_double();
    are_set_ = true;
    are_read_ = false;
  }

  /// Copies the vertices [begin, end), unless all are read already.
  void read(std::size_t begin, std::size_t end) {
    if (are_read_) return;
    copy(t1_, begin, end, copy_t1_);
    if (have_two_ends_) copy(t0_, begin, end, copy_t0_);
  }
  /// Every vertex was read: the caller's memory is not looked at any more.
  void finish_reading() {
    are_read_ = true;
    t0_ = t1_ = Positions();
  }

  /// Of a vertex that was read; T is double where are_double(), else float.
  template <class T>
  Vec3d t0(std::size_t vertex) const {
    return load<T>(have_two_ends_ ? copy_t0_ : copy_t1_, vertex);
  }
  template <class T>
  Vec3d t1(std::size_t vertex) const {
    return load<T>(copy_t1_, vertex);
  }

 private:
  static void copy(const Positions& from, std::size_t begin, std::size_t end, std::vector<std::byte>& to) {
    if (from.is_double()) {
      copy<sizeof(Vec3d)>(from, begin, end, to);
    } else {
      copy<sizeof(Vec3f)>(from, begin, end, to);
    }
  }

  template <std::size_t kSize>
  static void copy(const Positions& from, std::size_t begin, std::size_t end, std::vector<std::byte>& to) {
    const auto* const data = static_cast<const std::byte*>(from.data());
    for (std::size_t i = begin; i < end; ++i) std::memcpy(to.data() + i * kSize, data + i * from.stride(), kSize);
  }

  template <class T>
  static Vec3d load(const std::vector<std::byte>& copies, std::size_t vertex) {
    T x[3];
    std::memcpy(x, copies.data() + vertex * sizeof(x), sizeof(x));
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
  }

  Positions t0_, t1_;
  std::vector<std::byte> copy_t0_, copy_t1_;
  bool are_set_ = false;
  bool are_read_ = false;
  bool are_double_ = false;
  bool have_two_ends_ = false;
};

}  // namespace softcd
