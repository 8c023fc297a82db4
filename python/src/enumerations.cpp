#include "bindings.hpp"
#include "softcd/softcd.hpp"

namespace softcd::python {

namespace nb = nanobind;

void bind_enumerations(nb::module_& module) {
  nb::enum_<Backend>(module, "Backend", "Where detections run.")
      .value("automatic", Backend::automatic, "A GPU where there is a usable one, else the CPU.")
      .value("cpu", Backend::cpu)
      .value("cuda", Backend::cuda, "An NVIDIA GPU; an error where there is none, or when it fails.");
  nb::enum_<Detection>(module, "Detection", "What is compared.")
      .value("dcd", Detection::dcd, "Distances at one end of the step.")
      .value("ccd", Detection::ccd, "Straight-line motion from t0 to t1.");
  nb::enum_<Accuracy>(module, "Accuracy", "The narrow phase's arithmetic, and what it promises.")
      .value("fast", Accuracy::fast, "float32.")
      .value("precise", Accuracy::precise, "float64.")
      .value("conservative", Accuracy::conservative,
             "float64 that misses nothing within a margin along the way either, nor of float64 positions.")
      .value("automatic", Accuracy::automatic,
             "conservative where positions are float64, and in a continuous detection with margins; else precise.");
  nb::enum_<ContactRule>(module, "ContactRule", "What a vertex's margin is measured from.")
      .value("distance", ContactRule::distance, "The triangle.")
      .value("slab", ContactRule::slab, "Its plane, as in Bullet's deformable world.");
  nb::enum_<BroadPhase>(module, "BroadPhase", "How candidate pairs are found, none of which is ever lost.")
      .value("exact", BroadPhase::exact, "Virtual subdivision with exact control bits.")
      .value("uniform", BroadPhase::uniform, "One grid for the largest triangle: many more tests.");
  nb::enum_<StepEnd>(module, "StepEnd", "Which end of the step a discrete detection looks at.")
      .value("t1", StepEnd::t1)
      .value("t0", StepEnd::t0);
  nb::enum_<Pairs>(module, "Pairs", "Which pairs of bodies a detection compares.")
      .value("all", Pairs::all)
      .value("changed", Pairs::changed,
             "Those of which a body was added or updated, or given positions or settings, since the query's last "
             "detection.");
  nb::enum_<LogLevel>(module, "LogLevel")
      .value("information", LogLevel::information)
      .value("warning", LogLevel::warning);
  nb::enum_<ContactKind>(module, "ContactKind", nb::is_arithmetic(), "The values of the contacts' field `kind`.")
      .value("vertex_triangle", ContactKind::vertex_triangle)
      .value("edge_edge", ContactKind::edge_edge);
}

}  // namespace softcd::python
