#pragma once

#include "command_line/choices.hpp"
#include "scenes/soft_world.hpp"

namespace softcd::demo {

inline constexpr std::array<Choice<World>, 2> kWorlds = {{{"soft", World::classic}, {"deformable", World::deformable}}};
inline constexpr std::array<Choice<bullet::Contacts>, 3> kContacts = {
    {{"all", bullet::Contacts::all},
     {"closest-feature", bullet::Contacts::closest_feature},
     {"automatic", bullet::Contacts::automatic}}};
static_assert(kContacts.size() == kEnumerators<bullet::Contacts>.size());

}  // namespace softcd::demo
