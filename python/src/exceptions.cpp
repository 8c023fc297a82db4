#include <nanobind/nanobind.h>

#include "bindings.hpp"
#include "mesh_tools/mesh_io.hpp"
#include "softcd/error.hpp"

namespace softcd::python {
namespace {

namespace nb = nanobind;

/// Raises the class of that name in softcd/_errors.py.
void raise(const char* name, const std::exception& error) {
  try {
    const nb::object type = nb::module_::import_("softcd._errors").attr(name);
    PyErr_SetString(type.ptr(), error.what());
  } catch (nb::python_error& failed_import) {
    failed_import.restore();
  }
}

void translate(const std::exception_ptr& thrown, void* /*unused*/) {
  try {
    std::rethrow_exception(thrown);
  } catch (const InvalidInput& error) {
    raise("InvalidInput", error);
  } catch (const BackendError& error) {
    raise("BackendError", error);
  } catch (const OutOfMemory& error) {
    raise("OutOfMemory", error);
  } catch (const Error& error) {
    raise("Error", error);
  } catch (const mesh_tools::MeshError& error) {
    raise("MeshError", error);
  }
}

}  // namespace

void register_exceptions() {
  nb::register_exception_translator(translate);
}

}  // namespace softcd::python
