#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "device_memory.hpp"
#include "expectations.hpp"
#include "forwarding_detector.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"
#include "scene_core.hpp"

// Positions that stay on a device give the contacts that they give on the host.
namespace softcd::test {
namespace {

/// Computes on the CPU, with positions that it has been told of only by changes, as a device has them.
class CopyingDevice final : public ForwardingDetector {
 public:
  void set_scene(const SceneArrays& scene, const SceneChanges& changes) override {
    follow(x_t0_, scene.x_t0, changes.x_t0, changes.device_x_t0, changes.origin);
    follow(x_t1_, scene.x_t1, changes.x_t1, changes.device_x_t1, changes.origin);
    SceneArrays mirrored = scene;
    mirrored.x_t0 = x_t0_;
    mirrored.x_t1 = x_t1_;
    ForwardingDetector::set_scene(mirrored, {});
  }

 private:
  static void follow(std::vector<Vec3f>& copy, Span<const Vec3f> values, const std::vector<Range>& changes,
                     const std::vector<DevicePositions>& on_device, Vec3d origin) {
    constexpr float kNever = std::numeric_limits<float>::quiet_NaN();
    copy.resize(values.size(), {kNever, kNever, kNever});
    for (const Range& range : changes) {
      std::copy(values.begin() + range.begin, values.begin() + range.end,
                copy.begin() + static_cast<std::ptrdiff_t>(range.begin));
    }
    for (const DevicePositions& x : on_device) {
      for (std::uint64_t i = 0; i < x.count; ++i) {
        if (x.positions.is_double) {
          PlacePosition<double>{x.positions, origin, copy.data() + x.first}(i);
        } else {
          PlacePosition<float>{x.positions, origin, copy.data() + x.first}(i);
        }
      }
    }
  }

  std::vector<Vec3f> x_t0_, x_t1_;
};

/// Reads the host's memory as if it were a device's, and fails when told to.
class HostReader final : public DevicePositionReader {
 public:
  explicit HostReader(const bool& fails) : fails_(fails) {}

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
  std::vector<StepSurvey> surveys_;
};

/// Positions in one of the forms that they may be given in.
struct Form {
  bool is_double = false;
  std::size_t padding = 0;  ///< bytes between two
};

std::size_t size_of(const Form& form) {
  return form.is_double ? sizeof(Vec3d) : sizeof(Vec3f);
}

std::vector<std::byte> bytes_of(const Positions3& x, const Form& form) {
  const std::size_t stride = size_of(form) + form.padding;
  std::vector<std::byte> bytes(x.size() * stride + 1, std::byte{0xFF});
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3f rounded = vec3_cast<float>(x[i]);
    std::memcpy(&bytes[i * stride], form.is_double ? static_cast<const void*>(&x[i]) : &rounded, size_of(form));
  }
  return bytes;
}

Positions positions_at(const std::byte* data, std::size_t count, const Form& form, bool on_device) {
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
  /// What was given before is overwritten once it is not needed any more.
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
    const Span<const Contact> contacts = query_.wait(query_.start(Pairs::all));
    return {contacts.begin(), contacts.end()};
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
  static SceneOptions options(Backend backend) {
    SceneOptions result;
    result.backend = backend;
    return result;
  }
  LogCallback log() {
    return [this](LogLevel level, std::string_view message) {
      if (level == LogLevel::warning) warnings_.emplace_back(message);
    };
  }
  LoadedCore on_host() { return {options(Backend::cpu), {}, {make_cpu_detector, {}, ""}}; }
  /// The GPU where that is under test, else the pretended device.
  LoadedCore on_device(Backend wanted = Backend::cuda) {
    if (backend_under_test() == Backend::cuda) return {options(wanted), log(), machine_factories(options(wanted))};
    DetectorFactories factories = {make_cpu_detector, [] { return std::make_unique<CopyingDevice>(); }, ""};
    factories.make_reader = [this] { return std::make_unique<HostReader>(fails_); };
    return {options(wanted), log(), std::move(factories)};
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
  static QueryOptions looking_for(Detection detection) {
    QueryOptions options;
    options.detection = detection;
    return options;
  }

  bool fails_ = false;
  std::vector<std::string> warnings_;
};

TEST_F(DevicePositionsTest, give_the_contacts_of_the_host_s) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    for (const Form& form : {Form{false, 0}, Form{false, 4}, Form{true, 0}, Form{true, 40}}) {
      LoadedCore host = on_host();
      LoadedCore device = on_device();
      for (std::uint64_t i = 0; i < 2; ++i) {
        const Mesh cloth = crumpled_cloth(50, 50, 0.1, 0.08, i);
        const SceneBody body = moving(cloth, jittered(cloth.positions, 0.05, i), everything(0.005F));
        host.add(body);
        device.add(body);
        host.set(i, body, form, true, false);
        device.set(i, body, form, true, true);
      }
      const std::vector<Contact> expected = host.detect(looking_for(detection));
      ASSERT_GT(expected.size(), 100U);
      EXPECT_TRUE(identical(expected, device.detect(looking_for(detection))));
    }
  }
  EXPECT_TRUE(warnings_.empty());
}

