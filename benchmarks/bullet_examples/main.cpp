// Runs Bullet's own examples of soft bodies with Bullet alone and with softcd, and prints a table of processor times
// and crossings.

#include <fmt/format.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "CommonInterfaces/CommonExampleInterface.h"
#include "CommonInterfaces/CommonGUIHelperInterface.h"
#include "make_world.hpp"
#include "scenes/penetration.hpp"
#include "softcd/core/parallel.hpp"

using softcd::benchmarks::example_bodies;
using softcd::benchmarks::example_settings;
using softcd::bullet::Settings;

// SOFTCD_SOFT_DEMO(NAME) for each option of SoftDemo, and SOFTCD_DEFORMABLE_DEMO(NAME) for each file of DeformableDemo.
#define SOFTCD_SOFT_DEMO(NAME)
#define SOFTCD_DEFORMABLE_DEMO(NAME) CommonExampleInterface* NAME##CreateFunc(CommonExampleOptions& options);
#include "examples.inc"
SOFTCD_DEFORMABLE_DEMO(SoftDemo)

namespace {

struct Example {
  std::string name;
  CommonExampleInterface::CreateFunc* create;
  int option;
  int frame_divisor;  ///< a run has so many times fewer frames than the command line says
};

std::vector<Example> all_examples() {
  std::vector<Example> examples;
  int option = 0;
#undef SOFTCD_SOFT_DEMO
#undef SOFTCD_DEFORMABLE_DEMO
#define SOFTCD_SOFT_DEMO(NAME) examples.push_back({"soft/" #NAME, SoftDemoCreateFunc, option++, 1});
#define SOFTCD_DEFORMABLE_DEMO(NAME) examples.push_back({"deformable/" #NAME, NAME##CreateFunc, 0, 5});
#include "examples.inc"
  return examples;
}

/// Whether an edge of a soft body intersects a triangle of another, or of its own if it collides with itself; exactly.
bool is_crossed() {
  std::vector<const btSoftBody*> bodies;
  for (int i = 0; i < example_bodies->size(); ++i) bodies.push_back((*example_bodies)[i]);
  const auto counts = [](const btSoftBody& edges, const btSoftBody& triangles) {
    return &edges != &triangles || edges.m_useSelfCollision;
  };
  return softcd::demo::find_intersections(bodies, counts).edge_count > 0;
}

double processor_milliseconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) * 1e3 + double(time.tv_nsec) * 1e-6;
}

/// Has the figures that a run counts.
struct Counts {
  std::size_t triangles = 0;       ///< when it starts
  std::size_t crossed_frames = 0;  ///< frames that end with a crossing, if these are wanted
};

/// One run of an example.
struct Run {
  std::vector<double> milliseconds;  ///< of each frame
  Counts counts;
};

/// Simulates on one thread, and writes each frame's time, then the counts.
void simulate(const Example& example, std::size_t frames, bool watch, std::FILE* file) {
  const softcd::parallel::ThreadLimit one_thread(1);
  DummyGUIHelper no_window;
  CommonExampleOptions options(&no_window, example.option);
  CommonExampleInterface* app = example.create(options);
  app->initPhysics();
  Counts counts;
  for (int i = 0; i < example_bodies->size(); ++i)
    counts.triangles += std::size_t((*example_bodies)[i]->m_faces.size());
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const double begin = processor_milliseconds();
    app->stepSimulation(1.0F / 60);
    const double milliseconds = processor_milliseconds() - begin;
    std::fwrite(&milliseconds, sizeof(milliseconds), 1, file);
    if (watch && is_crossed()) ++counts.crossed_frames;
  }
  std::fwrite(&counts, sizeof(counts), 1, file);
  std::fflush(file);
}

/// Simulates in a process of its own, as Bullet's random numbers are those of a process. Ends the program on failure.
Run simulate_apart(const Example& example, const std::optional<Settings>& settings, std::size_t frames, bool watch) {
  std::FILE* file = std::tmpfile();
  std::fflush(stdout);  // both processes would write buffered output
  if (fork() == 0) {
    example_settings = settings;
    if (std::freopen("/dev/null", "w", stdout) == nullptr) std::abort();  // what examples print
    simulate(example, frames, watch, file);
    _exit(0);
  }
  wait(nullptr);
  std::rewind(file);
  Run run;
  run.milliseconds.resize(frames);
  if (std::fread(run.milliseconds.data(), sizeof(double), frames, file) != frames ||
      std::fread(&run.counts, sizeof(run.counts), 1, file) != 1) {
    fmt::print(stderr, "softcd-bullet-examples: the run of {} has failed\n", example.name);
    std::exit(1);
  }
  std::fclose(file);
  return run;
}

/// The mean time of a frame but the first, each frame the median of all rounds.
double mean_of_medians(const std::vector<Run>& rounds) {
  double sum = 0;
  const std::size_t frames = rounds.front().milliseconds.size();
  for (std::size_t frame = 1; frame < frames; ++frame) {
    std::vector<double> times;
    for (const Run& run : rounds) times.push_back(run.milliseconds[frame]);
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    sum += *middle;
  }
  return sum / double(frames - 1);
}

