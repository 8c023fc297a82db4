#pragma once

#include <cstdint>
#include <memory>
#include <new>

#include "softcd/pipeline/scene_on.hpp"
#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// Whether entries of the grid are patches of triangles. The uniform grid, which exists for comparison, has none.
template <class Backend, class Scheme>
bool puts_patches_into_cells(const DetectionSettings& settings) {
  return Backend::kHasPatches && Scheme::kMayHavePatches && settings.broad_phase == BroadPhase::exact;
}

/// The memory that a detector has on its backend, beside that of its queries and probes.
template <class Backend, class Scheme>
struct DetectorMemory {
  template <class... Arguments>
  explicit DetectorMemory(Arguments... arguments)
      : account(std::make_shared<MemoryAccount>()), backend(*account, arguments...) {}

  /// Releases everything but the scene and the queries' contacts.
  void release_lists() {
    backend.give_scratch_back();
    workspace = {};
    scene.release_hierarchies();
  }

  /// Runs f, which takes memory for the scene. If memory does not suffice, releases the lists and runs f again.
  template <class F>
  void with_lists_or_without(const F& f) {
    try {
      f();
    } catch (const std::bad_alloc&) {
      release_lists();
      f();
    }
  }

  std::shared_ptr<MemoryAccount> account;
  SceneOn<Backend> scene;
  Workspace<Backend, Scheme> workspace;
  Backend backend;  ///< last, so that it is destroyed first: it waits for work that uses the others
};

}  // namespace softcd
