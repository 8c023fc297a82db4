#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include "softcd/core/types.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// A view of `count` positions: three consecutive floats or doubles each, `stride` bytes apart, aligned as their
/// coordinates are. For positions in a CUDA device's memory see on_device().
///
/// **When they are read.** The scene's next detection reads the memory before the call that starts it returns or
/// throws, and never again. A body whose positions are not set again stays where it was, to the last digit.
///
/// **Precision.** Positions become float32, relative to the scene's origin. The origin moves only where the whole scene
/// is far away from it. Float positions therefore stay as they are. Double positions keep about 7 digits of the scene's
/// extent, stray vertices included. Accuracy::conservative uses these floats only to reject pairs that are certain to
/// be apart; it judges contacts by the positions as given. A vertex with a coordinate beyond 1e37 counts as not finite.
class Positions {
 public:
  /// Makes a view of no positions.
  Positions() = default;
  /// Views elements next to each other.
  Positions(Span<const Vec3f> positions)  // NOLINT(google-explicit-constructor)
      : Positions(positions.data() == nullptr ? nullptr : &positions.data()->x, positions.size(), sizeof(Vec3f)) {}
  /// Views elements next to each other.
  Positions(Span<const Vec3d> positions)  // NOLINT(google-explicit-constructor)
      : Positions(positions.data() == nullptr ? nullptr : &positions.data()->x, positions.size(), sizeof(Vec3d)) {}
  /// Views a container, which must not be temporary.
  Positions(const std::vector<Vec3f>& positions)  // NOLINT(google-explicit-constructor)
      : Positions(Span<const Vec3f>(positions)) {}
  /// Views a container, which must not be temporary.
  Positions(const std::vector<Vec3d>& positions)  // NOLINT(google-explicit-constructor)
      : Positions(Span<const Vec3d>(positions)) {}
  /// Views any layout with x, y and z next to each other, and `stride` bytes from one x to the next.
  Positions(const float* first_x, std::size_t count, std::size_t stride)
      : data_(first_x), count_(count), stride_(stride), is_double_(false) {}
  /// Views any layout with x, y and z next to each other, and `stride` bytes from one x to the next.
  Positions(const double* first_x, std::size_t count, std::size_t stride)
      : data_(first_x), count_(count), stride_(stride), is_double_(true) {}
  /// Views positions in the memory of the scene's CUDA device. The detection reads them there; they do not pass through
  /// the host.
  ///
  /// The memory is not copied. It must hold the positions, unchanged, while a detection runs, and until the body's
  /// positions are set again or the body is removed. `ready` is a cudaEvent_t after which the positions are there. A
  /// detection also waits for the work that was enqueued on the device's legacy default stream before the detection
  /// started.
  ///
  /// The host reads a copy where a vertex is not finite, or where the CPU replaces the device. Setting such positions
  /// throws BackendError in a scene that cannot use a device.
  static Positions on_device(const float* first_x, std::size_t count, std::size_t stride, void* ready = nullptr) {
    return Positions(first_x, count, stride).in_device_memory(ready);
  }
  /// Views doubles; otherwise the same as for floats.
  static Positions on_device(const double* first_x, std::size_t count, std::size_t stride, void* ready = nullptr) {
    return Positions(first_x, count, stride).in_device_memory(ready);
  }
  /// Rejects temporary containers, which would be destroyed before they are read. Containers pass their constness to
  /// their elements, views do not; this tells them apart.
  template <class Container,
            class = std::enable_if_t<!std::is_same_v<decltype(std::declval<Container&>().data()),
                                                     decltype(std::declval<const Container&>().data())>>>
  Positions(const Container&& positions) = delete;

  /// Returns a pointer to the first x.
  const void* data() const { return data_; }
  /// Returns the number of positions.
  std::size_t count() const { return count_; }
  /// Returns the number of bytes from one x to the next.
  std::size_t stride() const { return stride_; }
  /// Returns whether coordinates are doubles; else they are floats.
  bool is_double() const { return is_double_; }
  /// Returns whether the positions are in a CUDA device's memory.
  bool is_on_device() const { return is_on_device_; }
  /// Returns the cudaEvent_t after which the positions are there, or null.
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
