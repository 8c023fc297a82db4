#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace softcd::test {

/// From now on, lets pthread_create in this process fail with EAGAIN while `most` threads live that it has started.
/// Programs that use it compile few_threads.cpp, which replaces pthread_create.
void limit_threads(std::size_t most);

/// Returns how often it has failed for this reason.
std::size_t refused_threads();

/// Returns the result of `f` in a process of its own, where `most` threads can live beside the calling one. Returns
/// none if that process crashed, or took more than a minute. This process must not have started threads yet.
std::optional<std::vector<std::byte>> with_few_threads(std::size_t most,
                                                       const std::function<std::vector<std::byte>()>& f);

}  // namespace softcd::test
