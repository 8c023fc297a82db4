#include "bindings.hpp"
#include "fields.hpp"

namespace softcd::python {

void bind_statistics(nb::module_& module) {
  auto times = nb::class_<StageTimes>(module, "StageTimes", "Milliseconds spent per stage of a detection.");
  Fields<StageTimes>().define_read_only(times);
  auto statistics = nb::class_<Statistics>(module, "Statistics", "Counts and times of a detection.");
  Fields<Statistics>().define_read_only(statistics);
  auto report = nb::class_<StageReport>(module, "StageReport", "Whether a stage of a detection ran, and why.");
  Fields<StageReport>().define_read_only(report);
}

}  // namespace softcd::python
