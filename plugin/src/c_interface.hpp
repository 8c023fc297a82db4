#pragma once

#include <optional>

#include "softcd/softcd.h"
#include "softcd/softcd.hpp"

// What the functions of softcd.h share: handles, and the way from exceptions to error codes.

// NOLINTBEGIN(readability-identifier-naming): softcd.h has their names.
struct softcd_scene {
  softcd::Scene scene;
};
struct softcd_query {
  softcd::Query query;
  std::optional<softcd::Ticket> ticket;  ///< of the detection that was started last
};
struct softcd_probe {
  softcd::Probe probe;
};
// NOLINTEND(readability-identifier-naming)

namespace softcd::c_interface {

/// The error code of the exception that is being handled, whose text becomes softcd_last_error().
softcd_status report_exception() noexcept;

/// Calls f. No exception leaves it.
template <class F>
softcd_status guarded_call(const F& f) noexcept {
  try {
    f();
    return SOFTCD_OK;
  } catch (...) {
    return report_exception();
  }
}

[[noreturn]] void refuse_null(const char* argument);
[[noreturn]] void refuse_size(const char* argument, std::uint64_t size, std::size_t expected);
[[noreturn]] void refuse_choice(const char* argument, std::uint32_t value, std::uint32_t last);

template <class T>
T& required(T* pointer, const char* argument) {
  if (pointer == nullptr) refuse_null(argument);
  return *pointer;
}

/// Where a result goes, 0 until there is one.
template <class T>
T& result(T* pointer, const char* argument) {
  return required(pointer, argument) = T{};
}

/// A struct of the caller's that says how large it is.
template <class Struct>
Struct& sized(Struct* pointer, const char* argument) {
  Struct& found = required(pointer, argument);
  if (found.struct_size != sizeof(Struct)) refuse_size(argument, found.struct_size, sizeof(Struct));
  return found;
}

/// A struct of the caller's that results go to, 0 until there are some.
template <class Struct>
Struct& sized_result(Struct* pointer, const char* argument) {
  Struct& found = sized(pointer, argument);
  found = {};
  found.struct_size = sizeof(Struct);
  return found;
}

/// For ..._init(): `defaults` for a caller whose struct has `size` bytes.
template <class Struct>
softcd_status initialize(Struct* pointer, std::uint64_t size, const char* argument, const Struct& defaults) noexcept {
  return guarded_call([&] {
    Struct& out = required(pointer, argument);
    if (size != sizeof(Struct)) refuse_size(argument, size, sizeof(Struct));
    out = defaults;
  });
}

/// `count` questions, or elements of another array of the caller's.
template <class Mine, class Theirs>
Span<const Mine> elements(const Theirs* first, std::uint64_t count, const char* argument) {
  static_assert(sizeof(Mine) == sizeof(Theirs) && alignof(Mine) <= alignof(Theirs));
  if (count > 0) required(first, argument);
  return {reinterpret_cast<const Mine*>(first), static_cast<std::size_t>(count)};
}

/// `count` elements of several scalars each.
template <class Row, class Scalar>
Span<const Row> rows(const Scalar* first, std::uint64_t count, const char* argument) {
  static_assert(sizeof(Row) % sizeof(Scalar) == 0 && alignof(Row) == alignof(Scalar));
  if (count > 0) required(first, argument);
  return {reinterpret_cast<const Row*>(first), static_cast<std::size_t>(count)};
}

}  // namespace softcd::c_interface
