// Lets Ctrl-C, and whatever other signals Python handles, end work of the engine.
#pragma once

#include <atomic>

#include <nanobind/nanobind.h>
#include <pthread.h>

#include "../interruption.hpp"

namespace humanoid_rail {

// The thread in which Python handles signals.
inline std::atomic<unsigned long> main_thread{0};

// Finds that thread, once; in a forked process it is the only one there is.
inline void find_main_thread() {
  main_thread =
      nanobind::cast<unsigned long>(nanobind::module_::import_("threading").attr("main_thread")().attr("ident"));
  pthread_atfork(nullptr, nullptr, [] { main_thread = PyThread_get_thread_ident(); });
}

inline void check_signals() {
  const nanobind::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

// Does work without the interpreter's lock, so that other Python threads run meanwhile. In the main thread a signal
// ends it, with what its handler raises: KeyboardInterrupt for Ctrl-C.
template <class Work>
auto interruptibly(Work work) {
  const nanobind::gil_scoped_release release;
  const Interruption interruption(PyThread_get_thread_ident() == main_thread ? check_signals : nullptr);
  return work();
}

}  // namespace humanoid_rail
