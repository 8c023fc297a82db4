#pragma once

#include <nanobind/nanobind.h>

#include <limits>
#include <string>
#include <type_traits>
#include <vector>

/// Reads the values of keyword arguments one by one, so that an error can name the argument.
namespace softcd::python {

namespace nb = nanobind;

/// Returns the member of an enumeration, a Python class, that `value` is or names. Throws nb::type_error or
/// InvalidInput; the text begins with `name`.
nb::object read_enumerator(const char* name, nb::handle enumeration, nb::handle value);

template <class Enum>
Enum read_enumerator(const char* name, nb::handle value) {
  return nb::cast<Enum>(read_enumerator(name, nb::type<Enum>(), value));
}

/// Throws nb::type_error: `function` has no keyword `keyword`. The text names the most similar one of `known`.
[[noreturn]] void refuse_keyword(const std::string& function, nb::handle keyword,
                                 const std::vector<std::string>& known);

[[noreturn]] void refuse_type(const char* name, const std::string& expected, nb::handle value);

/// Returns the name of a value's type in annotations.
template <class Value>
std::string type_name() {
  if constexpr (std::is_enum_v<Value>) {
    return nb::cast<std::string>(nb::type<Value>().attr("__name__")) + " | str";
  } else if constexpr (std::is_same_v<Value, bool>) {
    return "bool";
  } else {
    return std::is_integral_v<Value> ? "int" : "float";
  }
}

/// Returns the name of a value's type in errors.
template <class Value>
std::string expected_type() {
  std::string name = type_name<Value>();
  if constexpr (std::is_integral_v<Value> && !std::is_same_v<Value, bool>) {
    using Limits = std::numeric_limits<Value>;
    name += " from " + std::to_string(Limits::min()) + " to " + std::to_string(Limits::max());
  }
  return name;
}

/// Reads a value. Throws the exceptions of read_enumerator().
template <class Value>
Value read_value(const char* name, nb::handle object) {
  if constexpr (std::is_enum_v<Value>) {
    return read_enumerator<Value>(name, object);
  } else {
    Value value{};
    if (!nb::try_cast(object, value)) refuse_type(name, expected_type<Value>(), object);
    return value;
  }
}

}  // namespace softcd::python
