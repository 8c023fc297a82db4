#include "ranks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <barrier>
#include <chrono>
#include <cstddef>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "command_line/choices.hpp"
#include "command_line/stage_times.hpp"
#include "detector_measurement.hpp"
#include "device_memory.hpp"
#include "report.hpp"

// Measures one scene on several ranks, each a thread with a device, or with its share of the processor. Reports the
// time until all ranks are done; positions and contacts stay where they are computed.

namespace softcd::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kWarmUps = 5;
constexpr double kTrianglesOfClothOnBall = 92'000;

/// The measurements of one rank.
struct RankResult {
  std::vector<double> waits;       ///< ms from setting positions to having contacts
  std::vector<StageTimes> stages;  ///< for each of the waits
  Statistics statistics;
  std::uint64_t contacts = 0;
  std::uint64_t checksum = 0;  ///< of all ranks' contacts
};

/// The result of all ranks.
struct Result {
  std::string scene;
  Mode mode;
  int ranks = 1;
  double wait_ms = 0;        ///< median of the slowest rank's
  double work_ms = 0;        ///< of the rank with most work: its detection without transfers
  double least_work_ms = 0;  ///< of the rank with least work
  StageTimes stages;         ///< of the rank with most work
  std::uint64_t triangles = 0, contacts = 0, peak_bytes = 0, checksum = 0;
};

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// One end of a body's step, in the backend's memory.
class OwnPositions {
 public:
  OwnPositions(Backend backend, const std::vector<Vec3f>& x)
      : backend_(backend), count_(x.size()), memory_(backend, x.size() * sizeof(Vec3f)) {
    memory_.write(x.data(), x.size() * sizeof(Vec3f));
  }

  Positions get() {
    const auto* x = reinterpret_cast<const float*>(memory_.data());
    return backend_ == Backend::cuda ? Positions::on_device(x, count_, sizeof(Vec3f))
                                     : Positions(x, count_, sizeof(Vec3f));
  }

 private:
  Backend backend_;
  std::size_t count_;
  test::DeviceMemory memory_;
};

/// A body whose positions this rank sets.
struct OwnBody {
  BodyId id;
  OwnPositions x_t0, x_t1;
};

class Benchmark {
 public:
  explicit Benchmark(const RankOptions& options) : options_(options) {}

  void run() {
    for (const std::string& folder : options_.step_folders) measure_scene(read_recorded_step(folder));
    for (const double triangles : options_.triangles) {
      if (!options_.is_weak) measure_scene(make_cloth_on_ball(triangles / kTrianglesOfClothOnBall));
      if (options_.is_weak) measure_weak(triangles);
    }
    fmt::print("{}", table_.text());
    if (!options_.markdown_file.empty()) write_file(options_.markdown_file, table_.text());
    if (!options_.json_file.empty()) write_json(options_.json_file, json_);
  }

 private:
  void measure_scene(const DetectorScene& scene) {
    for (const Mode& mode : options_.modes) {
      std::vector<Result> results;
      for (const int ranks : options_.ranks) results.push_back(measure(scene, mode, ranks));
      for (const Result& result : results) add(result, results.front());
    }
  }

  void measure_weak(double triangles) {
    for (const Mode& mode : options_.modes) {
      std::vector<Result> results;
      for (const int ranks : options_.ranks) {
        results.push_back(measure(make_cloth_on_ball(ranks * triangles / kTrianglesOfClothOnBall), mode, ranks));
      }
      for (const Result& result : results) add(result, results.front());
    }
  }

