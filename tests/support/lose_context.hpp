#pragma once

namespace softcd::test {

/// Lets a kernel of this process run into a trap. From then on every call that needs the device's context fails, until
/// the process ends. Returns whether CUDA reports that, too.
bool lose_cuda_context();

}  // namespace softcd::test
