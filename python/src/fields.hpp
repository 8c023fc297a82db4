#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <functional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

namespace softcd::python {

namespace nb = nanobind;

/// A member of a struct by the name that Python knows it by; `access` is a pointer to it, or a function that returns a
/// reference to it.
template <class Access>
struct Field {
  const char* name;
  Access access;
};
template <class Access>
Field(const char*, Access) -> Field<Access>;

template <class Struct, class Access>
using FieldValue = std::remove_cvref_t<std::invoke_result_t<const Access&, Struct&>>;

/// All members of a struct that Python sees.
template <class Struct, class... Access>
class Fields {
 public:
  explicit constexpr Fields(Field<Access>... fields) : fields_(fields...) {}

  /// Defines a function of `Leading...` and the fields as keyword arguments, which calls `function(leading...,
  /// struct)`. `extra` are the leading arguments' names, nb::kw_only() and the documentation.
  template <class... Leading, class Scope, class Function, class... Extra>
  void define(Scope& scope, const char* name, Function function, const Extra&... extra) const {
    Struct defaults{};
    std::apply(
        [&](const auto&... field) {
          scope.def(
              name,
              [function, *this](Leading... leading, FieldValue<Struct, Access>... values) {
                return function(std::forward<Leading>(leading)..., make(std::move(values)...));
              },
              extra..., (nb::arg(field.name) = std::invoke(field.access, defaults))...);
        },
        fields_);
  }

  /// A class with read-only attributes, a constructor of keywords, a repr, == and a hash.
  template <class Class>
  void define_value(Class& bound) const {
    define<Struct*>(
        bound, "__init__", [](Struct* self, const Struct& value) { new (self) Struct(value); }, nb::kw_only());
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
    for_each([&](const auto& field) {
      bound.def_prop_ro(field.name, [access = field.access](Struct& self) { return std::invoke(access, self); });
    });
    bound.def("__repr__", [*this](nb::handle self) { return repr(self); });
  }

  nb::dict as_dict(nb::handle self) const {
    nb::dict values;
    for_each([&](const auto& field) { values[field.name] = self.attr(field.name); });
    return values;
  }

 private:
  template <class Visit>
  void for_each(const Visit& visit) const {
    std::apply([&](const auto&... field) { (visit(field), ...); }, fields_);
  }

  Struct make(FieldValue<Struct, Access>... values) const {
    Struct result{};
    const auto in_order = std::forward_as_tuple(std::move(values)...);
    assign(result, in_order, std::index_sequence_for<Access...>());
    return result;
  }
  template <class Values, std::size_t... i>
  void assign(Struct& result, const Values& values, std::index_sequence<i...> /*all*/) const {
    ((std::invoke(std::get<i>(fields_).access, result) = std::get<i>(values)), ...);
  }

  std::string repr(nb::handle self) const {
    std::string text = nb::cast<std::string>(self.type().attr("__name__")) + "(";
    const char* separator = "";
    for_each([&](const auto& field) {
      const nb::object value = self.attr(field.name);
      const bool is_enumerator = std::is_enum_v<FieldValue<Struct, decltype(field.access)>>;
      text +=
          separator + (field.name + ("=" + nb::cast<std::string>(is_enumerator ? nb::str(value) : nb::repr(value))));
      separator = ", ";
    });
    return text + ")";
  }

  std::tuple<Field<Access>...> fields_;
};

template <class Struct, class... Access>
constexpr Fields<Struct, Access...> fields_of(Field<Access>... fields) {
  return Fields<Struct, Access...>(fields...);
}

}  // namespace softcd::python
