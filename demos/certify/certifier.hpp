#pragma once

#include <functional>
#include <string>
#include <vector>

#include "certificate.hpp"
#include "mesh_sequence.hpp"
#include "softcd/softcd.hpp"

namespace softcd::demo {

/// Tests a sequence of frames. Mesh 0 is compared with itself and with all others, which are still if they have one
/// frame. `show` receives the progress, `log` the library's messages. Throws MeshError.
Certificate certify(const CertifyOptions& options, const SceneOptions& scene, std::vector<MeshSequence> meshes,
                    const std::function<void(const std::string&)>& show, const LogCallback& log);

}  // namespace softcd::demo
