#include "interruptible_work.hpp"

#include "bindings.hpp"

namespace softcd::python {
namespace {

unsigned long main_thread = 0;

/// Never destroyed: a thread may use them until the process ends.
struct Abandoned {
  std::mutex mutex;
  std::condition_variable changed;
  int count = 0;
};
Abandoned& abandoned() {
  static auto* const works = new Abandoned;
  return *works;
}

}  // namespace

bool handles_signals() {
  return PyThread_get_thread_ident() == main_thread;
}

void check_signals() {
  const nb::gil_scoped_acquire interpreter;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

void AbandonedWork::begin() {
  const std::lock_guard lock(abandoned().mutex);
  ++abandoned().count;
}

void AbandonedWork::end() {
  const std::lock_guard lock(abandoned().mutex);
  --abandoned().count;
  abandoned().changed.notify_all();
}

void bind_interruptible_work(nb::module_& module) {
  main_thread = nb::cast<unsigned long>(nb::module_::import_("threading").attr("main_thread")().attr("ident"));
  module.def("_wait_for_abandoned_work", [] {
    const nb::gil_scoped_release no_interpreter;
    std::unique_lock lock(abandoned().mutex);
    abandoned().changed.wait(lock, [] { return abandoned().count == 0; });
  });
  // The interpreter, and everything that the work uses, ends after it.
  nb::module_::import_("atexit").attr("register")(module.attr("_wait_for_abandoned_work"));
}

}  // namespace softcd::python
