// A follower in a thread of its own, cycle after cycle at absolute times. Python is not needed for it.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "follower.hpp"

namespace humanoid_rail {

// How long cycles took: a histogram of fixed size.
class CycleTimes {
 public:
  // Counts a cycle that took so long, s; `is_late` where it was not done when the next one was due.
  void count(double seconds, bool is_late);
  // The time that a share of the cycles took at most, s, precise to a microsecond; the longest of all beyond the
  // histogram's end. 0 without cycles.
  [[nodiscard]] double percentile(double share) const;

  std::int64_t cycles = 0, overruns = 0;
  double longest = 0.0;  // s

 private:
  static constexpr double WIDTH = 1e-6;  // Of a bin, s.
  std::array<std::int64_t, 10'000> bins_{};
};

// A follower that threads may share: what they say of targets and obstacles counts from the next cycle on. While its
// thread runs it is of no use in a forked process, which has no such thread: all but is_running and end throw
// std::runtime_error there.
class FollowerLoop {
 public:
  FollowerLoop(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, const Vector& start,
               std::shared_ptr<const Goal> goal, const Safety& safety, FollowerSettings settings);
  ~FollowerLoop() { end(); }
  FollowerLoop(const FollowerLoop&) = delete;
  FollowerLoop& operator=(const FollowerLoop&) = delete;

  void set_goal(std::shared_ptr<const Goal> goal);
  void place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity);
  // Makes a cycle in the calling thread. Throws std::runtime_error while the thread runs.
  FollowerState step(bool brakes);

  // Starts the thread. Throws std::runtime_error if it runs.
  void start();
  // Brakes to rest and ends the thread. Throws std::runtime_error where it ended by an error.
  void stop();
  // Ends the thread after the cycle at hand, wherever the robot is.
  void end() noexcept;
  // False in a process that was forked from the one of the thread.
  [[nodiscard]] bool is_running() const { return runs_ && !is_foreign(); }
  // Throws std::runtime_error where the thread ended by an error.
  [[nodiscard]] FollowerState state() const;
  [[nodiscard]] CycleTimes times() const;

  [[nodiscard]] int obstacles() const { return follower_.obstacles(); }
  // A pair that touches where the robot is. Not while the thread runs.
  [[nodiscard]] std::optional<Nearest> contact() { return follower_.contact(); }

 private:
  using Clock = std::chrono::steady_clock;

  // What was said of an obstacle since the last cycle.
  struct Placed {
    coal::Transform3s placement;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    bool is_pending = false;
  };

  void take_inputs();
  void cycle(bool brakes);
  void run();
  void run_cycles();
  void join() noexcept;
  [[nodiscard]] bool is_foreign() const;
  void check_process() const;
  void check_error() const;

  Follower follower_;
  std::mutex steps_;           // Held while a cycle is made by a caller.
  mutable std::mutex shared_;  // Held briefly, for what follows.
  // The next one; once it was taken, the one before, for which only a caller may be the last to let go: it may be
  // Python's.
  std::shared_ptr<const Goal> goal_;
  bool is_goal_pending_ = false;
  std::vector<Placed> placed_;
  FollowerState state_;
  CycleTimes times_;
  std::string error_;

  std::thread thread_;
  std::atomic<bool> runs_{false}, brakes_{false}, ends_{false};
  std::atomic<int> process_{0};  // In which the thread was started: a forked one has none.
};

}  // namespace humanoid_rail
