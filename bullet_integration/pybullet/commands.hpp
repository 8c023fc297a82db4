#pragma once

#include <string>
#include <string_view>

#include "session.hpp"

namespace softcd::bullet::pybullet {

/// Executes a plugin's command, as python/softcd/_bullet_plugin.py sends it, and returns its answer. `input` are the
/// bytes that came with it. A client cannot send many at once, so it sends `input` commands first, and the command that
/// needs all of it then.
///
///     version                           of PyBullet that this was built for
///     all_settings                      JSON, see json_of_all_settings()
///     attach K=V K=V                    see read_settings()
///     set K=V K=V                       changes settings of the attachment
///     settings                          JSON
///     is_attached                       0 or 1
///     limitations                       one a line
///     finish_step
///     report, stages, messages          JSON
///     contacts                          finishes the step; the step's length in seconds as a double, then see
///                                       bytes_of_contacts()
///     impulses                          finishes the step, then see ImpulseSums::take()
///     edge_contacts                     see bytes_of_edge_contacts()
///     intersecting_bodies               see bytes_of_intersecting_bodies()
///     set_filters BODY RINGS DISTANCE   a VertexFilter for each node as input, or none
///     detach
///     input [new]                       appends to the session's input, or begins a new one
///     input_at ADDRESS SIZE             begins a new input with bytes of this process
///     soft_bodies                       their unique ids as 32-bit integers
///     nodes BODY, faces BODY            see bytes_of_nodes(), bytes_of_faces()
///     ask NAME                          questions as input, see ask()
///     near_features BODY DISTANCE       see bytes_of_near_features()
///
/// Throws softcd::Error.
std::string execute(Session& session, PhysicsCommandProcessorInterface& server, std::string_view command,
                    std::string_view input);

}  // namespace softcd::bullet::pybullet
