// Lets whoever waits for long work end it.
#pragma once

#include <chrono>

namespace humanoid_rail {

// While one is there, work in the same thread that polls calls its function every so often; what that throws ends the
// work. So poll only where nothing is half done.
class Interruption {
 public:
  using Check = void (*)();

  // Without a function nothing interrupts the work.
  explicit Interruption(Check function) : before_(check_) { check_ = function; }
  ~Interruption() { check_ = before_; }
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  // Calls the function, if there is one, now.
  static void check() {
    if (check_ != nullptr) check_();
  }
  // Costs about a nanosecond.
  static void poll() {
    if (check_ != nullptr && ++polls_ % POLLS == 0) look_at_clock();
  }

 private:
  // The clock is looked at once in so many polls, and the function is called when this time has gone by.
  static constexpr unsigned POLLS = 16;
  static constexpr std::chrono::milliseconds INTERVAL{20};

  static void look_at_clock() {
    const auto now = std::chrono::steady_clock::now();
    if (now - checked_ < INTERVAL) return;
    checked_ = now;
    check_();
  }

  Check before_;
  inline static thread_local Check check_ = nullptr;
  inline static thread_local unsigned polls_ = 0;
  inline static thread_local std::chrono::steady_clock::time_point checked_{};
};

}  // namespace humanoid_rail
