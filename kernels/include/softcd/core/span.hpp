#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "softcd/core/host_device.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// A view of `size()` contiguous elements that it does not own. Trivially copyable, so it can be a kernel argument.
/// Replaces std::span, which C++17 lacks, on host and device.
template <class T>
class Span {
 public:
  /// Makes a view of no elements.
  constexpr Span() = default;
  /// Makes a view of the `size` elements that start at `data`. They must outlive the view.
  SOFTCD_HD constexpr Span(T* data, std::size_t size) : data_(data), size_(size) {}

  /// Makes a view of any container with contiguous data() and size(). The elements may convert by qualification only.
  template <class Container, class Element = std::remove_pointer_t<decltype(std::declval<Container&>().data())>,
            class = std::enable_if_t<!std::is_same_v<std::remove_cv_t<std::remove_reference_t<Container>>, Span> &&
                                     std::is_convertible_v<Element (*)[], T (*)[]>>>
  constexpr Span(Container&& container)  // NOLINT(google-explicit-constructor,bugprone-forwarding-reference-overload)
      : data_(container.data()), size_(container.size()) {}

  /// Returns a pointer to the first element.
  SOFTCD_HD constexpr T* data() const { return data_; }
  /// Returns the number of elements.
  SOFTCD_HD constexpr std::size_t size() const { return size_; }
  /// Returns whether there are no elements.
  SOFTCD_HD constexpr bool empty() const { return size_ == 0; }
  /// Returns an element. `index` must be below size(); it is not checked.
  SOFTCD_HD constexpr T& operator[](std::size_t index) const { return data_[index]; }
  /// Returns a pointer to the first element, for range-based loops.
  SOFTCD_HD constexpr T* begin() const { return data_; }
  /// Returns a pointer behind the last element.
  SOFTCD_HD constexpr T* end() const { return data_ + size_; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
