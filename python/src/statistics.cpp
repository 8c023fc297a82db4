#include "bindings.hpp"
#include "fields.hpp"
#include "softcd/softcd.hpp"

namespace softcd::python {
namespace {

constexpr auto kStageTimes = fields_of<StageTimes>(
    Field{"total", &StageTimes::total}, Field{"volumes", &StageTimes::volumes},
    Field{"subdivision", &StageTimes::subdivision}, Field{"assignment", &StageTimes::assignment},
    Field{"sort", &StageTimes::sort}, Field{"tests", &StageTimes::tests}, Field{"features", &StageTimes::features},
    Field{"narrow", &StageTimes::narrow}, Field{"transfer", &StageTimes::transfer});

constexpr auto kStatistics = fields_of<Statistics>(
    Field{"backend", &Statistics::backend}, Field{"bodies", &Statistics::bodies},
    Field{"triangles", &Statistics::triangles}, Field{"vertices", &Statistics::vertices},
    Field{"edges", &Statistics::edges}, Field{"active_triangles", &Statistics::active_triangles},
    Field{"left_out_triangles", &Statistics::left_out_triangles}, Field{"mean_radius", &Statistics::mean_radius},
    Field{"cell_size", &Statistics::cell_size}, Field{"split_triangles", &Statistics::split_triangles},
    Field{"children", &Statistics::children}, Field{"big_triangles", &Statistics::big_triangles},
    Field{"entries", &Statistics::entries}, Field{"cells", &Statistics::cells}, Field{"tests", &Statistics::tests},
    Field{"reused_pairs", &Statistics::reused_pairs}, Field{"triangle_pairs", &Statistics::triangle_pairs},
    Field{"flagged_pairs", &Statistics::flagged_pairs}, Field{"vt_candidates", &Statistics::vt_candidates},
    Field{"ee_candidates", &Statistics::ee_candidates}, Field{"vt_contacts", &Statistics::vt_contacts},
    Field{"ee_contacts", &Statistics::ee_contacts}, Field{"unsettled_contacts", &Statistics::unsettled_contacts},
    Field{"earliest_toi", &Statistics::earliest_toi}, Field{"peak_bytes", &Statistics::peak_bytes},
    Field{"reruns", &Statistics::reruns}, Field{"chunks", &Statistics::chunks}, Field{"ms", &Statistics::ms});

constexpr auto kStageReport = fields_of<StageReport>(
    Field{"stage", &StageReport::stage}, Field{"ran", &StageReport::ran}, Field{"reason", &StageReport::reason});

}  // namespace

void bind_statistics(nb::module_& module) {
  auto times = nb::class_<StageTimes>(module, "StageTimes", "Milliseconds spent per stage of a detection.");
  kStageTimes.define_read_only(times);
  auto statistics = nb::class_<Statistics>(module, "Statistics", "Counts and times of a detection.");
  kStatistics.define_read_only(statistics);
  auto report = nb::class_<StageReport>(module, "StageReport", "Whether a stage of a detection ran, and why.");
  kStageReport.define_read_only(report);
}

}  // namespace softcd::python
