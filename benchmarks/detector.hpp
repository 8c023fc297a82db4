#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "command_line/choices.hpp"
#include "detector_scenes.hpp"
#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

struct Mode {
  Detection detection;
  Accuracy accuracy;

  friend bool operator==(const Mode&, const Mode&) = default;
};
/// The two columns of the paper's Table 1.
constexpr Mode kDiscreteFast = {Detection::dcd, Accuracy::fast};
constexpr Mode kContinuousPrecise = {Detection::ccd, Accuracy::precise};

inline constexpr std::array<demo::Choice<Mode>, 3> kModes = {
    {{"dcd-fast", kDiscreteFast},
     {"ccd-precise", kContinuousPrecise},
     {"ccd-conservative", {Detection::ccd, Accuracy::conservative}}}};

enum class Sweep { stages, subdivision, cell_size_factor, scaling, threads, ends, reuse };

struct DetectorOptions {
  std::vector<MakeScene> scenes = {make_funnel, make_cloth_on_ball, make_n_body};
  std::string first_frame, second_frame;  ///< empty: the generated scenes
  std::vector<std::string> step_folders;  ///< measured too
  std::vector<Mode> modes = {kDiscreteFast, kContinuousPrecise};
  double scale = 1;
  std::vector<Sweep> sweeps = {Sweep::stages};
  std::vector<Backend> backends = {Backend::automatic};
  int repetitions = 50;
  double most_triangles = 1e6;
  double most_tests = 2e10;
  std::string machine;        ///< empty: the processor
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
  std::string csv_file;       ///< empty: none
};

/// Adds the subcommand `detector`, which fills `options` and then runs the benchmark.
void add_detector(CLI::App& app, DetectorOptions& options);

}  // namespace softcd::benchmarks
