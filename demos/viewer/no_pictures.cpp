#include <stdexcept>

#include "viewer/picture_taker.hpp"

namespace softcd::demo {

struct PictureTaker::Renderer {};

PictureTaker::PictureTaker(const PictureOptions& /*options*/) {
  throw std::runtime_error(
      "no pictures can be drawn: this build lacks OpenGL; install libepoxy-dev and libgl1-mesa-dri (cmake/setup.sh "
      "does) "
      "and build again");
}

PictureTaker::~PictureTaker() = default;

Image PictureTaker::take(const Scene& /*scene*/) {
  return {};
}

}  // namespace softcd::demo
