#include <cstring>
#include <softcd/softcd.hpp>

static_assert(SOFTCD_VERSION == 10000 * SOFTCD_VERSION_MAJOR + 100 * SOFTCD_VERSION_MINOR + SOFTCD_VERSION_PATCH);

// Returns whether an exception is caught by its base, on this side of a shared library.
bool refuses_missing_vertices() {
  try {
    softcd::CollisionPipeline().scene.add_body({std::vector<softcd::Triangle>{{{0, 1, 2}}}, 2, {}});
  } catch (const softcd::Error& error) {
    return dynamic_cast<const softcd::InvalidInput*>(&error) != nullptr;
  }
  return false;
}

// Returns whether a contact is found: one vertex of the second triangle lies 0.1 above the first triangle.
bool finds_contact() {
  const std::vector<softcd::Triangle> triangles = {{{0, 1, 2}}};
  const std::vector<softcd::Vec3f> lower = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<softcd::Vec3f> upper = {{0.25F, 0.25F, 0.1F}, {0.25F, 0.5F, 5}, {0.5F, 0.25F, 5}};
  softcd::BodySettings settings;
  settings.margin = 0.1F;

  softcd::CollisionPipeline pipeline;
  const softcd::BodyId a = pipeline.scene.add_body({triangles, 3, settings});
  const softcd::BodyId b = pipeline.scene.add_body({triangles, 3, settings});
  pipeline.scene.set_positions(a, lower);
  pipeline.scene.set_positions(b, upper);
  const softcd::Span<const softcd::Contact> contacts = pipeline.detect();
  return contacts.size() == 1 && contacts[0].body_a == b && contacts[0].feature_a == 0;
}

/// Its argument is the expected version.
int main(int count, char** arguments) {
  const bool has_version = count == 2 && std::strcmp(arguments[1], SOFTCD_VERSION_STRING) == 0;
  return has_version && refuses_missing_vertices() && finds_contact() ? 0 : 1;
}