/// Bodies that come, go and are given positions here and there, in any form, queries that look elsewhere, scenes far
/// away, vertices that are not finite.
TEST_F(DevicePositionsTest, give_the_contacts_of_the_host_s_whatever_happens) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  std::size_t contact_count = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Random random(seed);
    LoadedCore host = on_host();
    LoadedCore device = on_device();
    Scene bodies;
    Vec3d offset{0, 0, 0};
    for (int step = 0; step < 12; ++step) {
      const auto add = [&] {
        bodies.push_back(soup(random.bits(), 20 + random.below(100)));
        host.add(bodies.back());
        device.add(bodies.back());
      };
      const auto set = [&](std::size_t i) {
        SceneBody body = bodies[i];
        body.x_t0 = translated(body.x_t0, offset);
        body.x_t1 = translated(body.x_t1, offset);
        if (random.chance(0.1)) body.x_t1[random.below(static_cast<std::uint32_t>(body.x_t1.size()))].y = kNaN;
        if (random.chance(0.1)) body.x_t0[random.below(static_cast<std::uint32_t>(body.x_t0.size()))].x = kNaN;
        const Form form = {random.chance(0.5), 8 * random.below(3)};
        const bool moves = random.chance(0.7);
        host.set(i, body, form, moves, false);
        device.set(i, body, form, moves, random.chance(0.7));
      };
      if (bodies.size() < 2 || random.chance(0.2)) add();
      if (bodies.size() > 2 && random.chance(0.2)) {
        bodies.pop_back();
        host.remove_last();
        device.remove_last();
      }
      if (random.chance(0.3)) offset = random.chance(0.5) ? Vec3d{0, 0, 0} : 3000.0 * random.direction();
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        if (random.chance(0.7)) set(i);
      }
      QueryOptions options = looking_for(random.chance(0.5) ? Detection::ccd : Detection::dcd);
      options.accuracy = random.chance(0.5) ? Accuracy::conservative : Accuracy::precise;
      if (options.detection == Detection::dcd) {
        if (random.chance(0.3)) {
          options.step_end = StepEnd::t0;
        } else if (random.chance(0.3)) {
          options.motion_margin = 0.5F;
        }
      }
      const std::vector<Contact> expected = host.detect(options);
      contact_count += expected.size();
      ASSERT_TRUE(identical(expected, device.detect(options))) << "seed " << seed << ", step " << step;
    }
  }
  EXPECT_GT(contact_count, 5000U);
}

TEST_F(DevicePositionsTest, are_looked_at_where_they_are_until_they_are_set_again) {
  LoadedCore host = on_host();
  LoadedCore device = on_device();
  for (std::uint64_t i = 0; i < 3; ++i) {
    const SceneBody body = soup(i);
    host.add(body);
    device.add(body);
    host.set(i, body, {}, true, false);
    device.set(i, body, {}, true, true);
  }
  EXPECT_TRUE(identical(host.detect(looking_for(Detection::dcd)), device.detect(looking_for(Detection::dcd))));
  // The others' places and the scene's origin move, and t0 is looked at for the first time.
  for (LoadedCore* const core : {&host, &device}) {
    SceneBody far_away = soup(7, 1000);
    core->scene().remove_body(core->ids()[0]);
    core->scene().update_body(core->ids()[1],
                              {far_away.triangles, static_cast<std::uint32_t>(far_away.x_t1.size()), everything()});
    EXPECT_EQ(core->detect(looking_for(Detection::ccd)).empty(), false);
  }
  EXPECT_TRUE(identical(host.detect(looking_for(Detection::ccd)), device.detect(looking_for(Detection::ccd))));
}

