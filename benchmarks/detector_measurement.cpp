#include "detector_measurement.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "command_line/stage_times.hpp"
#include "device_memory.hpp"
#include "paper/detector.hpp"
#include "quartiles.hpp"
#include "query_core.hpp"
#include "softcd/core/fnv.hpp"
#include "softcd/core/parallel.hpp"

namespace softcd::benchmarks {
namespace {

constexpr int kWarmUps = 3;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Vec3f middle_of(const SceneBody& body, const Triangle& t) {
  Vec3f sum{};
  for (const std::uint32_t v : t.v) sum = sum + body.x_t0[v] + body.x_t1[v];
  return (1.0F / 6.0F) * sum;
}

/// Returns the largest radius of a sphere around a triangle's whole motion.
float largest_radius(const DetectorScene& scene) {
  float squared = 0;
  for (const SceneBody& body : scene.bodies) {
    for (const Triangle& t : body.triangles) {
      const Vec3f middle = middle_of(body, t);
      for (const std::uint32_t v : t.v) {
        squared = std::max({squared, squared_norm(body.x_t0[v] - middle), squared_norm(body.x_t1[v] - middle)});
      }
    }
  }
  return std::sqrt(squared);
}

void set_times(Measurement& measurement, const std::vector<StageTimes>& times) {
  std::vector<double> totals;
  totals.reserve(times.size());
  for (const StageTimes& time : times) totals.push_back(time.total);
  const Quartiles quartiles = quartiles_of(totals);
  measurement.statistics.ms = demo::median(times);
  measurement.first_quartile_ms = quartiles.first;
  measurement.third_quartile_ms = quartiles.third;
  measurement.repetitions = static_cast<int>(times.size());
}

/// Positions at one end of a body's step, in the memory from which the measured detector reads them.
class MeasuredPositions {
 public:
  MeasuredPositions(const std::vector<Vec3f>& x, const MeasuredOptions& options) : positions_(x) {
    if (!options.on_device) return;
    const std::size_t bytes = x.size() * sizeof(Vec3f);
    memory_.emplace(options.backend, bytes).write(x.data(), bytes);
    positions_ = Positions::on_device(reinterpret_cast<const float*>(memory_->data()), x.size(), sizeof(Vec3f));
  }

  const Positions& get() const { return positions_; }

 private:
  Positions positions_;
  std::optional<test::DeviceMemory> memory_;
};

Measurement measure_all(const DetectorScene& scene, const MeasuredOptions& options, int repetitions) {
  const auto measured = std::make_shared<detail::SceneCore>(
      options, LogCallback(), options.is_paper ? paper::detector_factories(options) : machine_factories(options));
  QueryOptions query_options = options;
  query_options.contacts_on_device = options.on_device;
  detail::QueryCore query(measured, query_options);
  std::vector<BodyId> ids;
  std::vector<std::array<MeasuredPositions, 2>> positions;
  for (const SceneBody& body : scene.bodies) {
    BodySettings settings = body.settings;
    settings.features = {true, true};
    if (options.detection == Detection::dcd) settings.margin = static_cast<float>(kMarginInEdges * scene.edge_length);
    ids.push_back(measured->add_body({body.triangles, static_cast<std::uint32_t>(body.x_t0.size()), settings}));
    positions.push_back({MeasuredPositions(body.x_t0, options), MeasuredPositions(body.x_t1, options)});
  }

  Span<const Contact> contacts;
  std::size_t first_end = 0;
  const auto detect = [&] {
    for (std::size_t b = 0; b < ids.size(); ++b) {
      measured->set_positions(ids[b], positions[b][first_end].get(), positions[b][1 - first_end].get());
    }
    if (options.rocks) first_end = 1 - first_end;
    const std::uint64_t number = query.start(Pairs::all);
    if (options.on_device) {
      const DeviceContacts found = query.wait_on_device(number);
      contacts = {found.data, found.count};
    } else {
      contacts = query.wait(number);
    }
  };
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < kWarmUps && (i == 0 || seconds_since(start) < kMostSeconds / 4); ++i) detect();
  std::vector<StageTimes> times;
  std::vector<double> waits;
  do {
    const Clock::time_point before = Clock::now();
    detect();
    waits.push_back(1e3 * seconds_since(before));
    times.push_back(query.statistics().ms);
  } while (static_cast<int>(times.size()) < repetitions && seconds_since(start) < kMostSeconds);

  Measurement result;
  result.scene = scene.name;
  result.options = options;
  result.statistics = query.statistics();
  set_times(result, times);
  result.wall_ms = demo::median(waits);
  const std::vector<std::byte> bytes = test::read_device(options.on_device ? options.backend : Backend::cpu,
                                                         contacts.data(), contacts.size() * sizeof(Contact));
  result.checksum = checksum_of(bytes);
  result.options.backend = measured->backend();
  result.threads = static_cast<int>(parallel::allowed_threads());
  return result;
}

}  // namespace

std::uint64_t checksum_of(Span<const std::byte> contacts) {
  static_assert(sizeof(Contact) == 18 * 4, "padding would be part of the checksum");
  Fnv1a hash;
  hash.add_bytes(contacts.data(), contacts.size());
  return hash.value();
}

Measurement measure(const DetectorScene& scene, const MeasuredOptions& options, int repetitions) {
  try {
    return measure_all(scene, options, repetitions);
  } catch (const OutOfMemory&) {
    return left_out(scene, options, "out of memory");
  }
}

Measurement left_out(const DetectorScene& scene, const MeasuredOptions& options, const std::string& reason) {
  Measurement result;
  result.scene = scene.name;
  result.options = options;
  result.statistics.triangles = scene.triangle_count();
  result.left_out = reason;
  return result;
}

double estimate_uniform_tests(const DetectorScene& scene) {
  const float inverse_size = 1.0F / (3.0F * largest_radius(scene));
  const auto coordinate = [inverse_size](float x) {  // 21 bits, enough for cells as large as the largest triangle
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x * inverse_size))) & 0x1FFFFFU;
  };
  std::unordered_map<std::uint64_t, double> occupancy;
  for (const SceneBody& body : scene.bodies) {
    for (const Triangle& t : body.triangles) {
      const Vec3f middle = middle_of(body, t);
      if (!std::isfinite(squared_norm(middle))) continue;
      ++occupancy[coordinate(middle.x) << 42 | coordinate(middle.y) << 21 | coordinate(middle.z)];
    }
  }
  double tests = 0;
  for (const auto& [cell, triangles] : occupancy) tests += 0.5 * triangles * triangles;
  return tests;
}

}  // namespace softcd::benchmarks
