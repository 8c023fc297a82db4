#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "softcd/core/host_device.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// A view of `size()` contiguous elements that somebody else owns. Trivially copyable, so it
/// travels as a kernel argument. C++17 stand-in for std::span on host and device.
template <class T>
class Span {
 public:
  /// Of no elements.
  constexpr Span() = default;
  /// Of the `size` elements from `data` on, which outlive it.
  SOFTCD_HD constexpr Span(T* data, std::size_t size) : data_(data), size_(size) {}

  /// From any container with contiguous data() and size() whose elements convert by qualification only.
  template <class Container, class Element = std::remove_pointer_t<decltype(std::declval<Container&>().data())>,
            class = std::enable_if_t<!std::is_same_v<std::remove_cv_t<std::remove_reference_t<Container>>, Span> &&
                                     std::is_convertible_v<Element (*)[], T (*)[]>>>
  constexpr Span(Container&& container)  // NOLINT(google-explicit-constructor,bugprone-forwarding-reference-overload)
      : data_(container.data()), size_(container.size()) {}

  /// The first element.
  SOFTCD_HD constexpr T* data() const { return data_; }
  /// How many elements there are.
  SOFTCD_HD constexpr std::size_t size() const { return size_; }
  /// Whether there are none.
  SOFTCD_HD constexpr bool empty() const { return size_ == 0; }
  /// An element; `index`, which is not checked, is below size().
  SOFTCD_HD constexpr T& operator[](std::size_t index) const { return data_[index]; }
  /// The first element, for loops over all of them.
  SOFTCD_HD constexpr T* begin() const { return data_; }
  /// Behind the last element.
  SOFTCD_HD constexpr T* end() const { return data_ + size_; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
