#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "scenes/soft_world.hpp"

// Runs simulations in Bullet's soft worlds, and varies their time step and one setting at a time.

namespace softcd::benchmarks {

struct SimulationOptions {
  demo::World world = demo::World::classic;
  Backend backend = Backend::cpu;
  int nodes_per_side = 24;  ///< of the cloths
  double seconds = 1;       ///< simulated
  int repetitions = 3;      ///< runs of each setting; the median time is reported
};

struct SimulationResult {
  std::string scene;
  demo::World world;
  std::string knob, value;  ///< the difference from the base point
  std::string detection;    ///< bullet, dcd or ccd
  std::string features;
  std::string accuracy;
  Backend backend;
  int steps_per_second = 0;
  double margin_in_cells = 0;   ///< of each body, in cells of its cloths
  double cell_size_factor = 0;  ///< 0: the detector's choice
  int iterations = 0;           ///< of the solver, positions
  double seconds = 0;
  std::size_t vertices = 0;
  std::size_t penetrating = 0;       ///< vertices with an edge through a triangle, at the end
  std::size_t most_penetrating = 0;  ///< of 30 times in a second
  std::size_t crossings = 0;         ///< vertices through triangles in a step, in exact arithmetic
  std::size_t tunnelled = 0;         ///< vertices with an odd number of crossings
  double energy_start = 0;           ///< kinetic and in the field of gravity, joules
  double energy_end = 0;
  double energy_most = 0;
  double contacts = 0;                 ///< mean number in a step that the solver received
  double ms_per_second = 0;            ///< of simulation, without the first step
  double processor_ms_per_second = 0;  ///< of this program's threads, without other programs' time
};

/// Runs the simulations. Calls `report` for each run as it ends.
void run_simulations(const SimulationOptions& options, const std::function<void(const SimulationResult&)>& report);

}  // namespace softcd::benchmarks