std::vector<std::optional<Settings>> all_settings() {
  Settings ccd;
  ccd.detection = softcd::Detection::ccd;
  Settings edges = ccd;
  edges.edge_contacts = softcd::bullet::EdgeContacts::respond;
  return {std::nullopt, Settings::balanced(), ccd, edges, Settings::safe()};
}

std::string row_of(const Example& example, std::size_t frames, int rounds) {
  std::vector<std::vector<Run>> runs(all_settings().size());  // by settings and round
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      runs[i].push_back(simulate_apart(example, all_settings()[i], frames, /*watch=*/round == 0));
    }
  }
  const double bullet = mean_of_medians(runs[0]);
  std::string row = fmt::format("| {} | {} | {:.2g} ", example.name, runs[0].front().counts.triangles, bullet);
  for (std::size_t i = 1; i < runs.size(); ++i) row += fmt::format("| {:.2f} ", mean_of_medians(runs[i]) / bullet);
  std::vector<std::size_t> crossed;
  for (const std::vector<Run>& of_settings : runs) crossed.push_back(of_settings.front().counts.crossed_frames);
  const bool is_clean = std::all_of(crossed.begin(), crossed.end(), [](std::size_t count) { return count == 0; });
  return row + (is_clean ? "| 0 |" : fmt::format("| {} |", fmt::join(crossed, " / ")));
}

/// Lets this process run on one of the cores that it may use, the index-th, modulo their number.
void stay_on_core(std::size_t index) {
  cpu_set_t usable;
  if (sched_getaffinity(0, sizeof(usable), &usable) != 0) return;
  std::size_t skipped = index % std::size_t(CPU_COUNT(&usable));
  int core = 0;
  while (!CPU_ISSET(core, &usable) || skipped-- > 0) ++core;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(core, &one);
  sched_setaffinity(0, sizeof(one), &one);
}

/// Prints the rows of all examples, in their order. Measures as many at a time as there are jobs, each on a core of its
/// own. Returns whether all runs have succeeded.
bool print_rows(const std::vector<Example>& examples, std::size_t frames, int rounds, std::size_t jobs) {
  struct Job {
    std::size_t example, core;
  };
  std::map<pid_t, Job> running;
  std::vector<std::FILE*> rows(examples.size());
  std::vector<std::size_t> free_cores;
  for (std::size_t core = jobs; core-- > 0;) free_cores.push_back(core);
  bool have_succeeded = true;
  const auto wait_for_one = [&] {
    int status = 0;
    const auto ended = running.find(wait(&status));
    have_succeeded = have_succeeded && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    free_cores.push_back(ended->second.core);
    running.erase(ended);
  };
  std::fflush(stdout);                               // all processes would write buffered output
  for (std::size_t i = examples.size(); i-- > 0;) {  // from the end, as deformable examples take longest
    if (free_cores.empty()) wait_for_one();
    rows[i] = std::tmpfile();
    const std::size_t core = free_cores.back();
    free_cores.pop_back();
    const pid_t process = fork();
    if (process == 0) {
      stay_on_core(core);
      const std::size_t own_frames = std::max<std::size_t>(2, frames / std::size_t(examples[i].frame_divisor));
      fmt::print(rows[i], "{}\n", row_of(examples[i], own_frames, rounds));
      std::fflush(rows[i]);
      _exit(0);
    }
    running[process] = {i, core};
  }
  while (!running.empty()) wait_for_one();
  for (std::FILE* row : rows) {
    std::rewind(row);
    for (int c = std::fgetc(row); c != EOF; c = std::fgetc(row)) std::putchar(c);
    std::fclose(row);
  }
  return have_succeeded;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Bullet's examples with Bullet alone, by default, with ccd, with ccd and edges, and with safe()");
  std::vector<std::string> names;
  std::size_t frames = 300;
  int rounds = 3;
  std::size_t jobs = 1;
  app.add_option("EXAMPLE", names, "As the table names it; all if none is named");
  app.add_option("--frames", frames, "Frames of 1/60 s in a run; a fifth of them in deformable examples")
      ->check(CLI::Range(2, 1000000));
  app.add_option("--rounds", rounds, "Runs of each, in turn")->check(CLI::Range(1, 1000));
  app.add_option("--jobs", jobs, "Examples to measure at a time, each on a core of its own")
      ->check(CLI::Range(1, 1024));
  CLI11_PARSE(app, argc, argv);
  std::vector<Example> examples = all_examples();
  const auto is_left_out = [&](const Example& example) {
    return !names.empty() && std::find(names.begin(), names.end(), example.name) == names.end();
  };
  examples.erase(std::remove_if(examples.begin(), examples.end(), is_left_out), examples.end());
  fmt::print("| example | triangles | Bullet ms | default | `ccd` | + edges | `safe` | frames with crossings |\n");
  fmt::print("|---|--:|--:|--:|--:|--:|--:|---|\n");
  return print_rows(examples, frames, rounds, jobs) ? 0 : 1;
}
