#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "device_memory.hpp"
#include "expectations.hpp"
#include "forwarding_detector.hpp"
#include "mesh_generators.hpp"
#include "query_core.hpp"
#include "scene_parts.hpp"

// Scenes whose positions are on a device: the GPU where it is under test, else a pretended one.
namespace softcd::test {

/// Computes on the CPU, with positions that it knows only from changes, as a device does.
class CopyingDevice final : public ForwardingDetector {
 public:
  void set_scene(const SceneArrays& scene, const SceneChanges& changes) override {
    follow(x_t0_, scene.x_t0, changes.x_t0, changes.device_x_t0, changes.origin);
    follow(x_t1_, scene.x_t1, changes.x_t1, changes.device_x_t1, changes.origin);
    follow(full_t0_, scene.full_t0, changes.full_t0, changes.device_full_t0, changes.origin);
    follow(full_t1_, scene.full_t1, changes.full_t1, changes.device_full_t1, changes.origin);
    SceneArrays mirrored = scene;
    mirrored.x_t0 = x_t0_;
    mirrored.x_t1 = x_t1_;
    mirrored.full_t0 = full_t0_;
    mirrored.full_t1 = full_t1_;
    SceneChanges none;
    none.verdict = changes.verdict;
    ForwardingDetector::set_scene(mirrored, none);
  }

 private:
  template <class Position>
  static void follow(std::vector<Position>& copy, Span<const Position> values, const std::vector<Range>& changes,
                     const std::vector<DevicePositions>& on_device, Vec3d origin) {
    using T = decltype(Position::x);
    constexpr T kNever = std::numeric_limits<T>::quiet_NaN();
    if (copy.size() < values.size()) copy.resize(values.size(), {kNever, kNever, kNever});
    for (const Range& range : changes) {
      std::copy(values.begin() + range.begin, values.begin() + range.end,
                copy.begin() + static_cast<std::ptrdiff_t>(range.begin));
    }
    for (const DevicePositions& x : on_device) {
      for (std::uint64_t i = 0; i < x.count; ++i) {
        if (x.positions.is_double) {
          PlacePosition<double, Position>{x.positions, origin, copy.data() + x.first}(i);
        } else {
          PlacePosition<float, Position>{x.positions, origin, copy.data() + x.first}(i);
        }
      }
    }
  }

  std::vector<Vec3f> x_t0_, x_t1_;
  std::vector<Vec3d> full_t0_, full_t1_;
};

/// The number of surveys at predicted positions.
struct SurveyCounts {
  int all = 0, in_vain = 0;
};

/// Reads the host's memory as if it were a device's, and fails on request.
class HostReader final : public DevicePositionReader {
 public:
  HostReader(const bool& fails, SurveyCounts& survey_counts) : fails_(fails), survey_counts_(survey_counts) {}

  int device() const override { return 0; }
  bool can_read(const void* data) override {
    if (fails_) throw DeviceError("the device fell off the bus");
    return data != nullptr;
  }
  void wait_for(void* /*ready*/) override {}
  Span<const StepSurvey> survey(Span<const SurveyedVertices> vertices, Vec3d origin, bool needs_t0) override {
    if (fails_) throw DeviceError("the device fell off the bus");
    surveys_.assign(vertices.size(), {});
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      for (std::uint64_t v = vertices[i].begin; v < vertices[i].end; ++v) {
        if (vertices[i].x_t1.is_double) {
          survey_vertex<double>(vertices[i], v, origin, needs_t0, surveys_[i]);
        } else {
          survey_vertex<float>(vertices[i], v, origin, needs_t0, surveys_[i]);
        }
      }
      if (!vertices[i].has_two_ends) surveys_[i].t0 = surveys_[i].t1;
    }
    return surveys_;
  }
  PredictionVerdict look(Span<const SurveyedVertices> vertices, Span<const StepSurvey> predicted,
                         const Predicted& scene, bool needs_t0) override {
    survey(vertices, scene.origin, needs_t0);
    StepSurvey all;
    bool is_so = true;
    for (std::size_t i = 0; i < surveys_.size(); ++i) {
      is_so = is_so && is_within(surveys_[i], predicted[i]);
      all.merge(surveys_[i]);
    }
    ++survey_counts_.all;
    is_so_ = is_so && is_as_predicted(all, scene) ? 1 : 0;
    survey_counts_.in_vain += is_so_ == 0;
    return {&is_so_, nullptr};
  }
  SeenPositions seen() override { return {surveys_, is_so_ != 0}; }
  void copy(const GivenPositions& from, std::uint64_t count, void* to) override {
    if (fails_) throw DeviceError("the device fell off the bus");
    const std::size_t size = from.is_double ? sizeof(Vec3d) : sizeof(Vec3f);
    for (std::uint64_t i = 0; i < count; ++i) {
      std::memcpy(static_cast<std::byte*>(to) + i * size, static_cast<const std::byte*>(from.data) + i * from.stride,
                  size);
    }
  }

