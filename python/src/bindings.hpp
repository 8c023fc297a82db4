#pragma once

#include <nanobind/nanobind.h>

/// The parts of the module, which module.cpp calls: each function defines the names of its file.
namespace softcd::python {

void register_exceptions();
void bind_interruptible_work(nanobind::module_& module);
void bind_enumerations(nanobind::module_& module);
void bind_statistics(nanobind::module_& module);
void bind_contacts(nanobind::module_& module);
void bind_device_contacts(nanobind::module_& module);
void bind_scene(nanobind::module_& module);
void bind_batch_scene(nanobind::module_& module);
void bind_query(nanobind::module_& module);
void bind_probe(nanobind::module_& module);
void bind_meshes(nanobind::module_& module);

}  // namespace softcd::python
