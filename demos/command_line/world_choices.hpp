#pragma once

#include "command_line/choices.hpp"
#include "scenes/soft_world.hpp"

namespace softcd::demo {

inline constexpr std::array<Choice<World>, 2> kWorlds = {{{"soft", World::classic}, {"deformable", World::deformable}}};

}  // namespace softcd::demo
