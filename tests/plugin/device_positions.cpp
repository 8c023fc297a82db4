#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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
    SceneChanges none;
    none.verdict = changes.verdict;
    ForwardingDetector::set_scene(mirrored, none);
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

/// At positions that were foreseen.
struct Looks {
  int all = 0, in_vain = 0;
};

/// Reads the host's memory as if it were a device's, and fails when told to.
class HostReader final : public DevicePositionReader {
 public:
  HostReader(const bool& fails, Looks& looks) : fails_(fails), looks_(looks) {}

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
  ForeseenVerdict look(Span<const SurveyedVertices> vertices, Span<const StepSurvey> foreseen, const Foreseen& scene,
                       bool needs_t0) override {
    survey(vertices, scene.origin, needs_t0);
    StepSurvey all;
    bool is_so = true;
    for (std::size_t i = 0; i < surveys_.size(); ++i) {
      is_so = is_so && is_within(surveys_[i], foreseen[i]);
      all.merge(surveys_[i]);
    }
    ++looks_.all;
    is_so_ = is_so && is_as_foreseen(all, scene) ? 1 : 0;
    looks_.in_vain += is_so_ == 0;
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
  Looks& looks_;
  std::vector<StepSurvey> surveys_;
  std::uint32_t is_so_ = 0;
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
    factories.make_reader = [this] { return std::make_unique<HostReader>(fails_, looks_); };
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
  Looks looks_;  ///< of the pretended device
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

/// Two bodies that move slowly, the same in both scenes.
class ForeseenPositionsTest : public DevicePositionsTest {
 protected:
  void SetUp() override {
    for (std::uint64_t i = 0; i < 2; ++i) {
      bodies_.push_back(soup(i, 150));
      host_.add(bodies_.back());
      device_.add(bodies_.back());
    }
  }

  void set(std::size_t i, bool moves = true) {
    host_.set(i, bodies_[i], form_, moves, false);
    device_.set(i, bodies_[i], form_, moves, true);
  }
  void move(std::size_t i, const Vec3d& by) {
    bodies_[i].x_t0 = std::exchange(bodies_[i].x_t1, translated(bodies_[i].x_t1, by));
  }
  /// A step of both, and a detection.
  void step(const Vec3d& by) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      move(i, i == 0 ? by : -1.0 * by);
      set(i);
    }
    detect();
  }
  void detect() {
    const std::vector<Contact> expected = host_.detect(options_);
    contact_count_ += expected.size();
    ASSERT_TRUE(identical(expected, device_.detect(options_)));
    EXPECT_EQ(device_.query().statistics().vt_contacts, host_.query().statistics().vt_contacts);
  }
  void expect_in_vain(int looks) {
    if (backend_under_test() == Backend::cuda) return;
    EXPECT_EQ(looks_.in_vain, looks);
  }
  void expect_looks(int all, int in_vain) {
    if (backend_under_test() == Backend::cuda) return;
    EXPECT_GE(looks_.all, all);
    EXPECT_LE(looks_.in_vain, in_vain);
  }

  const Vec3d kSlowly{0.003, -0.002, 0.001};
  QueryOptions options_ = looking_for(Detection::ccd);
  Form form_;
  Scene bodies_;
  LoadedCore host_ = on_host();
  LoadedCore device_ = on_device();
  std::size_t contact_count_ = 0;
};

TEST_F(ForeseenPositionsTest, are_detected_without_looking_first) {
  for (int i = 0; i < 40; ++i) step(kSlowly);
  expect_looks(30, 1);
  for (int i = 0; i < 4; ++i) step({0, 0, 0});
  form_.is_double = true;
  const int before = looks_.all;
  for (int i = 0; i < 4; ++i) step(kSlowly);
  EXPECT_EQ(looks_.all, before) << "what becomes of doubles depends on the scene's origin";
  EXPECT_GT(contact_count_, 1000U);
}