  Result measure(const DetectorScene& scene, const Mode& mode, int ranks) {
    const std::vector<Communicator> communicators = communicators_of(ranks);
    std::vector<RankResult> results(communicators.size());
    std::vector<std::exception_ptr> problems(communicators.size());
    std::barrier meeting(ranks);
    std::vector<std::thread> threads;
    for (std::size_t rank = 0; rank < communicators.size(); ++rank) {
      threads.emplace_back([&, rank] {
        try {
          results[rank] = run_rank(scene, mode, communicators[rank], static_cast<int>(rank), meeting);
        } catch (...) {
          problems[rank] = std::current_exception();
          meeting.arrive_and_drop();
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const std::exception_ptr& problem : problems) {
      if (problem != nullptr) std::rethrow_exception(problem);
    }
    return summary_of(scene, mode, results);
  }

  std::vector<Communicator> communicators_of(int ranks) const {
    if (ranks == 1) return {Communicator()};
    if (options_.backend != Backend::cuda) return Communicator::of_threads(ranks);
    std::vector<int> devices;
    for (int device = 0; device < ranks; ++device) devices.push_back(device);
    return Communicator::of_devices(devices);
  }

  RankResult run_rank(const DetectorScene& scene, const Mode& mode, const Communicator& communicator, int rank,
                      std::barrier<>& meeting) const {
    const bool on_device = options_.backend == Backend::cuda;
    if (on_device) test::use_device(rank);
    SceneOptions scene_options;
    scene_options.backend = options_.backend;
    scene_options.communicator = communicator;
    scene_options.cuda_device = on_device ? rank : -1;
    scene_options.max_threads = on_device ? 0 : std::max(1U, std::thread::hardware_concurrency() / communicator.size());
    Scene bodies(scene_options);
    std::vector<OwnBody> own;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const SceneBody& body = scene.bodies[i];
      BodySettings settings = body.settings;
      settings.features = {true, true};
      if (mode.detection == Detection::dcd) settings.margin = static_cast<float>(kMarginInEdges * scene.edge_length);
      const int owner = static_cast<int>(i) % communicator.size();
      const BodyId id =
          bodies.add_body({body.triangles, static_cast<std::uint32_t>(body.x_t0.size()), settings, owner});
      if (owner == communicator.rank()) {
        own.push_back({id, OwnPositions(options_.backend, body.x_t0), OwnPositions(options_.backend, body.x_t1)});
      }
    }
    QueryOptions query_options;
    query_options.detection = mode.detection;
    query_options.accuracy = mode.accuracy;
    query_options.reuse_pairs = false;
    Query query(bodies, query_options);
    const auto set_positions = [&] {
      for (OwnBody& body : own) bodies.set_positions(body.id, body.x_t0.get(), body.x_t1.get());
    };
    RankResult result;
    set_positions();
    result.contacts = query.detect().size();
    const std::vector<Contact> contacts = query.gather_contacts();
    result.checksum =
        checksum_of({reinterpret_cast<const std::byte*>(contacts.data()), contacts.size() * sizeof(Contact)});
    query_options.contacts_on_device = on_device;
    query.set_options(query_options);
    for (int i = -kWarmUps; i < options_.repetitions; ++i) {
      meeting.arrive_and_wait();
      const Clock::time_point begin = Clock::now();
      set_positions();
      if (on_device) {
        query.detect_on_device();
      } else {
        query.detect();
      }
      if (i < 0) continue;
      result.waits.push_back(milliseconds_since(begin));
      result.stages.push_back(query.statistics().ms);
    }
    result.statistics = query.statistics();
    return result;
  }

  static Result summary_of(const DetectorScene& scene, const Mode& mode, const std::vector<RankResult>& ranks) {
    Result result;
    result.scene = scene.name;
    result.mode = mode;
    result.ranks = static_cast<int>(ranks.size());
    result.triangles = scene.triangle_count();
    std::vector<double> waits = ranks.front().waits;
    for (const RankResult& rank : ranks) {
      for (std::size_t i = 0; i < waits.size(); ++i) waits[i] = std::max(waits[i], rank.waits[i]);
      const StageTimes stages = demo::median(rank.stages);
      const double work = stages.total - stages.transfer;
      if (work >= result.work_ms) result.stages = stages;
      result.work_ms = std::max(result.work_ms, work);
      result.least_work_ms = &rank == &ranks.front() ? work : std::min(result.least_work_ms, work);
      result.contacts += rank.contacts;
      result.peak_bytes = std::max(result.peak_bytes, rank.statistics.peak_bytes);
      result.checksum = rank.checksum;
    }
    result.wait_ms = demo::median(waits);
    return result;
  }

  void add(const Result& result, const Result& first) {
    if (!options_.is_weak && result.checksum != first.checksum) {
      throw std::runtime_error(fmt::format("{} ranks have found other contacts than {}", result.ranks, first.ranks));
    }
    const bool is_ccd = result.mode.detection == Detection::ccd;
    table_.add({result.scene, is_ccd ? "ccd" : "dcd", fmt::format("{}", result.triangles),
                fmt::format("{}", result.contacts), fmt::format("{}", result.ranks),
                fmt::format("{:.3f}", result.wait_ms), fmt::format("{:.3f}", result.least_work_ms),
                fmt::format("{:.3f}", result.work_ms), fmt::format("{:.2f}", first.wait_ms / result.wait_ms),
                fmt::format("{:.1f}", static_cast<double>(result.peak_bytes) / 1e6),
                fmt::format("{:.2f}", static_cast<double>(result.peak_bytes) / static_cast<double>(first.peak_bytes))});
    nlohmann::ordered_json row = {{"scene", result.scene},
                                  {"detection", is_ccd ? "ccd" : "dcd"},
                                  {"accuracy", demo::name_of(result.mode.accuracy)},
                                  {"weak", options_.is_weak},
                                  {"triangles", result.triangles},
                                  {"contacts", result.contacts},
                                  {"contacts_checksum", fmt::format("{:016x}", result.checksum)},
                                  {"ranks", result.ranks},
                                  {"wait_ms", result.wait_ms},
                                  {"least_work_ms", result.least_work_ms},
                                  {"most_work_ms", result.work_ms},
                                  {"peak_bytes", result.peak_bytes}};
    for (const demo::StageTime& stage : demo::kStageTimes) row["ms"][stage.name] = result.stages.*stage.ms;
    json_["rows"].push_back(row);
  }

  const RankOptions& options_;
  Table table_{{"scene", "detection", "triangles", "contacts", "ranks", "ms", "least work ms", "most work ms",
                "times as fast", "MB a rank", "of one's"},
               2};
  nlohmann::ordered_json json_ = describe_run("scaling", options_.machine);
};

}  // namespace

void add_ranks(CLI::App& app, RankOptions& options) {
  CLI::App* command = app.add_subcommand(
      "scaling",
      "Measures one scene on several GPUs of this machine, connected by NCCL, or on several ranks on the CPU. It is\n"
      "a cloth on a ball whose positions are in one rank's memory. Contacts stay with the ranks that find them. "
      "Median\n"
      "times in milliseconds, of the slowest rank, from setting positions to having contacts");
  command
      ->add_option("--gpus,--ranks", options.ranks,
                   "Numbers of GPUs or ranks, one after the other; the others are compared with the first")
      ->option_text("N,N,... [1,2]")
      ->delimiter(',')
      ->check(CLI::Range(1, 1024));
  demo::add_choice(*command, "--backend", options.backend, "cuda: a GPU a rank; cpu: its share of the processor");
  command->add_option("--triangles", options.triangles, "Approximate numbers of triangles, one scene after the other")
      ->option_text("N,N,... [1e6,1e7]")
      ->delimiter(',');
  command->add_flag("--weak", options.is_weak, "The number of triangles is for each rank, instead of for all together");
  command
      ->add_option("--step", options.step_folders,
                   "Also a recorded step: a folder that contains a folder frames with two meshes; may be repeated")
      ->option_text("DIR")
      ->check(CLI::ExistingDirectory);
  demo::add_choices(*command, "--mode", kModes, options.modes,
                    "The kind of detection, and the narrow phase's arithmetic");
  command->add_option("--repeat", options.repetitions, "Measured detections, after five to warm up")
      ->option_text("N [20]")
      ->check(CLI::Range(1, 100000));
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the table as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure; milliseconds and bytes")->option_text("FILE");
  command->callback([&options] { Benchmark(options).run(); });
}

}  // namespace softcd::benchmarks
