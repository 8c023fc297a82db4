#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "keywords.hpp"
#include "softcd/fields/options.hpp"

namespace softcd::python {

namespace nb = nanobind;

/// Whether Python has members of this type. It has no CUDA streams and no communicators.
template <class Value>
inline constexpr bool kIsSeen = !std::is_pointer_v<Value> && !std::is_same_v<Value, Communicator>;

/// All members of a struct that Python has.
template <class Struct>
class Fields {
 public:
  /// Defines a function of `Leading...` and the fields as keyword arguments, which calls
  /// `function(leading..., struct)`. `parameters` are the leading ones in Python's syntax, with `*` where keywords
  /// begin. `extra` are their names, and the documentation.
  template <class... Leading, class Scope, class Function, class... Extra>
  void define(Scope& scope, const char* name, const char* parameters, const char* result, Function function,
              const Extra&... extra) const {
    const bool is_constructor = std::string_view(name) == "__init__";
    const std::string shown = is_constructor ? nb::cast<std::string>(scope.attr("__name__")) : name;
    const std::string signature =
        std::string("def ") + name + "(self, " + parameters + parameters_of_fields() + ") -> " + result;
    scope.def(
        name,
        [function, shown, parameters, *this](Leading... leading, const nb::kwargs& values) {
          return function(std::forward<Leading>(leading)..., read(shown, parameters, values));
        },
        extra..., nb::arg("settings"), nb::sig(signature.c_str()));
  }

  /// A class with read-only attributes, a constructor of keywords, a repr, == and a hash.
  template <class Class>
  void define_value(Class& bound) const {
    define<Struct*>(bound, "__init__", "*", "None",
                    [](Struct* self, const Struct& value) { new (self) Struct(value); });
    define_read_only(bound);
    bound.def(
        "__eq__", [](const Struct& a, const Struct& b) { return a == b; }, nb::is_operator(),
        nb::sig("def __eq__(self, other: object, /) -> bool"));
    bound.def("__hash__", [*this](nb::handle self) { return nb::hash(nb::tuple(as_dict(self).attr("values")())); });
    bound.def(
        "replace",
        [*this](nb::handle self, const nb::kwargs& changes) {
          nb::dict values = as_dict(self);
          values.update(changes);
          return self.type()(**values);
        },
        nb::sig("def replace(self, **changes: object) -> typing.Self"), "A copy with other values.");
  }

  template <class Class>
  void define_read_only(Class& bound) const {
    for_each([&](auto field, const char* name) {
      const auto get = [field](Struct& self) { return field.of(self); };
      if constexpr (field.kHelp != nullptr) {
        bound.def_prop_ro(name, get, field.kHelp);
      } else {
        bound.def_prop_ro(name, get);
      }
    });
    bound.def("__repr__", [*this](nb::handle self) { return repr(self); });
    // For pickle and copy.
    bound.def("__getstate__", [*this](nb::handle self) { return as_dict(self); });
    bound.def("__setstate__", [*this](Struct& self, const nb::dict& values) {
      new (&self) Struct{};
      for_each([&](auto field, const char* name) {
        using Value = typename decltype(field)::Value;
        if (values.contains(name)) field.of(self) = nb::cast<Value>(values[name]);
      });
    });
  }

  nb::dict as_dict(nb::handle self) const {
    nb::dict values;
    for_each([&](auto /*field*/, const char* name) { values[name] = self.attr(name); });
    return values;
  }

 private:
  template <class Visit>
  void for_each(const Visit& visit) const {
    for_each_field<Struct>([&](auto field) {
      if constexpr (kIsSeen<typename decltype(field)::Value>) visit(field, field.kName);
    });
  }

  /// Returns ", margin: float = 0.0" and so on.
  std::string parameters_of_fields() const {
    Struct defaults{};
    std::string text;
    for_each([&](auto field, const char* name) {
      using Value = typename decltype(field)::Value;
      // The generator of stubs takes an enumerator's class for a module.
      std::string value = "...";
      if constexpr (!std::is_enum_v<Value>) {
        value = nb::cast<std::string>(nb::repr(nb::cast(Value(field.of(defaults)))));
      }
      text += std::string(", ") + name + ": " + type_name<Value>() + " = " + value;
    });
    return text;
  }

  Struct read(const std::string& function, const char* parameters, const nb::kwargs& values) const {
    Struct result{};
    std::size_t known = 0;
    for_each([&](auto field, const char* name) {
      if (!values.contains(name)) return;
      ++known;
      using Value = typename decltype(field)::Value;
      field.of(result) = read_value<Value>(name, values[name]);
    });
    if (known < values.size()) refuse_unknown(function, parameters, values);
    return result;
  }
  void refuse_unknown(const std::string& function, const char* parameters, const nb::kwargs& values) const {
    std::vector<std::string> names;
    for_each([&](auto /*field*/, const char* name) { names.emplace_back(name); });
    for (const auto& [keyword, value] : values) {
      if (std::find(names.begin(), names.end(), nb::cast<std::string>(keyword)) != names.end()) continue;
      // The leading parameters behind the star: "*, log: Type = None".
      const std::string_view keywords = std::string_view(parameters).substr(std::string_view(parameters).find('*'));
      for (std::size_t end = 0; (end = keywords.find(':', end + 1)) != std::string_view::npos;) {
        const std::size_t begin = keywords.rfind(' ', end) + 1;
        names.emplace_back(keywords.substr(begin, end - begin));
      }
      refuse_keyword(function, keyword, names);
    }
  }

  std::string repr(nb::handle self) const {
    std::string text = nb::cast<std::string>(self.type().attr("__name__")) + "(";
    const char* separator = "";
    for_each([&](auto field, const char* name) {
      const nb::object value = self.attr(name);
      const bool is_enumerator = std::is_enum_v<typename decltype(field)::Value>;
      text += separator + (name + ("=" + nb::cast<std::string>(is_enumerator ? nb::str(value) : nb::repr(value))));
      separator = ", ";
    });
    return text + ")";
  }
};

}  // namespace softcd::python
