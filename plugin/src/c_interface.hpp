#pragma once

#include <optional>

#include "softcd/softcd.h"
#include "softcd/softcd.hpp"

// Shared by the functions of softcd.h: handles, and the conversion of exceptions to error codes.

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

/// Returns the error code of the exception that is being handled. Its text becomes softcd_last_error().
softcd_status report_exception() noexcept;

/// Calls f. Lets no exception escape.
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

/// Returns the place for a result, which it sets to 0 first.
template <class T>
T& result(T* pointer, const char* argument) {
  return required(pointer, argument) = T{};
}

/// Returns the caller's struct, whose struct_size it checks.
template <class Struct>
Struct& sized(Struct* pointer, const char* argument) {
  Struct& found = required(pointer, argument);
  if (found.struct_size != sizeof(Struct)) refuse_size(argument, found.struct_size, sizeof(Struct));
  return found;
}

/// Returns the caller's struct for results, which it sets to 0 first.
template <class Struct>
Struct& sized_result(Struct* pointer, const char* argument) {
  Struct& found = sized(pointer, argument);
  found = {};
  found.struct_size = sizeof(Struct);
  return found;
}

/// Implements ..._init(): writes `defaults` for a caller whose struct has `size` bytes.
template <class Struct>
softcd_status initialize(Struct* pointer, std::uint64_t size, const char* argument, const Struct& defaults) noexcept {
  return guarded_call([&] {
    Struct& out = required(pointer, argument);
    if (size != sizeof(Struct)) refuse_size(argument, size, sizeof(Struct));
    out = defaults;
  });
}

/// Returns the caller's array of `count` elements.
template <class Mine, class Theirs>
Span<const Mine> elements(const Theirs* first, std::uint64_t count, const char* argument) {
  static_assert(sizeof(Mine) == sizeof(Theirs) && alignof(Mine) <= alignof(Theirs));
  if (count > 0) required(first, argument);
  return {reinterpret_cast<const Mine*>(first), static_cast<std::size_t>(count)};
}

/// Returns the caller's array of `count` elements that consist of several scalars each.
template <class Row, class Scalar>
Span<const Row> rows(const Scalar* first, std::uint64_t count, const char* argument) {
  static_assert(sizeof(Row) % sizeof(Scalar) == 0 && alignof(Row) == alignof(Scalar));
  if (count > 0) required(first, argument);
  return {reinterpret_cast<const Row*>(first), static_cast<std::size_t>(count)};
}

}  // namespace softcd::c_interface
