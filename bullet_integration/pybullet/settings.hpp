#pragma once

#include <istream>
#include <string>
#include <string_view>

#include "softcd/bullet/settings.hpp"

/// Settings as words that a client of PyBullet sends, and as JSON that it gets.
namespace softcd::bullet::pybullet {

/// Returns whether a client can set this member of Settings. It cannot set callbacks: contacts and messages are read by
/// commands instead. With `on_error`, exceptions would pass through PyBullet's server and end the process.
constexpr bool is_for_clients(std::string_view name) {
  return name != "on_contacts" && name != "log" && name != "on_error";
}

/// Reads words of the form name=value, and changes these settings. Values are enumerators by name, True, False, and
/// numbers. preset=fast, balanced or safe replaces all settings of clients; it comes first. Throws InvalidInput.
Settings read_settings(std::istream& words, Settings settings = {});

/// Returns the client's settings: {"backend": "automatic", "reuse_pairs": true, "cell_size_factor": 0, ...}.
std::string json_of(const Settings& settings);

/// Returns all settings of clients by name, each with its allowed words and its value in each preset:
/// {"detection": {"values": ["dcd", "ccd"], "fast": "dcd", "balanced": "dcd", "safe": "ccd"}, ...}. Flags and numbers
/// have no "values".
std::string json_of_all_settings();

}  // namespace softcd::bullet::pybullet
