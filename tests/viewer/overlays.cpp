#include "viewer/overlays.hpp"

#include <gtest/gtest.h>

#include "grid_scenes.hpp"
#include "viewer/session.hpp"

namespace softcd::demo {
namespace {

constexpr std::size_t kEdgesOfABox = 12;

Session touching_cloths() {
  SceneOptions options;
  options.size = 12;
  options.settings.backend = Backend::cpu;
  Session session("two-cloths", options);
  for (int i = 0; i < 60; ++i) session.step();
  return session;
}

TEST(Overlays, colours_go_from_blue_to_red) {
  const Rgba least = color_of_tests(0, 100);
  const Rgba most = color_of_tests(100, 100);
  EXPECT_GT(least[2], least[0]);
  EXPECT_GT(most[0], most[2]);
  EXPECT_EQ(color_of_tests(0, 0), least);
}

TEST(Overlays, draw_a_box_for_each_cell) {
  const Session session = touching_cloths();
  const auto grid = session.make_grid();
  OverlayGeometry geometry;
  append_cells(*grid, geometry);
  EXPECT_EQ(geometry.lines.size(), grid->cells().size() * kEdgesOfABox * 2);
  EXPECT_EQ(geometry.triangles.size() % 36, 0U);
  EXPECT_GT(geometry.triangles.size(), 0U);
  EXPECT_LT(geometry.triangles.size() / 36, grid->cells().size()) << "cells without tests have edges only";
}

TEST(Overlays, draw_a_line_for_each_contact) {
  const Session session = touching_cloths();
  OverlayGeometry geometry;
  append_contacts(session.bodies(), geometry);
  EXPECT_GT(session.scene().count_contacts(), 0U);
  EXPECT_EQ(geometry.bright_lines.size(), session.scene().count_contacts() * 3 * 2);
}

TEST(Overlays, colour_contacts_by_depth_and_time_of_impact) {
  bullet::BodyPairContacts pair;
  const Session session = touching_cloths();
  pair.a = session.bodies().front();
  pair.contacts.resize(2);
  pair.contacts[0].depth = pair.a->getCollisionShape()->getMargin();
  pair.contacts[1].time_of_impact = 0;
  const Rgba red = color_of_tests(1, 1);
  const Rgba blue = color_of_tests(0, 1);
  OverlayGeometry by_depth, by_time;
  append_contacts({pair}, ContactColor::depth, by_depth);
  append_contacts({pair}, ContactColor::time_of_impact, by_time);
  EXPECT_EQ(by_depth.bright_lines[0].color, red);
  EXPECT_EQ(by_depth.bright_lines[6].color, blue);
  EXPECT_EQ(by_time.bright_lines[0].color, blue);
  EXPECT_EQ(by_time.bright_lines[6].color, red);
}

TEST(Overlays, draw_the_cells_of_a_whole_triangle) {
  const Session session = touching_cloths();
  const auto grid = session.make_grid();
  const std::uint32_t triangle = grid->first_triangle(1) + 100;
  OverlayGeometry geometry;
  append_triangle(*grid, triangle, geometry);
  EXPECT_EQ(geometry.lines.size(), grid->cells_of(triangle).size() * kEdgesOfABox * 2);
  EXPECT_GT(geometry.lines.size(), 0U);
}

TEST(Overlays, draw_the_children_of_a_split_triangle) {
  const test::Scene scene = uneven_soup();
  const DetectionGrid grid(grid_bodies(scene), on_cpu(Detection::ccd));
  std::uint32_t triangle = 0;
  while (grid.children_of(triangle).empty()) ++triangle;
  OverlayGeometry geometry;
  append_triangle(grid, triangle, geometry);
  EXPECT_EQ(geometry.lines.size(), grid.children_of(triangle).size() * 3 * 2);
  EXPECT_TRUE(geometry.triangles.empty());
}

}  // namespace
}  // namespace softcd::demo