TEST_F(ForeseenPositionsTest, are_looked_at_again_where_they_are_not_as_foreseen) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto settle = [&] {
    for (int i = 0; i < 12; ++i) step(kSlowly);
  };
  settle();
  step({0.7, 0.1, 0.2});
  settle();
  for (int i = 0; i < 2; ++i) {  // far away, so that the scene's origin moves, and back
    for (SceneBody& body : bodies_) {
      body.x_t1 = body.x_t0 = translated(body.x_t1, i == 0 ? Vec3d{900, 0, 0} : Vec3d{-900, 0, 0});
    }
    settle();
  }
  const Vec3d x = std::exchange(bodies_[0].x_t1[7], {kNaN, 0, 0});
  set(0);
  detect();
  bodies_[0].x_t1[7] = x;
  settle();
  step({0, 0, 0});
  step({0, 0, 0});  // nothing moves
  for (std::size_t b = 0; b < 2; ++b) set(b, false);
  detect();
  settle();
  EXPECT_GT(looks_.in_vain + (backend_under_test() == Backend::cuda ? 1 : 0), 0);
}

TEST_F(ForeseenPositionsTest, do_not_outlive_what_else_changes) {
  Random random(5);
  for (int i = 0; i < 80; ++i) {
    if (random.chance(0.05)) {
      bodies_.push_back(soup(random.bits(), 30));
      for (LoadedCore* const core : {&host_, &device_}) core->add(bodies_.back());
      set(bodies_.size() - 1);
    }
    if (random.chance(0.05)) {
      const auto b = random.below(static_cast<std::uint32_t>(bodies_.size()));
      bodies_[b].settings.margin = static_cast<float>(random.uniform(0.01, 0.2));
      for (LoadedCore* const core : {&host_, &device_}) core->scene().set_settings(core->ids()[b], bodies_[b].settings);
    }
    if (random.chance(0.1)) {
      options_ = looking_for(random.chance(0.5) ? Detection::ccd : Detection::dcd);
      if (random.chance(0.5)) options_.motion_margin = options_.detection == Detection::dcd ? 0.5F : 0.0F;
    }
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (i % 20 > 15 && b == 1) continue;  // not every body in every step
      move(b, random.chance(0.02) ? 0.5 * random.direction() : kSlowly);
      set(b);
    }
    ASSERT_NO_FATAL_FAILURE(detect()) << "step " << i;
  }
  expect_looks(15, 30);
}

TEST_F(ForeseenPositionsTest, may_be_set_for_the_next_step_while_a_detection_runs) {
  for (int times = 0; times < 2; ++times) {
    for (int i = 0; i < 40; ++i) step(kSlowly);  // whatever was in vain before
    const int before = looks_.in_vain;
    for (std::size_t b = 0; b < 2; ++b) {
      move(b, {0.6, 0, 0});  // not as foreseen
      set(b);
    }
    const std::vector<Contact> expected = host_.detect(options_);
    const std::uint64_t number = device_.query().start(Pairs::all);
    for (std::size_t b = 0; b < 2; ++b) {
      move(b, {0, 0.3, 0});
      if (times == 0) set(b);
    }
    for (LoadedCore* const core : {&host_, &device_}) core->scene().set_settings(core->ids()[0], everything(0.2F));
    const Span<const Contact> found = device_.query().wait(number);
    ASSERT_TRUE(identical(expected, found));
    expect_in_vain(before + 1);
    detect();
  }
}

/// Two flat sheets, the second above the first, which come so near each other that they touch within what was foreseen
/// of the second alone.
TEST_F(DevicePositionsTest, foreseen_of_some_bodies_are_not_taken_for_those_of_others) {
  LoadedCore host = on_host();
  LoadedCore device = on_device();
  const Mesh sheet = grid_cloth(5, 5, 0.25);
  BodySettings settings = everything(0.005F);
  settings.self_collision = false;
  std::vector<SceneBody> bodies;
  for (int b = 0; b < 2; ++b) {
    bodies.push_back(still(moved(sheet, {0, 0, 0.028 * b}), settings));
    for (LoadedCore* const core : {&host, &device}) core->add(bodies.back());
  }
  const auto set = [&](std::size_t b, const Vec3d& by) {
    bodies[b].x_t1 = translated(bodies[b].x_t0, by);
    host.set(b, bodies[b], {}, true, false);
    device.set(b, bodies[b], {}, true, true);
    bodies[b].x_t0 = bodies[b].x_t1;
  };
  const auto detect = [&](bool touch) {
    const std::vector<Contact> expected = host.detect(looking_for(Detection::ccd));
    EXPECT_EQ(expected.empty(), !touch);
    EXPECT_TRUE(identical(expected, device.detect(looking_for(Detection::ccd))));
  };
  const Vec3d down = {0, 0, -0.005};
  const Vec3d nowhere = {0, 0, 0};
  for (int i = 0; i < 2; ++i) {
    set(0, nowhere);
    set(1, down);
    detect(false);
  }
  set(0, nowhere);
  detect(false);
  set(0, nowhere);
  set(1, 1.9 * down);
  detect(true);
  EXPECT_EQ(looks_.in_vain, 0);
}

