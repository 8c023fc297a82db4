#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

#include <string>

#include "softcd/bullet/world_probe.hpp"

/// Questions about a client's soft bodies. Bodies have PyBullet's unique ids in questions and answers.
namespace softcd::bullet::pybullet {

/// Returns the results of a batch of questions for softcd::Probe. `name` is that of Python's function, for example
/// first_hits; `questions` are the bytes of its structs, for pairs of bodies two 32-bit integers each. Results are
/// the structs of the answers; lists of results have their begins first. -1 stands for no body in answers and for all
/// bodies in questions. Throws InvalidInput where the client has no such body.
std::string ask(WorldProbe& bodies, const btDynamicsWorld& world, const std::string& name,
                const std::string& questions);

/// Returns the pairs of features of a body and of other objects that are at most `max_distance` apart between their
/// margins, if one of both bodies is soft; see WorldProbe::contact_test(). Throws InvalidInput where the client has no
/// such body.
std::string bytes_of_near_features(WorldProbe& bodies, btDynamicsWorld& world, int body, double max_distance);

/// Returns position, velocity and mass of each node as seven doubles. The mass of a held node is 0.
std::string bytes_of_nodes(const btSoftBody& body);

/// Returns the three nodes of each face as 32-bit integers.
std::string bytes_of_faces(const btSoftBody& body);

}  // namespace softcd::bullet::pybullet