 private:
  const bool& fails_;
  SurveyCounts& survey_counts_;
  std::vector<StepSurvey> surveys_;
  std::uint32_t is_so_ = 0;
};

/// A form in which positions may be given.
struct Form {
  bool is_double = false;
  std::size_t padding = 0;  ///< bytes between two
};

inline std::size_t size_of(const Form& form) {
  return form.is_double ? sizeof(Vec3d) : sizeof(Vec3f);
}

inline std::vector<std::byte> bytes_of(const Positions3& x, const Form& form) {
  const std::size_t stride = size_of(form) + form.padding;
  std::vector<std::byte> bytes(x.size() * stride + 1, std::byte{0xFF});
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3f rounded = vec3_cast<float>(x[i]);
    std::memcpy(&bytes[i * stride], form.is_double ? static_cast<const void*>(&x[i]) : &rounded, size_of(form));
  }
  return bytes;
}

inline Positions positions_at(const std::byte* data, std::size_t count, const Form& form, bool on_device) {
  const std::size_t stride = size_of(form) + form.padding;
  const auto* const doubles = reinterpret_cast<const double*>(data);
  const auto* const floats = reinterpret_cast<const float*>(data);
  if (!on_device) return form.is_double ? Positions(doubles, count, stride) : Positions(floats, count, stride);
  return form.is_double ? Positions::on_device(doubles, count, stride) : Positions::on_device(floats, count, stride);
}

/// A scene with one query, and the memory of its bodies' positions.
class LoadedCore {
 public:
  LoadedCore(const SceneOptions& options, LogCallback log, DetectorFactories factories)
      : scene_(std::make_shared<detail::SceneCore>(options, std::move(log), std::move(factories))),
        query_(scene_, {}) {}

  detail::SceneCore& scene() { return *scene_; }
  detail::QueryCore& query() { return query_; }
  std::vector<BodyId>& ids() { return ids_; }

  void add(const SceneBody& body) {
    ids_.push_back(scene_->add_body({body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings}));
    memories_.emplace_back();
  }
  void remove_last() {
    scene_->remove_body(ids_.back());
    ids_.pop_back();
    memories_.pop_back();
  }
  /// Sets positions, and overwrites the previous ones once they are no longer needed.
  void set(std::size_t i, const SceneBody& body, const Form& form, bool moves, bool on_device) {
    Memories next;
    const auto place = [&](const Positions3& x, std::optional<DeviceMemory>& device, std::vector<std::byte>& host) {
      std::vector<std::byte> bytes = bytes_of(x, form);
      if (!on_device) return positions_at((host = std::move(bytes)).data(), x.size(), form, false);
      device.emplace(backend_under_test(), bytes.size()).write(bytes.data(), bytes.size());
      return positions_at(device->data(), x.size(), form, true);
    };
    const Positions x_t1 = place(body.x_t1, next.device_t1, next.host_t1);
    const Positions x_t0 = moves ? place(body.x_t0, next.device_t0, next.host_t0) : x_t1;
    scene_->set_positions(ids_[i], x_t0, x_t1);
    memories_[i] = std::move(next);
  }
  std::vector<Contact> detect(const QueryOptions& options) {
    query_.set_options(options);
    return copy_of(query_.wait(query_.start(Pairs::all)));
  }

 private:
  struct Memories {
    std::optional<DeviceMemory> device_t0, device_t1;
    std::vector<std::byte> host_t0, host_t1;
  };

  std::shared_ptr<detail::SceneCore> scene_;
  detail::QueryCore query_;
  std::vector<BodyId> ids_;
  std::vector<Memories> memories_;
};

class DevicePositionsTest : public testing::Test {
 protected:
  LogCallback log() {
    return [this](LogLevel level, std::string_view message) {
      if (level == LogLevel::warning) warnings_.emplace_back(message);
    };
  }
  LoadedCore on_host() { return {scene_options(Backend::cpu), {}, {make_cpu_detector, {}, ""}}; }
  /// Returns a scene on the GPU where it is under test, else on the pretended device.
  LoadedCore on_device(Backend wanted = Backend::cuda) {
    if (backend_under_test() == Backend::cuda)
      return {scene_options(wanted), log(), machine_factories(scene_options(wanted))};
    DetectorFactories factories = {make_cpu_detector, [] { return std::make_unique<CopyingDevice>(); }, ""};
    factories.make_reader = [this] { return std::make_unique<HostReader>(fails_, survey_counts_); };
    return {scene_options(wanted), log(), std::move(factories)};
  }
  static SceneBody soup(std::uint64_t seed, std::uint32_t triangle_count = 300) {
    SoupOptions options;
    options.triangle_count = triangle_count;
    options.half_extent = 2.0;
    options.joined_share = 0.5;
    options.seed = seed;
    const Mesh mesh = triangle_soup(options);
    return moving(mesh, scattered(mesh, 0.4, seed), everything(0.05F));
  }

  bool fails_ = false;
  SurveyCounts survey_counts_;  ///< of the pretended device
  std::vector<std::string> warnings_;
};

}  // namespace softcd::test