/// Two bodies far apart, one of which is suddenly where the other one is.
TEST_F(DevicePositionsTest, that_come_together_from_far_away_are_not_missed) {
  LoadedCore host = on_host();
  LoadedCore device = on_device();
  std::vector<SceneBody> bodies = {soup(1, 100), soup(2, 100)};
  for (SceneBody& body : bodies) {
    body.settings.self_collision = false;
    for (LoadedCore* const core : {&host, &device}) core->add(body);
  }
  for (int i = 0; i < 9; ++i) {
    for (std::size_t b = 0; b < 2; ++b) {
      const Vec3d by = b == 1 && i < 8 ? Vec3d{30, 0, 0} : Vec3d{0, 0.002 * i, 0};
      SceneBody body = bodies[b];
      body.x_t0 = body.x_t1 = translated(body.x_t1, by);
      body.x_t1[0].z += 0.01;
      host.set(b, body, {}, true, false);
      device.set(b, body, {}, true, true);
    }
    const std::vector<Contact> expected = host.detect(looking_for(Detection::ccd));
    EXPECT_EQ(expected.empty(), i < 8);
    EXPECT_TRUE(identical(expected, device.detect(looking_for(Detection::ccd)))) << "step " << i;
  }
}

/// The scene's origin follows its extent, though no body leaves where it was foreseen.
TEST_F(ForeseenPositionsTest, are_looked_at_again_where_the_origin_moves) {
  options_.accuracy = Accuracy::fast;
  double low = 1e9;
  double high = -1e9;
  for (const SceneBody& body : bodies_) {
    for (const Vec3d& x : body.x_t1) {
      low = std::min(low, x.x);
      high = std::max(high, x.x);
    }
  }
  // From half its width from 0 on a scene is far away.
  const double offset = 0.5 * (high - low) - low - 0.03;
  for (SceneBody& body : bodies_) body.x_t0 = body.x_t1 = translated(body.x_t1, {offset, 0, 0});
  for (int i = 0; i < 30; ++i) {
    for (std::size_t b = 0; b < 2; ++b) {
      move(b, {0.003, 0, 0});
      set(b);
    }
    detect();
  }
  EXPECT_GE(looks_.in_vain, backend_under_test() == Backend::cuda ? 0 : 1);
}

TEST_F(ForeseenPositionsTest, say_on_the_device_whether_they_were_not_as_foreseen) {
  options_.contacts_on_device = true;
  device_.query().set_options(options_);
  QueryOptions on_the_host = options_;
  on_the_host.contacts_on_device = false;
  for (int i = 0; i < 20; ++i) {
    for (std::size_t b = 0; b < 2; ++b) {
      move(b, i == 15 ? Vec3d{0.6, 0, 0} : kSlowly);
      set(b);
    }
    const std::vector<Contact> expected = host_.detect(on_the_host);
    const DeviceContacts found = device_.query().wait_on_device(device_.query().start(Pairs::all));
    ASSERT_EQ(found.count, expected.size()) << "step " << i;
    const std::vector<std::byte> bytes = read_device(backend_under_test(), found.data, found.count * sizeof(Contact));
    EXPECT_EQ(std::memcmp(bytes.data(), expected.data(), bytes.size()), 0) << "step " << i;
  }
  expect_looks(10, 2);
}

