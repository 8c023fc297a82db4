#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "pretended_device.hpp"
#include "random.hpp"

// Positions that stay on a device give the contacts that they give on the host.
namespace softcd::test {
namespace {

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

/// Bodies come, go and get positions in any form. Queries need different ends, scenes are far away, and vertices are
/// not finite.
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
  // The others' places and the scene's origin move, and t0 is needed for the first time.
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
