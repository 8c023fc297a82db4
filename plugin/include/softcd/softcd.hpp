#pragma once

/// softcd: collision detection between deformable triangle meshes. This header is the whole public interface. It needs
/// neither CUDA nor Bullet and is valid C++17.
///
/// Positions in, contacts out:
///
///     softcd::CollisionPipeline pipeline;
///     const softcd::BodyId cloth = pipeline.scene.add_body({triangles, vertex_count});
///     pipeline.scene.set_positions(cloth, positions);
///     for (const softcd::Contact& contact : pipeline.detect()) { ... }
///
/// A pipeline is one Scene with one Query. A scene may have several queries, which find different contacts:
///
///     softcd::Scene scene;
///     softcd::Query contacts(scene, options), crossings(scene, other_options);
///     softcd::Ticket ticket = contacts.start();
///     scene.set_positions(cloth, next_positions);  // for the next detection
///     for (const softcd::Contact& contact : ticket.wait()) { ... }
///
/// A Probe answers spatial questions: rays, nearest points and overlaps:
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
