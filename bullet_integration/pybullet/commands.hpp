#pragma once

#include <string>
#include <string_view>

#include "session.hpp"

namespace softcd::bullet::pybullet {

/// What a plugin's command does, as python/softcd/bullet.py gives them, and its answer:
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
