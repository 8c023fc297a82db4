#include "program.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <optional>
#include <set>

#include "command_line.hpp"
#include "command_line/progress_line.hpp"
#include "command_line/standard_output.hpp"
#include "measurement.hpp"
#include "mesh_tools/mesh_io.hpp"
#include "report.hpp"

namespace softcd::demo {
namespace {

struct Frames {
  mesh_tools::Mesh first;
  std::optional<mesh_tools::Mesh> second;

  const mesh_tools::Mesh& last() const { return second ? *second : first; }
};

Frames read_frames(const DetectCommand& command, ProgressLine& progress) {
  const auto read = [&progress](const std::string& file) {
    progress.show("reading " + file);
    return mesh_tools::read_mesh(file);
  };
  Frames frames{read(command.first_frame), std::nullopt};
  if (!command.second_frame.empty()) {
    frames.second = read(command.second_frame);
    mesh_tools::require_same_topology(frames.first, command.first_frame, *frames.second, command.second_frame);
  }
  return frames;
}

/// Finds where the last frame intersects itself.
void find_regions(const DetectCommand& command, const Frames& frames, Scene& scene, BodyId body) {
  const mesh_tools::Mesh& last = frames.last();
  scene.set_positions(body, last.positions);
  Probe probe(scene);
  const IntersectionRegions found = probe.intersection_regions();
  if (!command.coloured_file.empty()) {
    mesh_tools::write_mesh(command.coloured_file,
                           {last.positions, last.triangles, colours_of(last.triangles.size(), found)});
  }
  if (!command.json_file.empty()) write_regions_json(command, found);
  print_regions(found);
}

void run(DetectCommand command) {
  ProgressLine progress;
  const Frames frames = read_frames(command, progress);

  std::set<std::string, std::less<>> warned;  // repetitions repeat their warnings
  const auto log = [&](LogLevel level, std::string_view text) {
    if (level != LogLevel::warning || !warned.emplace(text).second) return;
    progress.clear();
    fmt::print(stderr, "softcd-detect: warning: {}\n", text);
  };

  CollisionPipeline pipeline(command.options, log);
  const auto vertex_count = static_cast<std::uint32_t>(frames.first.positions.size());
  const BodyId body = pipeline.scene.add_body({frames.first.triangles, vertex_count, command.settings});
  if (command.intersections == Intersections::regions) {
    progress.clear();
    return find_regions(command, frames, pipeline.scene, body);
  }
  const auto start_run = [&](std::uint32_t run, std::uint32_t count) {
    progress.show(fmt::format("detecting, run {} of {}", run + 1, count));
    if (command.options.detection == Detection::ccd) {
      pipeline.scene.set_positions(body, frames.first.positions, frames.last().positions);
    } else {
      pipeline.scene.set_positions(body, frames.last().positions);
    }
  };
  const Measurement measurement = measure(pipeline, command.repetitions, start_run);
  progress.clear();

  if (!command.contacts_file.empty()) write_contacts(command.contacts_file, measurement.contacts);
  if (!command.json_file.empty()) write_json(command, measurement.statistics);
  print_summary(command, measurement.statistics);
}

int fail(int exit_code, const std::exception& error) {
  fmt::print(stderr, "softcd-detect: {}\n", error.what());
  return exit_code;
}

}  // namespace

int detect_program(int argc, char** argv) {
  try {
    const ParsedCommandLine parsed = parse_command_line(argc, argv);
    if (parsed.command) run(*parsed.command);
    finish_standard_output();
    return parsed.exit_code;
  } catch (const mesh_tools::MeshError& error) {
    return fail(kExitWrongInput, error);
  } catch (const InvalidInput& error) {
    return fail(kExitWrongInput, error);
  } catch (const std::exception& error) {
    return fail(kExitFailure, error);
  }
}

}  // namespace softcd::demo
