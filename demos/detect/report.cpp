#include "report.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "command_line/choices.hpp"
#include "command_line/stage_times.hpp"
#include "command_line/statistics_json.hpp"

namespace softcd::demo {
namespace {

void write_file(const std::string& file, const std::string& content) {
  std::ofstream stream(file, std::ios::binary);
  stream << content;
  stream.close();
  if (!stream) throw std::runtime_error(fmt::format("{}: cannot be written (does its folder exist?)", file));
}

}  // namespace

void write_contacts(const std::string& file, Span<const Contact> contacts) {
  fmt::memory_buffer rows;
  const auto out = fmt::appender(rows);
  fmt::format_to(out, "kind,a0,a1,b0,b1,b2,toi,distance\n");
  for (const Contact& contact : contacts) {
    const auto& v = contact.vertices;
    if (contact.kind == ContactKind::vertex_triangle) {
      fmt::format_to(out, "vt,{},,{},{},{}", v[0], v[1], v[2], v[3]);
    } else {
      fmt::format_to(out, "ee,{},{},{},{},", v[0], v[1], v[2], v[3]);
    }
    fmt::format_to(out, ",{},{}\n", contact.time_of_impact, contact.distance);
  }
  write_file(file, fmt::to_string(rows));
}

void write_json(const DetectCommand& command, const Statistics& statistics) {
  nlohmann::ordered_json json = {{"t0", command.first_frame},
                                 {"t1", command.second_frame},
                                 {"repeat", command.repetitions},
                                 {"detection", name_of(kDetections, command.options.detection)},
                                 {"broad_phase", name_of(kBroadPhases, command.options.broad_phase)},
                                 {"accuracy", name_of(kAccuracies, command.options.accuracy)},
                                 {"margin", command.settings.margin},
                                 {"subdivision", command.options.subdivision},
                                 {"cell_size_factor", command.options.cell_size_factor},
                                 {"memory_limit", command.options.memory_limit}};
  add_statistics(json, statistics);
  // File names may hold any bytes.
  write_file(command.json_file, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

void print_summary(const DetectCommand& command, const Statistics& s) {
  fmt::print("mesh        {} triangles, {} vertices, {} edges\n", s.triangles, s.vertices, s.edges);
  fmt::print("detection   {}, {}, broad phase {}, on {}\n", name_of(kDetections, command.options.detection),
             name_of(kAccuracies, command.options.accuracy), name_of(kBroadPhases, command.options.broad_phase),
             name_of(kBackends, s.backend));
  fmt::print("grid        cell size {:.6g}, {} entries in {} cells, {} triangles split into {}, {} big\n", s.cell_size,
             s.entries, s.cells, s.split_triangles, s.children, s.big_triangles);
  fmt::print("candidates  {} tests, {} triangle pairs, {} vt, {} ee\n", s.tests, s.triangle_pairs, s.vt_candidates,
             s.ee_candidates);
  fmt::print("contacts    {} vt, {} ee", s.vt_contacts, s.ee_contacts);
  if (command.options.detection == Detection::ccd && s.vt_contacts + s.ee_contacts > 0) {
    fmt::print(", the first at {:.6g} of the step", s.earliest_toi);
  }
  fmt::print("\nmemory      {:.1f} MB at most\n", static_cast<double>(s.peak_bytes) / 1e6);
  fmt::print("time        {:.3f} ms", s.ms.total);
  if (command.repetitions > 0) fmt::print(", median of {}", command.repetitions);
  const char* separator = ": ";
  for (const StageTime& stage : kStageTimes) {
    if (stage.ms == &StageTimes::total) continue;
    fmt::print("{}{} {:.3f}", separator, stage.name, s.ms.*stage.ms);
    separator = ", ";
  }
  fmt::print("\n");
}

}  // namespace softcd::demo
