#pragma once

/// SOFTCD_HD marks functions that run on the host and, under nvcc, on the device.
#if defined(__CUDACC__)
#define SOFTCD_HD __host__ __device__
#else
#define SOFTCD_HD
#endif
