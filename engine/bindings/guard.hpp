// Makes an object with a workspace safe between threads: calls wait for one another.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <type_traits>
#include <utility>

#include "interruptible.hpp"

namespace humanoid_rail {

// Calls `work` with an object, alone and without the interpreter's lock, so that other Python threads run meanwhile. A
// function of the user's takes that lock again when it is called back.
template <class T>
class Guarded {
 public:
  template <class... Arguments, class = std::enable_if_t<std::is_constructible_v<T, Arguments&&...>>>
  explicit Guarded(Arguments&&... arguments) : object_(std::forward<Arguments>(arguments)...) {}

  Guarded(const Guarded&) = delete;
  Guarded& operator=(const Guarded&) = delete;

  template <class Work>
  auto with(Work work) {
    // Without the interpreter's lock from the beginning: who waits for the object must not keep it from whoever has it.
    return interruptibly([&] {
      if (owner_.load() == std::this_thread::get_id()) {
        throw std::runtime_error("an objective, equality or task must not use the object that calls it");
      }
      std::unique_lock<std::timed_mutex> lock(mutex_, std::defer_lock);
      while (!lock.try_lock_for(PATIENCE)) Interruption::check();
      const Owner owner(owner_);
      return work(object_);
    });
  }

  // What never changes, for checks of sizes.
  [[nodiscard]] const T& constant() const { return object_; }

 private:
  class Owner {
   public:
    explicit Owner(std::atomic<std::thread::id>& owner) : owner_(owner) { owner_.store(std::this_thread::get_id()); }
    ~Owner() { owner_.store(std::thread::id()); }
    Owner(const Owner&) = delete;
    Owner& operator=(const Owner&) = delete;

   private:
    std::atomic<std::thread::id>& owner_;
  };

  // Who waits for the object looks this often whether to go on.
  static constexpr std::chrono::milliseconds PATIENCE{20};

  T object_;
  std::timed_mutex mutex_;
  std::atomic<std::thread::id> owner_{};
};

}  // namespace humanoid_rail
