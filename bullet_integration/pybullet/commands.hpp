#pragma once

#include <istream>
#include <string>
#include <string_view>

#include "session.hpp"

namespace softcd::bullet::pybullet {

/// Returns whether a client of PyBullet can set the member of Settings. It cannot set callbacks. No command returns the
/// contacts of `read_out`. Exceptions of `on_error` would pass through PyBullet's server and end the process.
constexpr bool is_for_clients(std::string_view name) {
  return name != "on_contacts" && name != "log" && name != "read_out" && name != "on_error";
}

/// Reads words of the form name=value: enumerators by name, True and False, numbers. Throws InvalidInput.
Settings read_settings(std::istream& words);

/// Executes a plugin's command, as python/softcd/bullet.py sends it, and returns its result:
///
///     version           of PyBullet that this was built for
///     attach K=V K=V    see read_settings()
///     is_attached       0 or 1
///     limitations       one a line
///     finish_step
///     report            JSON
///     detach
///
/// Throws softcd::Error.
std::string execute(Session& session, PhysicsCommandProcessorInterface& server, std::string_view command);

}  // namespace softcd::bullet::pybullet
