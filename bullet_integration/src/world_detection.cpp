#include "softcd/bullet/world_detection.hpp"

#include "world_queries.hpp"

namespace softcd::bullet {

WorldDetection::WorldDetection(const WorldKind& kind, const Settings& settings)
    : queries_(std::make_unique<WorldQueries>(kind, settings)) {}

WorldDetection::~WorldDetection() = default;

const Settings& WorldDetection::settings() const {
  return queries_->settings();
}

void WorldDetection::set_settings(const Settings& settings) {
  queries_->set_settings(settings);
}

DetectorReport WorldDetection::contacts() const {
  return DetectorReport(queries_->contacts.pipeline());
}

DetectorReport WorldDetection::crossings() const {
  return DetectorReport(queries_->crossings.pipeline());
}

DetectorReport WorldDetection::rigid_meshes() const {
  return DetectorReport(queries_->rigid_meshes.pipeline());
}

const std::vector<EdgeContact>& WorldDetection::edge_contacts() const {
  return queries_->contacts.edge_contacts();
}

}  // namespace softcd::bullet
