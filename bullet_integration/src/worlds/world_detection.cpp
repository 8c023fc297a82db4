#include "softcd/bullet/world_detection.hpp"

#include <utility>

#include "worlds/world_queries.hpp"

namespace softcd::bullet {

const Statistics& DetectorReport::statistics() const {
  return record_->statistics();
}

std::vector<StageReport> DetectorReport::explain() const {
  return record_->explain();
}

Backend DetectorReport::backend() const {
  return record_->backend();
}

std::uint64_t DetectorReport::failed_steps() const {
  return record_->failed_steps();
}

WorldDetection::WorldDetection(const WorldKind& kind, const Settings& settings)
    : queries_(std::make_unique<WorldQueries>(kind, settings)) {}

WorldDetection::~WorldDetection() = default;

const Settings& WorldDetection::settings() const {
  return queries_->settings();
}

void WorldDetection::set_settings(const Settings& settings) {
  queries_->set_settings(settings);
}

void WorldDetection::set_filters(const btSoftBody& body, BodyFilters filters) {
  queries_->mirror.set_filters(body, std::move(filters));
}

void WorldDetection::forget_ray_positions() {
  queries_->rays.forget_positions();
}

DetectorReport WorldDetection::contact_report() const {
  return DetectorReport(queries_->contacts.record());
}

DetectorReport WorldDetection::crossing_report() const {
  return DetectorReport(queries_->crossings.record());
}

CrossingAnswers WorldDetection::crossing_answers() const {
  const CrossingPrevention* crossings = queries_->crossings.get();
  return crossings != nullptr ? crossings->answers() : CrossingAnswers{};
}

const std::vector<IntersectingBodies>& WorldDetection::intersecting_bodies() const {
  static const std::vector<IntersectingBodies> none;
  const Untangling* untangling = queries_->untangling.get();
  return untangling != nullptr ? untangling->pairs() : none;
}

DetectorReport WorldDetection::rigid_mesh_report() const {
  return DetectorReport(queries_->rigid_meshes.record());
}

DetectorReport WorldDetection::convex_shape_report() const {
  return DetectorReport(queries_->convex_shapes.record());
}

const std::vector<EdgeContact>& WorldDetection::edge_contacts() const {
  static const std::vector<EdgeContact> none;
  const ContactDetection* contacts = queries_->contacts.get();
  return contacts != nullptr ? contacts->edge_contacts() : none;
}

const std::vector<BodyPairContacts>& WorldDetection::body_contacts() {
  return queries_->read_out.since_last_call(queries_->broadphase());
}

}  // namespace softcd::bullet
