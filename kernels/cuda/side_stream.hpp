#pragma once

#include <cuda_runtime_api.h>

#include "check.hpp"
#include "handles.hpp"

namespace softcd {

/// A second stream, for work that can run beside the work of the first one.
class SideStream {
 public:
  SideStream() = default;
  SideStream(const SideStream&) = delete;
  SideStream& operator=(const SideStream&) = delete;
  ~SideStream() { cudaStreamSynchronize(stream_.get()); }

  /// Starts work on the side stream after everything that was enqueued on `main` so far. At its end, `main` waits for
  /// the side stream. This also holds after an exception: no work must be left on a stream that no other stream waits
  /// for.
  class Fork {
   public:
    Fork(SideStream& side, cudaStream_t main) : side_(side), main_(main) {
      check_cuda(cudaEventRecord(side_.forked_.get(), main_), "forking a stream");
      check_cuda(cudaStreamWaitEvent(side_.stream_.get(), side_.forked_.get(), 0), "forking a stream");
    }
    Fork(const Fork&) = delete;
    Fork& operator=(const Fork&) = delete;
    ~Fork() {
      if (!is_joined_) join_streams();
    }

    void join() {
      is_joined_ = true;
      check_cuda(join_streams(), "joining streams");
    }
    cudaStream_t stream() const { return side_.stream_.get(); }

   private:
    cudaError_t join_streams() {
      const cudaError_t status = cudaEventRecord(side_.joined_.get(), side_.stream_.get());
      return status == cudaSuccess ? cudaStreamWaitEvent(main_, side_.joined_.get(), 0) : status;
    }

    SideStream& side_;
    cudaStream_t main_;
    bool is_joined_ = false;
  };

 private:
  Stream stream_{cudaStreamNonBlocking};
  Event forked_{cudaEventDisableTiming};
  Event joined_{cudaEventDisableTiming};
};

}  // namespace softcd
