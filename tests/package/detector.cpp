#include <softcd/softcd.hpp>

// One vertex of the second triangle lies 0.1 above the first triangle.
int main() {
  const std::vector<softcd::Triangle> triangles = {{{0, 1, 2}}};
  const std::vector<softcd::Vec3f> lower = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<softcd::Vec3f> upper = {{0.25F, 0.25F, 0.1F}, {0.25F, 0.5F, 5}, {0.5F, 0.25F, 5}};
  softcd::BodySettings settings;
  settings.margin = 0.1F;

  softcd::CollisionPipeline pipeline;
  const softcd::BodyId a = pipeline.add_body({triangles, 3, settings});
  const softcd::BodyId b = pipeline.add_body({triangles, 3, settings});
  pipeline.set_positions(a, lower);
  pipeline.set_positions(b, upper);
  const softcd::Span<const softcd::Contact> contacts = pipeline.detect();
  return contacts.size() == 1 && contacts[0].body_a == b && contacts[0].feature_a == 0 ? 0 : 1;
}
