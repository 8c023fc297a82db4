#include "backend_selection.hpp"

#include <fmt/format.h>

namespace softcd {

SelectedBackend select_backend(Backend wanted) {
  if (wanted == Backend::cpu) return {Backend::cpu, make_cpu_detector(), "the CPU was asked for"};
  const std::string problem = cuda_problem();
  if (problem.empty()) {
    return {Backend::cuda, make_cuda_detector(),
            wanted == Backend::cuda ? "CUDA was asked for" : "a CUDA device is usable"};
  }
  if (wanted == Backend::cuda) {
    throw BackendError(
        fmt::format("the CUDA backend cannot be used: {}. Use Backend::cpu or Backend::automatic.", problem));
  }
  return {Backend::cpu, make_cpu_detector(), fmt::format("CUDA cannot be used: {}", problem)};
}

}  // namespace softcd
