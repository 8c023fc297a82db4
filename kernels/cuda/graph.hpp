#pragma once

#include <cuda_runtime_api.h>

#include <utility>

#include "check.hpp"

namespace softcd {

/// A captured sequence of work, ready to launch.
class ExecutableGraph {
 public:
  ExecutableGraph() = default;
  /// Takes ownership of the graph.
  explicit ExecutableGraph(cudaGraph_t graph) {
    const cudaError_t status = cudaGraphInstantiate(&executable_, graph, 0);
    cudaGraphDestroy(graph);
    check_cuda(status, "instantiating a graph");
  }
  ExecutableGraph(ExecutableGraph&& other) noexcept : executable_(std::exchange(other.executable_, nullptr)) {}
  ExecutableGraph& operator=(ExecutableGraph&& other) noexcept {
    std::swap(executable_, other.executable_);
    return *this;
  }
  ~ExecutableGraph() {
    if (executable_ != nullptr) cudaGraphExecDestroy(executable_);
  }

  explicit operator bool() const { return executable_ != nullptr; }
  cudaGraphExec_t get() const { return executable_; }

 private:
  cudaGraphExec_t executable_ = nullptr;
};

/// Ends a capture that has begun, also after an exception: the caller's stream must not be left capturing.
class StreamCapture {
 public:
  explicit StreamCapture(cudaStream_t stream) : stream_(stream) {
    check_cuda(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), "capturing a graph");
  }
  StreamCapture(const StreamCapture&) = delete;
  StreamCapture& operator=(const StreamCapture&) = delete;
  ~StreamCapture() {
    if (stream_ == nullptr) return;
    cudaGraph_t graph = nullptr;
    cudaStreamEndCapture(stream_, &graph);
    if (graph != nullptr) cudaGraphDestroy(graph);
    cudaGetLastError();
  }

  ExecutableGraph finish() {
    cudaGraph_t graph = nullptr;
    check_cuda(cudaStreamEndCapture(std::exchange(stream_, nullptr), &graph), "capturing a graph");
    return ExecutableGraph(graph);
  }

 private:
  cudaStream_t stream_;
};

}  // namespace softcd
