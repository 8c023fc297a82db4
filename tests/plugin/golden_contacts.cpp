#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <vector>

#include "mesh_generators.hpp"
#include "scene.hpp"

// Contacts are the same bytes from version to version, until somebody means to change them: a hash that differs is a
// defect, or is replaced together with a reason. Scenes are made with + - * / and square roots only, so that they are
// the same on every machine.
namespace softcd::test {
namespace {

/// FNV-1a.
std::uint64_t hash_of(const std::vector<Contact>& contacts) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const Contact& contact : contacts) {
    unsigned char bytes[sizeof(Contact)];
    std::memcpy(bytes, &contact, sizeof(Contact));
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001B3U;
  }
  return hash;
}

SceneBody soup_body(double half_extent, double largest, std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 300;
  options.half_extent = half_extent;
  options.largest = largest;
  options.joined_share = 0.4;
  options.degenerate_share = 0.05;
  options.needle_share = 0.05;
  options.seed = seed;
  const Mesh mesh = triangle_soup(options);
  return moving(mesh, scattered(mesh, 0.5, seed + 100), everything(0.01F));
}

Scene soups() {
  return {soup_body(2.0, 0.4, 1), soup_body(2.0, 0.4, 2), soup_body(2.0, 3.0, 3)};
}

/// Positions that are no floats.
Scene roughened_soups() {
  Scene scene = soups();
  for (SceneBody& body : scene) {
    body.x_t0 = jittered(body.x_t0, 1e-3, 7);
    body.x_t1 = jittered(body.x_t1, 1e-3, 8);
  }
  return scene;
}

/// So far from the origin that it is shifted.
Scene distant_soups() {
  Scene scene = roughened_soups();
  for (SceneBody& body : scene) {
    body.x_t0 = translated(body.x_t0, {1000.0, -3000.0, 0.5});
    body.x_t1 = translated(body.x_t1, {1000.0, -3000.0, 0.5});
  }
  return scene;
}

Scene ball_through_sheets() {
  const Mesh sheet = grid_cloth(24, 24, 0.1);
  const Mesh ball = moved(icosphere(3, 0.4), {1.1, 1.2, 0.9});
  BodySettings sheet_settings = everything(0.02F);
  sheet_settings.self_collision = false;
  BodySettings ground = everything(0.03F);
  ground.self_collision = false;
  ground.kinematic = true;
  const Mesh plate = moved(scaled(grid_cloth(3, 3, 1.0), 2.0), {-1.0, -1.0, -0.31});
  return {moving(sheet, jittered(translated(sheet.positions, {0.01, 0.02, -0.3}), 0.02, 5), sheet_settings),
          moving(ball, translated(ball.positions, {-0.1, 0.05, -0.9}), everything(0.02F)), still(plate, ground)};
}

/// Some vertices are not finite, at one end of the step or the other.
Scene strays() {
  Scene scene = soups();
  scene[0].x_t1[17].y = std::numeric_limits<double>::quiet_NaN();
  scene[0].x_t1[40].x = std::numeric_limits<double>::infinity();
  scene[1].x_t0[3].z = 1e38;
  return scene;
}

struct Way {
  const char* name;
  Detection detection;
  Accuracy accuracy;
  ContactRule rule = ContactRule::distance;
  float motion_margin = 0.0F;
};

constexpr Way kWays[] = {
    {"dcd fast", Detection::dcd, Accuracy::fast},
    {"dcd precise", Detection::dcd, Accuracy::precise},
    {"dcd conservative", Detection::dcd, Accuracy::conservative},
    {"dcd slab", Detection::dcd, Accuracy::precise, ContactRule::slab},
    {"dcd motion margin", Detection::dcd, Accuracy::precise, ContactRule::distance, 2.0F},
    {"ccd fast", Detection::ccd, Accuracy::fast},
    {"ccd precise", Detection::ccd, Accuracy::precise},
    {"ccd conservative", Detection::ccd, Accuracy::conservative},
};
constexpr std::size_t kWayCount = std::size(kWays);

/// Contacts and their hash, for each of kWays.
struct Golden {
  std::size_t contacts;
  std::uint64_t hash;
};

void expect_golden(const Scene& scene, const Golden (&golden)[kWayCount]) {
  for (std::size_t i = 0; i < kWayCount; ++i) {
    const Way& way = kWays[i];
    PipelineOptions options = test_options(way.detection);
    options.accuracy = way.accuracy;
    options.contact_rule = way.rule;
    options.motion_margin = way.motion_margin;
    const std::vector<Contact> contacts = detect_once(scene, options);
    EXPECT_EQ(contacts.size(), golden[i].contacts) << way.name;
    EXPECT_EQ(hash_of(contacts), golden[i].hash)
        << way.name << ": {" << contacts.size() << ", 0x" << std::hex << hash_of(contacts) << "}";
  }
}

TEST(GoldenContacts, soups) {
  expect_golden(soups(), {{4078, 0xab5706a20c932bb1U},
                          {4078, 0x94622b8ac417df72U},
                          {4078, 0x94622b8ac417df72U},
                          {4089, 0x4eebe3545b0f44e1U},
                          {10755, 0x1b622db7b326e14U},
                          {8176, 0x56f6054d303a955aU},
                          {8172, 0x6a1c072f33a7b6a9U},
                          {8230, 0x5b1347550bd90863U}});
}
TEST(GoldenContacts, roughened_soups) {
  expect_golden(roughened_soups(), {{4074, 0xf2ef5f44acd7d60U},
                                    {4074, 0x4798aceccce5a73eU},
                                    {4074, 0x4798aceccce5a73eU},
                                    {4082, 0x733487fae820d33aU},
                                    {10767, 0x46b52ceaaa9e9b39U},
                                    {8179, 0x78763c1bfeadbf16U},
                                    {8175, 0x21d79a3097daf5b5U},
                                    {8232, 0xe82d4c985762ff4aU}});
}
TEST(GoldenContacts, distant_soups) {
  expect_golden(distant_soups(), {{4074, 0xcd3742579c206771U},
                                  {4074, 0x14e697b9d2e32247U},
                                  {4074, 0x14e697b9d2e32247U},
                                  {4082, 0xf844f2290509cb61U},
                                  {10767, 0xc739134ffb715ad2U},
                                  {8179, 0x886455027f8e601bU},
                                  {8175, 0xc4931cabbbbab15cU},
                                  {8232, 0x35c7c10b55789dafU}});
}
TEST(GoldenContacts, ball_through_sheets) {
  expect_golden(ball_through_sheets(), {{1789, 0x50ae1d626005436cU},
                                        {1789, 0x6d5962e300a119f8U},
                                        {1789, 0x6d5962e300a119f8U},
                                        {9432, 0x87e8b8d25734220cU},
                                        {416236, 0xe973a00b2c11ca5fU},
                                        {2211, 0x2ae0acfe1bf3bac2U},
                                        {2211, 0xbb350e9729188384U},
                                        {2267, 0xb254aa83751dc02eU}});
}
TEST(GoldenContacts, strays) {
  expect_golden(strays(), {{4066, 0x6908e80569a3bccdU},
                           {4066, 0x1227b71fd54aec62U},
                           {4066, 0x1227b71fd54aec62U},
                           {4077, 0x1204bd2ccd412149U},
                           {10735, 0x942463554e4c7fd5U},
                           {8153, 0x4ce25b5aa73b788dU},
                           {8149, 0x533582a60a6a8f06U},
                           {8207, 0x6835b527680bd757U}});
}

}  // namespace
}  // namespace softcd::test