/// Everything that a query has found on the device, on the host.
struct ReadContacts {
  explicit ReadContacts(const DeviceContacts& found)
      : bytes(read_device(backend_under_test(), found.data, found.count * sizeof(Contact))),
        ranges(read_device(backend_under_test(), found.body_begin,
                           (2 * std::size_t{found.body_ids} + 1) * sizeof(std::uint64_t))),
        contacts(reinterpret_cast<const Contact*>(bytes.data()), found.count),
        body_begin(reinterpret_cast<const std::uint64_t*>(ranges.data()), ranges.size() / sizeof(std::uint64_t)) {}

  std::vector<std::byte> bytes, ranges;
  Span<const Contact> contacts;
  Span<const std::uint64_t> body_begin;
};

TEST_F(DevicePositionsTest, contacts_of_each_body_lie_where_their_ranges_say) {
  LoadedCore device = on_device();
  for (std::uint64_t i = 0; i < 6; ++i) device.add(soup(i, 120));
  device.scene().remove_body(device.ids()[2]);
  for (std::uint64_t i = 0; i < 6; ++i) {
    if (i != 2) device.set(i, soup(i, 120), {}, true, true);
  }
  QueryOptions options = looking_for(Detection::ccd);
  options.contacts_on_device = true;
  device.query().set_options(options);
  const DeviceContacts found = device.query().wait_on_device(device.query().start(Pairs::all));
  const ReadContacts read(found);
  ASSERT_EQ(found.body_ids, 6U);
  ASSERT_EQ(read.body_begin.size(), 13U);
  EXPECT_EQ(read.body_begin[0], 0U);
  EXPECT_EQ(read.body_begin[12], found.count);
  for (std::uint32_t range = 0; range < 12; ++range) {
    const auto kind = static_cast<ContactKind>(range / 6);
    const std::uint32_t id = range % 6;
    const auto is_in_range = [&](const Contact& contact) { return contact.kind == kind && contact.body_a.value == id; };
    const auto count = std::count_if(read.contacts.begin(), read.contacts.end(), is_in_range);
    const std::uint64_t begin = read.body_begin[range];
    const std::uint64_t end = read.body_begin[range + 1];
    ASSERT_EQ(end - begin, static_cast<std::uint64_t>(count)) << "range " << range;
    EXPECT_EQ(count == 0, id == 2) << "range " << range;
    EXPECT_TRUE(std::all_of(read.contacts.begin() + begin, read.contacts.begin() + end, is_in_range));
  }
}

TEST_F(DevicePositionsTest, contacts_are_told_of_before_they_are_waited_for) {
  LoadedCore device = on_device();
  for (std::uint64_t i = 0; i < 2; ++i) device.add(soup(i));
  QueryOptions options = looking_for(Detection::ccd);
  EXPECT_THROW(device.query().on_device(device.query().start(Pairs::all)), Error) << "contacts go to the host";
  options.contacts_on_device = true;
  device.query().set_options(options);
  const std::uint64_t without_positions = device.query().start(Pairs::all);
  EXPECT_EQ(device.query().on_device(without_positions).counts, nullptr);
  for (int repetition = 0; repetition < 4; ++repetition) {
    for (std::uint64_t i = 0; i < 2; ++i) device.set(i, soup(i), {}, true, true);
    const std::uint64_t number = device.query().start(Pairs::all);
    const PendingContacts first = device.query().on_device(number);
    ASSERT_NE(first.counts, nullptr);
    const DeviceContacts found = device.query().wait_on_device(number);
    ASSERT_GT(found.count, 100U);
    EXPECT_THROW(device.query().on_device(number), Error) << "it was waited for";
    if (repetition == 0) continue;  // lists grow
    EXPECT_EQ(first.data, found.data);
    EXPECT_EQ(first.body_begin, found.body_begin);
    EXPECT_EQ(first.body_ids, found.body_ids);
    EXPECT_GE(first.capacity, found.count);
    const std::vector<std::byte> bytes = read_device(backend_under_test(), first.counts, sizeof(ContactCounts));
    ContactCounts counts{};
    std::memcpy(&counts, bytes.data(), bytes.size());
    EXPECT_EQ(counts.contacts, found.count);
    EXPECT_EQ(counts.is_complete, 1U);
  }
}

}  // namespace
}  // namespace softcd::test
