#include "paper/detector.hpp"

#include "cpu_backend.hpp"
#include "paper/cuda_detector.hpp"
#include "paper/scheme.hpp"
#include "softcd/pipeline/detector_on.hpp"

namespace softcd::paper {

DetectorFactories detector_factories(const SceneOptions& options) {
  DetectorFactories factories = machine_factories(options);
  factories.make_cpu = [] { return std::make_unique<DetectorOn<CpuBackend, Scheme>>(); };
  if (factories.make_device) factories.make_device = cuda_detector_factory(options.cuda_stream);
  return factories;
}

}  // namespace softcd::paper
