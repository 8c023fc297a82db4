#include "bindings.hpp"
#include "softcd/fields/options.hpp"
#include "softcd/intersection_regions.hpp"

namespace softcd::python {

namespace nb = nanobind;

namespace {

/// Defines an enumeration. `descriptions` are those of its values, in their order; null where the names suffice.
template <class Enum, std::uint32_t kCount, class... Kind>
void bind(nb::module_& module, const char* name, const char* description, const char* const (&descriptions)[kCount],
          Kind... kind) {
  static_assert(kCount == kEnumerators<Enum>.size());
  nb::enum_<Enum> bound(module, name, kind..., description);
  for (std::uint32_t i = 0; i < kCount; ++i) {
    bound.value(kEnumerators<Enum>[i], static_cast<Enum>(i), descriptions[i]);
  }
}

}  // namespace

void bind_enumerations(nb::module_& module) {
  bind<Backend>(module, "Backend", "The processor that computes detections.",
                {"A GPU where a usable one exists, else the CPU.", nullptr,
                 "An NVIDIA GPU; an error where none exists, or when it fails."});
  bind<Detection>(module, "Detection", "The compared motion.",
                  {"Distances at one end of the step.", "Straight-line motion from t0 to t1."});
  bind<Accuracy>(
      module, "Accuracy", "The narrow phase's arithmetic, and what it guarantees.",
      {"float32.", "float64.",
       "float64 that finds everything that comes within a margin, also along the path, and for float64 positions as "
       "given.",
       "conservative where positions are float64, and in a continuous detection with margins; else precise."});
  bind<ContactRule>(module, "ContactRule", "The surface from which a vertex's margin is measured.",
                    {"The triangle.", "Its plane, as in Bullet's deformable world.",
                     "The triangle, if it lies ahead, as in Bullet's classic worlds."});
  bind<BroadPhase>(
      module, "BroadPhase", "How candidate pairs are found. No choice ever loses one.",
      {"Virtual subdivision with exact control bits.", "One grid for the largest triangle: many more tests."});
  bind<StepEnd>(module, "StepEnd", "The end of the step that a discrete detection uses.", {nullptr, nullptr});
  bind<DetectionStage>(
      module, "DetectionStage", "The parts of a detection on which explain() reports, in the order of time.",
      {"The choice of the processor.", "Bodies that have no positions yet.", "The choice of the bodies that may touch.",
       "The division among ranks.", "Bounding volumes of moving triangles.",
       "The division of triangles that are larger than a cell.", "The search for pairs of triangles.",
       "Triangles that would need too many cells.", "Pairs that are tested in parts, so that memory suffices.",
       "The choice of the narrow phase's arithmetic.", nullptr, nullptr, "The search for the first time of contact.",
       "The choice of the contacts that a solver gets."});
  bind<Pairs>(module, "Pairs", "The pairs of bodies that a detection compares.",
              {nullptr,
               "Pairs with a body that was added or updated, or given positions or settings, since the query's last "
               "detection."});
  bind<LogLevel>(module, "LogLevel", nullptr, {nullptr, nullptr});
  bind<ContactKind>(module, "ContactKind", "The values of the contacts' field `kind`.", {nullptr, nullptr},
                    nb::is_arithmetic());
  bind<RegionKind>(module, "RegionKind", "The values of the field `kind` of regions.",
                   {"Closed curves bound it, or nothing: it is whole inside a closed body.",
                    "Curves and the surface's border bound it.",
                    "Nothing bounds it: the curve does not separate the surface.", "No side follows from its curves."},
                   nb::is_arithmetic());
}

}  // namespace softcd::python
