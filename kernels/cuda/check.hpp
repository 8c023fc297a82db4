#pragma once

#include <cuda_runtime_api.h>

namespace softcd {

/// Throws DeviceError, or std::bad_alloc when device memory ran out. The text names the failed operation, `what`.
/// Clears the error.
void check_cuda(cudaError_t status, const char* what);

}  // namespace softcd
