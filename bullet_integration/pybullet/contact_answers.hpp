#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

#include <string>
#include <vector>

#include "softcd/bullet/body_contacts.hpp"
#include "softcd/bullet/edge_contact.hpp"
#include "softcd/bullet/world_detection.hpp"

/// A step's contacts as bytes, with PyBullet's ids of bodies. python/softcd/_bullet_contacts.py has the same structs.
namespace softcd::bullet::pybullet {

/// Returns the number of pairs, of contacts and of ended contacts, as three 64-bit integers; then the pairs, and the
/// contacts of all pairs, those that have ended behind the others. Forces are impulses over the step's length in
/// seconds. Unknown impulses and forces are NaN; those of pairs that have ended are 0.
std::string bytes_of_contacts(const std::vector<BodyPairContacts>& pairs, double step_length);

/// Returns the edge contacts of bodies that are in the world. A body may have left it since the step.
std::string bytes_of_edge_contacts(const std::vector<EdgeContact>& contacts, const btDynamicsWorld& world);

/// Returns the pairs of intersecting bodies that are in the world. A body may have left it since the step.
std::string bytes_of_intersecting_bodies(const std::vector<IntersectingBodies>& pairs, const btDynamicsWorld& world);

}  // namespace softcd::bullet::pybullet
