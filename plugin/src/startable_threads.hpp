#pragma once

#include <cstddef>
#include <string>

namespace softcd {

/// Returns how many of `wanted` threads can live at once beside the existing ones. Ends all that it starts.
std::size_t count_startable_threads(std::size_t wanted);

/// Limits oneTBB to the number of threads that can be started, for the whole process and permanently. When oneTBB fails
/// to start a thread (2021.8), it waits for ever or ends the process. Call this before oneTBB is used; further calls do
/// nothing. Returns a warning from the call that set a limit, else an empty text.
std::string keep_to_startable_threads();

}  // namespace softcd
