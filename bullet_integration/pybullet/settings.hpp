#pragma once

#include <istream>
#include <string_view>

#include "softcd/bullet/settings.hpp"

namespace softcd::bullet::pybullet {

/// Whether a client of PyBullet can set the member of Settings. It cannot set callbacks; it has no command that returns
/// what `read_out` collects; exceptions of `on_error` would pass through PyBullet's server and end the process.
constexpr bool is_for_clients(std::string_view name) {
  return name != "on_contacts" && name != "log" && name != "read_out" && name != "on_error";
}

/// Reads words of the form name=value: enumerators by name, True and False, numbers. Throws InvalidInput.
Settings read_settings(std::istream& words);

}  // namespace softcd::bullet::pybullet
