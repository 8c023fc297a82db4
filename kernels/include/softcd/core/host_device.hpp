#pragma once

/// Marks functions that run on the host and on CUDA devices.
#if defined(__CUDACC__)
#define SOFTCD_HD __host__ __device__
#else
#define SOFTCD_HD
#endif

/// SOFTCD_HD for a rarely called function: out of line on the host, where its callers' loops are faster without it. On
/// the device it stays inline, because a call would cost its callers registers.
#if defined(__CUDACC__)
#define SOFTCD_HD_SELDOM SOFTCD_HD
#elif defined(__GNUC__)
#define SOFTCD_HD_SELDOM __attribute__((noinline))
#elif defined(_MSC_VER)
#define SOFTCD_HD_SELDOM __declspec(noinline)
#else
#define SOFTCD_HD_SELDOM
#endif

/// SOFTCD_HD for a short function in a loop over vertices, which compilers would not inline by themselves on the host.
#if defined(__CUDACC__) || !defined(__GNUC__)
#define SOFTCD_HD_SHORT SOFTCD_HD inline
#else
#define SOFTCD_HD_SHORT __attribute__((always_inline)) inline
#endif

/// SOFTCD_HD for a function that is too long to be inlined at every call: out of line on the device, too.
#if defined(__CUDACC__)
#define SOFTCD_HD_LONG __host__ __device__ __noinline__
#else
#define SOFTCD_HD_LONG SOFTCD_HD_SELDOM
#endif

/// Stands before a loop of a rarely called function. Unrolled on the device, the loop would cost its callers registers.
#if defined(__CUDA_ARCH__)
#define SOFTCD_NOT_UNROLLED _Pragma("unroll 1")
#else
#define SOFTCD_NOT_UNROLLED
#endif
