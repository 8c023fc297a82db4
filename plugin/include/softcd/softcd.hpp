#pragma once

/// softcd: collision detection between deformable triangle meshes. This header is the whole public
/// interface; it needs neither CUDA nor Bullet and is valid C++17.
///
/// Positions in, contacts out:
///
///     softcd::CollisionPipeline pipeline;
///     const softcd::BodyId cloth = pipeline.add_body({triangles, vertex_count});
///     pipeline.set_positions(cloth, positions);
///     for (const softcd::Contact& contact : pipeline.detect()) { ... }
///
/// A pipeline is one Scene with one Query. Several questions about the same bodies are several queries on one scene:
///
///     softcd::Scene scene;
///     softcd::Query contacts(scene, options), crossings(scene, other_options);
///     softcd::Ticket ticket = contacts.start();
///     scene.set_positions(cloth, next_positions);  // of the next detection
///     for (const softcd::Contact& contact : ticket.wait()) { ... }
///
/// What is at a place, rays and nearest points, a Probe tells:
///
///     softcd::Probe probe(scene);
///     const softcd::RayHit hit = probe.first_hit({eye, direction});

#include "softcd/collision_pipeline.hpp"
#include "softcd/communicator.hpp"
#include "softcd/error.hpp"
#include "softcd/positions.hpp"
#include "softcd/probe.hpp"
#include "softcd/query.hpp"
#include "softcd/scene.hpp"
#include "softcd/version.hpp"
