// Takes and releases the interpreter's lock, also while the interpreter ends.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include <nanobind/nanobind.h>
#include <pthread.h>

namespace humanoid_rail {

// The thread in which Python handles signals, and which ends it.
inline std::atomic<unsigned long> main_thread{0};
// Whether the interpreter ends: from then on no other thread gets its lock any more.
inline std::atomic<bool> interpreter_ends{false};
// How many threads are about to take the lock.
inline std::atomic<int> threads_taking_lock{0};

[[nodiscard]] inline bool is_main_thread() { return PyThread_get_thread_ident() == main_thread; }

// Python would end a thread that takes the lock then, in the midst of C++: it waits for the end of the process instead.
inline void wait_if_interpreter_ends() {
  while (interpreter_ends && !is_main_thread()) std::this_thread::sleep_for(std::chrono::hours(1));
}

// Announces that a thread takes the lock; while it is there, the interpreter does not end.
class LockTaking {
 public:
  LockTaking() {
    ++threads_taking_lock;
    if (!interpreter_ends || is_main_thread()) return;
    --threads_taking_lock;
    wait_if_interpreter_ends();
  }
  ~LockTaking() { --threads_taking_lock; }
  LockTaking(const LockTaking&) = delete;
  LockTaking& operator=(const LockTaking&) = delete;
};

// Releases the interpreter's lock for as long as it is there.
class LockRelease {
 public:
  LockRelease() : state_(PyEval_SaveThread()) {}
  ~LockRelease() {
    const LockTaking taking;
    PyEval_RestoreThread(state_);
  }
  LockRelease(const LockRelease&) = delete;
  LockRelease& operator=(const LockRelease&) = delete;

 private:
  PyThreadState* state_;
};

// Takes the interpreter's lock for as long as it is there.
class LockAcquire {
 public:
  LockAcquire() {
    const LockTaking taking;
    state_ = PyGILState_Ensure();
  }
  ~LockAcquire() {
    if (!PyGILState_Check()) wait_if_interpreter_ends();  // Python is ending this thread.
    PyGILState_Release(state_);
  }
  LockAcquire(const LockAcquire&) = delete;
  LockAcquire& operator=(const LockAcquire&) = delete;

 private:
  PyGILState_STATE state_{};
};

// Finds the main thread, which in a forked process is the only one there is, and has Python say when it ends.
inline void prepare_for_interpreter() {
  namespace nb = nanobind;
  main_thread = nb::cast<unsigned long>(nb::module_::import_("threading").attr("main_thread")().attr("ident"));
  pthread_atfork(nullptr, nullptr, [] {
    main_thread = PyThread_get_thread_ident();
    threads_taking_lock = 0;
  });
  nb::module_::import_("atexit").attr("register")(nb::cpp_function([] {
    interpreter_ends = true;
    const nb::gil_scoped_release release;
    while (threads_taking_lock > 0) std::this_thread::yield();
  }));
}

}  // namespace humanoid_rail
