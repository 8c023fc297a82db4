#pragma once

namespace softcd::test {

/// Lets a kernel of this process run into a trap: from then on every call that needs the device's context fails, until
/// the process ends. Returns whether CUDA says so, too.
bool lose_cuda_context();

}  // namespace softcd::test
