#pragma once

#include <nanobind/nanobind.h>

namespace softcd::python {

/// Implements Py_tp_traverse by T::traverse, for classes whose objects may be in cycles that only Python's collector
/// finds.
template <class T>
int traverse_object(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  return nanobind::inst_ready(self) ? nanobind::inst_ptr<T>(self)->traverse(visit, arg) : 0;
}

/// Implements Py_tp_clear by T::clear, which releases the references that cycles may contain.
template <class T>
int clear_object(PyObject* self) {
  nanobind::inst_ptr<T>(self)->clear();
  return 0;
}

}  // namespace softcd::python
