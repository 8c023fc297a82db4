#pragma once

#include <cstddef>
#include <string>

namespace softcd {

/// So many of `wanted` threads can live at once beside those that there are. None of them lives on.
std::size_t count_startable_threads(std::size_t wanted);

/// Has oneTBB take no more threads than can be started, in the whole process and for good. It waits for ever once it
/// has failed to start one (2021.8), or ends the process. To be called before it is used, any number of times. What is
/// to be warned of is returned by the call that has found it out, and is empty else.
std::string keep_to_startable_threads();

}  // namespace softcd
