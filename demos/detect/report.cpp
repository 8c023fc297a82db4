#include "report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <type_traits>

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

constexpr mesh_tools::Rgb kColours[] = {{220, 40, 30}, {240, 150, 20}, {40, 90, 220}, {150, 50, 180}};
static_assert(std::size(kColours) == kEnumerators<RegionKind>.size());
constexpr mesh_tools::Rgb kGrey = {200, 200, 200};

double greatest_distance(const IntersectionRegions& found, const IntersectionRegion& region) {
  double greatest = 0;
  for (std::uint32_t i = 0; i < region.vertex_count; ++i) {
    greatest = std::max(greatest, found.vertices[region.first_vertex + i].distance);
  }
  return greatest;
}

double length_of(const IntersectionRegions& found) {
  double length = 0;
  for (const IntersectionCurve& curve : found.curves) length += curve.length;
  return length;
}

}  // namespace

void write_regions_json(const DetectCommand& command, const IntersectionRegions& found) {
  nlohmann::ordered_json json = {{"t0", command.first_frame},
                                 {"t1", command.second_frame},
                                 {"curves", found.curves.size()},
                                 {"curve_length", length_of(found)},
                                 {"touching_pairs", found.touching_pairs},
                                 {"regions", nlohmann::ordered_json::array()}};
  for (const IntersectionRegion& region : found.regions) {
    json["regions"].push_back({{"kind", kEnumerators<RegionKind>[static_cast<std::uint32_t>(region.kind)]},
                               {"area", region.area},
                               {"curve_length", region.curve_length},
                               {"vertices", region.vertex_count},
                               {"triangles", region.triangle_count},
                               {"distance", greatest_distance(found, region)}});
  }
  write_file(command.json_file, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::vector<mesh_tools::Rgb> colours_of(std::size_t triangle_count, const IntersectionRegions& found) {
  std::vector<mesh_tools::Rgb> colours(triangle_count, kGrey);
  for (const IntersectionRegion& region : found.regions) {
    for (std::uint32_t i = 0; i < region.triangle_count; ++i) {
      colours[found.triangles[region.first_triangle + i]] = kColours[static_cast<std::uint32_t>(region.kind)];
    }
  }
  return colours;
}

void print_regions(const IntersectionRegions& found) {
  fmt::print("{} regions on the wrong side, {} curves of {:.6g} together\n", found.regions.size(), found.curves.size(),
             length_of(found));
  for (const IntersectionRegion& region : found.regions) {
    fmt::print("  {}: {} triangles, {} vertices, area {:.6g}, curves {:.6g}, way out at most {:.6g}\n",
               kEnumerators<RegionKind>[static_cast<std::uint32_t>(region.kind)], region.triangle_count,
               region.vertex_count, region.area, region.curve_length, greatest_distance(found, region));
  }
}

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
  nlohmann::ordered_json json = {
      {"t0", command.first_frame}, {"t1", command.second_frame}, {"repeat", command.repetitions}};
  for_each_option(command, [&](auto field, const auto& options) {
    if constexpr (std::is_enum_v<typename decltype(field)::Value>) {
      json[field.kName] = name_of(field.of(options));
    } else {
      json[field.kName] = field.of(options);
    }
  });
  add_statistics(json, statistics);
  // File names may hold any bytes.
  write_file(command.json_file, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

void print_summary(const DetectCommand& command, const Statistics& s) {
  fmt::print("mesh        {} triangles, {} vertices, {} edges\n", s.triangles, s.vertices, s.edges);
  fmt::print("detection   {}, {}, broad phase {}, on {}\n", name_of(command.options.detection),
             name_of(command.options.accuracy), name_of(command.options.broad_phase), name_of(s.backend));
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
