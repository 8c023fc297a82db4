#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include "softcd/core/types.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Positions become float32 relative to the scene's origin, which moves along only where the whole scene is far away:
/// float positions stay as they are, double positions keep about 7 digits of the scene's extent, stray vertices
/// included. Accuracy::conservative uses these floats only to refuse pairs that are certain to be apart, and judges
/// contacts by the positions as they were given. A vertex with a coordinate beyond 1e37 counts as not finite.
///
/// `count` positions of three consecutive floats or doubles, `stride` bytes apart, aligned as their coordinates are.
/// The memory is read by the scene's next detection that is started, before that call returns or throws, and never
/// after: a body whose positions are not set again stays where it was, to the last digit of what was given. For
/// positions in a CUDA device's memory see on_device().
class Positions {
 public:
  /// None.
  Positions() = default;
  /// Of elements next to each other.
  Positions(Span<const Vec3f> positions)  // NOLINT(google-explicit-constructor)
      : Positions(positions.data() == nullptr ? nullptr : &positions.data()->x, positions.size(), sizeof(Vec3f)) {}
  /// Of elements next to each other.
  Positions(Span<const Vec3d> positions)  // NOLINT(google-explicit-constructor)
      : Positions(positions.data() == nullptr ? nullptr : &positions.data()->x, positions.size(), sizeof(Vec3d)) {}
  /// Of a container that is not temporary.
  Positions(const std::vector<Vec3f>& positions)  // NOLINT(google-explicit-constructor)
      : Positions(Span<const Vec3f>(positions)) {}
  /// Of a container that is not temporary.
  Positions(const std::vector<Vec3d>& positions)  // NOLINT(google-explicit-constructor)
      : Positions(Span<const Vec3d>(positions)) {}
  /// Any layout with x, y and z next to each other: `stride` bytes from one x to the next.
  Positions(const float* first_x, std::size_t count, std::size_t stride)
      : data_(first_x), count_(count), stride_(stride), is_double_(false) {}
  /// Any layout with x, y and z next to each other: `stride` bytes from one x to the next.
  Positions(const double* first_x, std::size_t count, std::size_t stride)
      : data_(first_x), count_(count), stride_(stride), is_double_(true) {}
  /// Positions in the memory of the scene's CUDA device, which go from there to where they are detected without passing
  /// the host. The memory is not copied: it must hold them, unchanged, until the body's positions are set again or the
  /// body is removed, and as long as a detection runs. `ready` is a cudaEvent_t after which they are there; what was
  /// enqueued on the device's legacy default stream when a detection starts is waited for as well.
  ///
  /// Where a vertex is not finite, or the CPU takes over, the host reads a copy. A scene that cannot use a device
  /// throws BackendError when such positions are set.
  static Positions on_device(const float* first_x, std::size_t count, std::size_t stride, void* ready = nullptr) {
    return Positions(first_x, count, stride).in_device_memory(ready);
  }
  /// The same for doubles.
  static Positions on_device(const double* first_x, std::size_t count, std::size_t stride, void* ready = nullptr) {
    return Positions(first_x, count, stride).in_device_memory(ready);
  }
  /// A temporary container would be gone before it is read. Containers hand on their constness to their elements,
  /// views do not.
  template <class Container,
            class = std::enable_if_t<!std::is_same_v<decltype(std::declval<Container&>().data()),
                                                     decltype(std::declval<const Container&>().data())>>>
  Positions(const Container&& positions) = delete;

  /// The first x.
  const void* data() const { return data_; }
  /// How many positions there are.
  std::size_t count() const { return count_; }
  /// Bytes from one x to the next.
  std::size_t stride() const { return stride_; }
  /// Whether coordinates are doubles, else floats.
  bool is_double() const { return is_double_; }
  /// Whether they are in the memory of a CUDA device.
  bool is_on_device() const { return is_on_device_; }
  /// A cudaEvent_t, or null.
  void* ready() const { return ready_; }

 private:
  Positions in_device_memory(void* ready) && {
    is_on_device_ = true;
    ready_ = ready;
    return *this;
  }

  const void* data_ = nullptr;
  std::size_t count_ = 0;
  std::size_t stride_ = 0;
  bool is_double_ = false;
  bool is_on_device_ = false;
  void* ready_ = nullptr;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
