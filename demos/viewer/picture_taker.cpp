#include "viewer/picture_taker.hpp"

#include "viewer/offscreen_context.hpp"
#include "viewer/overlay_renderer.hpp"
#include "viewer/surface_renderer.hpp"

namespace softcd::demo {

struct PictureTaker::Renderer {
  explicit Renderer(const PictureOptions& options) : canvas(options.width, options.height) {}

  OffscreenContext context;  // declared before its users, to be destroyed after them
  GlCanvas canvas;
  SurfaceRenderer surfaces;
  OverlayRenderer overlays;
};

PictureTaker::PictureTaker(const PictureOptions& options)
    : options_(options), renderer_(std::make_unique<Renderer>(options)) {}

PictureTaker::~PictureTaker() = default;

Image PictureTaker::take(const Scene& scene) {
  const OrbitCamera camera(scene.view());
  const Viewport viewport{0, options_.width, options_.height};
  OverlayGeometry geometry;
  if (options_.overlays.contacts) append_contacts(scene.simulation().bodies(), geometry);
  renderer_->overlays.update(geometry);
  renderer_->surfaces.update(scene);
  renderer_->canvas.bind();
  renderer_->surfaces.draw(camera, viewport, options_.overlays.wire);
  renderer_->overlays.draw(camera, viewport.aspect());
  return renderer_->canvas.read();
}

}  // namespace softcd::demo
