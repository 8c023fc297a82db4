#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace softcd::test {

/// From now on, in this process: pthread_create fails with EAGAIN while `most` threads live that it has started.
/// Programs that use it compile few_threads.cpp, which replaces pthread_create.
void limit_threads(std::size_t most);

/// How many times it has failed so.
std::size_t refused_threads();

/// What `f` returns in a process of its own, where `most` threads can live beside the calling one. None where that
/// process has crashed, or taken more than a minute. This one must not have started threads yet.
std::optional<std::vector<std::byte>> with_few_threads(std::size_t most,
                                                       const std::function<std::vector<std::byte>()>& f);

}  // namespace softcd::test
