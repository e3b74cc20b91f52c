// Makes an object with a workspace safe between threads: calls wait for one another.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "interruptible.hpp"

namespace humanoid_rail {

// A thread that waits for an object, as long as it is there. All of them are known, so that threads that wait for each
// other's objects, by functions that they were called back with, notice it.
class Wait {
 public:
  using Owner = std::atomic<std::thread::id>;

  explicit Wait(const Owner& owner) {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_[std::this_thread::get_id()] = &owner;
  }
  ~Wait() {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.erase(std::this_thread::get_id());
  }
  Wait(const Wait&) = delete;
  Wait& operator=(const Wait&) = delete;

  // Whether the owner of the object waits, or the owner of what that one waits for and so on, for the calling thread.
  [[nodiscard]] bool is_circular() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto self = std::this_thread::get_id();
    auto at = waiting_.find(self);
    for (std::size_t steps = 0; at != waiting_.end() && steps < waiting_.size(); ++steps) {
      const std::thread::id owner = at->second->load();
      if (owner == self) return true;
      at = waiting_.find(owner);
    }
    return false;
  }

 private:
  inline static std::mutex mutex_;
  inline static std::unordered_map<std::thread::id, const Owner*> waiting_;
};

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
      std::unique_lock<std::timed_mutex> lock(mutex_, std::try_to_lock);
      if (!lock) wait_for(lock);
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

  void wait_for(std::unique_lock<std::timed_mutex>& lock) {
    const Wait wait(owner_);
    while (!lock.try_lock_for(PATIENCE)) {
      if (wait.is_circular())
        throw std::runtime_error("functions that the engine calls wait for one another's objects");
      Interruption::check();
    }
  }

  T object_;
  std::timed_mutex mutex_;
  std::atomic<std::thread::id> owner_{};
};

}  // namespace humanoid_rail
