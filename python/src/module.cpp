#include <nanobind/nanobind.h>

#include "bindings.hpp"
#include "softcd/version.hpp"

NB_MODULE(_core, module) {
  using namespace softcd::python;
  module.doc() = "The C++ library softcd.";
  module.attr("version") = SOFTCD_VERSION_STRING;
  register_exceptions();
  bind_interruptible_work(module);
  bind_enumerations(module);
  bind_statistics(module);
  bind_contacts(module);
  bind_device_contacts(module);
  bind_scene(module);
  bind_batch_scene(module);
  bind_query(module);
  bind_probe(module);
  bind_meshes(module);
}