TEST_F(DevicePositionsTest, are_read_by_the_host_where_a_vertex_is_not_finite) {
  LoadedCore host = on_host();
  LoadedCore device = on_device();
  SceneBody body = soup(3);
  body.x_t1[5].z = std::numeric_limits<double>::infinity();
  for (LoadedCore* const core : {&host, &device}) core->add(body);
  host.set(0, body, {}, true, false);
  device.set(0, body, {}, true, true);
  const std::vector<Contact> expected = host.detect(looking_for(Detection::ccd));
  EXPECT_TRUE(identical(expected, device.detect(looking_for(Detection::ccd))));
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_THAT(warnings_[0], testing::HasSubstr("vertex 5 is not finite"));
  EXPECT_EQ(device.query().statistics().backend, Backend::cuda);
}

TEST_F(DevicePositionsTest, go_to_the_device_however_few_there_are) {
  LoadedCore device = on_device(Backend::automatic);
  const SceneBody body = soup(3, 10);
  device.add(body);
  device.set(0, body, {}, true, false);
  device.detect(looking_for(Detection::ccd));
  EXPECT_EQ(device.query().statistics().backend, Backend::cpu);
  device.set(0, body, {}, true, true);
  device.detect(looking_for(Detection::ccd));
  EXPECT_EQ(device.query().statistics().backend, Backend::cuda);
}

TEST_F(DevicePositionsTest, are_tried_again_after_the_device_has_failed) {
  if (backend_under_test() == Backend::cuda) GTEST_SKIP() << "what fails is pretended";
  LoadedCore host = on_host();
  LoadedCore device = on_device();
  for (std::uint64_t i = 0; i < 2; ++i) {
    const SceneBody body = soup(i);
    host.add(body);
    device.add(body);
    host.set(i, body, {true, 0}, true, false);
    device.set(i, body, {true, 0}, true, i == 0);
  }
  fails_ = true;
  try {
    device.detect(looking_for(Detection::ccd));
    ADD_FAILURE() << "no exception";
  } catch (const BackendError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("fell off the bus"));
    EXPECT_THAT(error.what(), testing::HasSubstr("could not be read"));
  }
  EXPECT_THROW(device.set(1, soup(1), {true, 0}, true, true), BackendError);
  fails_ = false;
  EXPECT_TRUE(identical(host.detect(looking_for(Detection::ccd)), device.detect(looking_for(Detection::ccd))));
}

TEST_F(DevicePositionsTest, are_refused_where_there_is_no_device) {
  LoadedCore host = on_host();
  const SceneBody body = soup(1);
  host.add(body);
  EXPECT_THROW(host.set(0, body, {}, true, true), BackendError);
  std::vector<Vec3f> x(body.x_t1.size());
  const Positions on_the_host = x;
  const Positions on_a_device = Positions::on_device(&x.data()->x, x.size(), sizeof(Vec3f));
  LoadedCore device = on_device();
  device.add(body);
  EXPECT_THROW(device.scene().set_positions(device.ids()[0], on_the_host, on_a_device), InvalidInput);
  if (backend_under_test() == Backend::cuda) {
    EXPECT_THROW(device.scene().set_positions(device.ids()[0], on_a_device, on_a_device), InvalidInput);
  }
}

TEST_F(DevicePositionsTest, contacts_stay_on_the_device) {
  LoadedCore host = on_host();
  LoadedCore device = on_device();
  const SceneBody body = soup(2, 500);
  host.add(body);
  device.add(body);
  host.set(0, body, {}, true, false);
  device.set(0, body, {}, true, true);
  QueryOptions options = looking_for(Detection::ccd);
  const std::vector<Contact> expected = host.detect(options);
  options.contacts_on_device = true;
  device.query().set_options(options);
  for (int repetition = 0; repetition < 4; ++repetition) {
    device.set(0, body, {}, true, true);
    const DeviceContacts found = device.query().wait_on_device(device.query().start(Pairs::all));
    ASSERT_EQ(found.count, expected.size());
    const std::vector<std::byte> bytes = read_device(backend_under_test(), found.data, found.count * sizeof(Contact));
    EXPECT_EQ(std::memcmp(bytes.data(), expected.data(), bytes.size()), 0);
    EXPECT_EQ(device.query().statistics().vt_contacts, host.query().statistics().vt_contacts);
    EXPECT_EQ(device.query().statistics().ee_contacts, host.query().statistics().ee_contacts);
    EXPECT_THROW(device.query().wait_on_device(1), Error) << "once";
  }
  EXPECT_THROW(device.query().wait(device.query().start(Pairs::all)), Error);
  host.query().set_options(options);
  EXPECT_THROW(host.query().start(Pairs::all), BackendError);
}

}  // namespace
}  // namespace softcd::test
