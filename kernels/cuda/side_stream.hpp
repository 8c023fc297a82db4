#pragma once

#include <cuda_runtime_api.h>

#include "check.hpp"
#include "handles.hpp"

namespace softcd {

/// A second stream, for work that need not wait for what the first one is given meanwhile.
class SideStream {
 public:
  SideStream() = default;
  SideStream(const SideStream&) = delete;
  SideStream& operator=(const SideStream&) = delete;
  ~SideStream() { cudaStreamSynchronize(stream_.get()); }

  /// From its making on the side stream runs what follows, after what `main` was given so far, and at its end `main`
  /// waits for that. Whatever happens between: work must not be left behind on a stream that nobody waits for.
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
