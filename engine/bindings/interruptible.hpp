// Lets Ctrl-C, and whatever other signals Python handles, end work of the engine.
#pragma once

#include "../interruption.hpp"
#include "interpreter.hpp"

namespace humanoid_rail {

inline void check_signals() {
  const LockAcquire acquire;
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

// Does work without the interpreter's lock, so that other Python threads run meanwhile. In the main thread a signal
// ends it, with what its handler raises: KeyboardInterrupt for Ctrl-C.
template <class Work>
auto interruptibly(Work work) {
  const LockRelease release;
  const Interruption interruption(is_main_thread() ? check_signals : nullptr);
  return work();
}

}  // namespace humanoid_rail
