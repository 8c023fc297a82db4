#pragma once

#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "softcd/softcd.hpp"

/// Structs as bytes in a plugin's answers and input. Python reads and writes them as structured arrays.
namespace softcd::bullet::pybullet {

/// A number that is not known, in answers.
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Returns the bytes of an array.
template <class Range>
std::string bytes_of(const Range& values) {
  using Value = std::remove_cv_t<std::remove_pointer_t<decltype(values.data())>>;
  static_assert(std::is_trivially_copyable_v<Value>);
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

/// Returns the values that the bytes are. Throws InvalidInput if they end within one.
template <class Value>
std::vector<Value> values_in(const std::string& bytes) {
  static_assert(std::is_trivially_copyable_v<Value>);
  if (bytes.size() % sizeof(Value) != 0) throw InvalidInput("softcd's plugin got input of a wrong size.");
  std::vector<Value> values(bytes.size() / sizeof(Value));
  if (!values.empty()) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
  return values;
}

}  // namespace softcd::bullet::pybullet
