#include "keywords.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "softcd/error.hpp"

namespace softcd::python {
namespace {

std::string joined(nb::handle names) {
  return nb::cast<std::string>(nb::str(", ").attr("join")(names));
}

}  // namespace

nb::object read_enumerator(const char* name, nb::handle enumeration, nb::handle value) {
  if (value.type().is(enumeration)) return nb::borrow(value);
  const nb::object members = enumeration.attr("__members__");
  if (!nb::isinstance<nb::str>(value)) {
    refuse_type(name, nb::cast<std::string>(enumeration.attr("__name__")) + " or the name of one", value);
  }
  const nb::object found = members.attr("get")(value);
  if (found.is_none()) {
    throw InvalidInput(std::string(name) + ": expected one of " + joined(members) + ", got " +
                       nb::cast<std::string>(nb::repr(value)));
  }
  return found;
}

void refuse_keyword(const std::string& function, nb::handle keyword, const std::vector<std::string>& known) {
  const nb::object names = nb::cast(known);
  const nb::object like = nb::module_::import_("difflib").attr("get_close_matches")(keyword, names, 1);
  const bool is_like_one = nb::len(like) > 0;
  const std::string text = function + "(): there is no keyword " + nb::cast<std::string>(nb::repr(keyword)) +
                           (is_like_one ? "; did you mean " + nb::cast<std::string>(nb::repr(like[0])) + "?"
                                        : "; there are " + joined(names) + ".");
  throw nb::type_error(text.c_str());
}

void refuse_type(const char* name, const std::string& expected, nb::handle value) {
  const std::string text =
      std::string(name) + ": expected " + expected + ", got " + nb::cast<std::string>(nb::repr(value));
  throw nb::type_error(text.c_str());
}

}  // namespace softcd::python
