#include "softcd/pipeline/rank_link.hpp"

namespace softcd {

std::shared_ptr<RankLink> make_nccl_link(void* /*comm*/, void* /*stream*/, std::chrono::milliseconds /*patience*/) {
  return nullptr;
}

std::vector<std::shared_ptr<RankLink>> make_nccl_links(Span<const int> /*devices*/,
                                                       std::chrono::milliseconds /*patience*/) {
  return {};
}

const char* nccl_problem() {
  return "this build of softcd has no NCCL (nvcc or nccl.h was not found when it was configured); rebuild where they "
         "are, or set SOFTCD_NCCL_INCLUDE_DIR";
}

}  // namespace softcd
