#include <stdexcept>

#include "viewer/viewer.hpp"

namespace softcd::demo {

void run_viewer(const std::string& /*scene_name*/, const SceneOptions& /*scene_options*/,
                const ViewerOptions& /*options*/) {
  throw std::runtime_error(
      "this build has no viewer, for want of its libraries; install libglfw3-dev, libimgui-dev and libepoxy-dev "
      "(cmake/setup.sh does) and build again");
}

}  // namespace softcd::demo
