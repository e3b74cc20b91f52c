#include "follower_loop.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <unistd.h>

namespace humanoid_rail {

void CycleTimes::count(double seconds, bool is_late) {
  ++cycles;
  if (is_late) ++overruns;
  longest = std::max(longest, seconds);
  const double bin = std::floor(seconds / WIDTH);
  if (bin < static_cast<double>(bins_.size())) ++bins_[static_cast<std::size_t>(bin)];
}

double CycleTimes::percentile(double share) const {
  const double wanted = share * static_cast<double>(cycles);
  std::int64_t counted = 0;
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    counted += bins_[i];
    if (counted > 0 && static_cast<double>(counted) >= wanted) {
      return std::min(longest, WIDTH * static_cast<double>(i + 1));
    }
  }
  return longest;
}

FollowerLoop::FollowerLoop(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, const Vector& start,
                           std::shared_ptr<const Goal> goal, const Safety& safety, FollowerSettings settings)
    : follower_(std::move(robot), obstacles, start, std::move(goal), safety, std::move(settings)),
      placed_(static_cast<std::size_t>(obstacles.size())),
      state_(follower_.state()) {}

bool FollowerLoop::is_foreign() const { return runs_ && process_ != getpid(); }

// Comes before any lock: another thread may have held it when this process was forked.
void FollowerLoop::check_process() const {
  if (is_foreign()) throw std::runtime_error("the follower was started in another process: make one here");
}

void FollowerLoop::set_goal(std::shared_ptr<const Goal> goal) {
  check_process();
  const std::lock_guard<std::mutex> lock(shared_);
  goal_ = std::move(goal);
  is_goal_pending_ = true;
}

void FollowerLoop::place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity) {
  check_process();
  const std::lock_guard<std::mutex> lock(shared_);
  placed_.at(static_cast<std::size_t>(obstacle)) = {placement, velocity, true};
}

void FollowerLoop::take_inputs() {
  const std::lock_guard<std::mutex> lock(shared_);
  if (is_goal_pending_) follower_.swap_goal(goal_);
  is_goal_pending_ = false;
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    Placed& placed = placed_[i];
    if (placed.is_pending) follower_.place(static_cast<int>(i), placed.placement, placed.velocity);
    placed.is_pending = false;
  }
}

void FollowerLoop::cycle(bool brakes) {
  take_inputs();
  const FollowerState& state = follower_.step(brakes);
  const std::lock_guard<std::mutex> lock(shared_);
  state_ = state;
}

FollowerState FollowerLoop::step(bool brakes) {
  check_process();
  const std::lock_guard<std::mutex> lock(steps_);
  if (runs_) throw std::runtime_error("the follower runs in its thread: stop it first");
  join();
  cycle(brakes);
  return follower_.state();
}

void FollowerLoop::start() {
  check_process();
  const std::lock_guard<std::mutex> lock(steps_);
  if (runs_) throw std::runtime_error("the follower runs already");
  join();
  {
    const std::lock_guard<std::mutex> shared(shared_);
    times_ = CycleTimes();
    error_.clear();
  }
  brakes_ = ends_ = false;
  process_ = getpid();
  runs_ = true;
  thread_ = std::thread(&FollowerLoop::run, this);
}

void FollowerLoop::run() {
  try {
    run_cycles();
  } catch (const std::exception& error) {
    const std::lock_guard<std::mutex> lock(shared_);
    error_ = error.what();
  }
  runs_ = false;
}

void FollowerLoop::run_cycles() {
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(follower_.settings().dt));
  auto due = Clock::now();
  while (!ends_) {
    const auto began = Clock::now();
    const bool brakes = brakes_;
    cycle(brakes);
    const auto done = Clock::now();
    due += period;
    {
      const std::lock_guard<std::mutex> lock(shared_);
      times_.count(std::chrono::duration<double>(done - began).count(), done > due);
    }
    if (brakes && follower_.is_at_rest()) return;
    // What was missed is not made up for: cycles in a hurry would be faster than the robot.
    due = std::max(due, done);
    std::this_thread::sleep_until(due);
  }
}

void FollowerLoop::stop() {
  check_process();
  {
    // The thread that starts now is to brake as well.
    const std::lock_guard<std::mutex> lock(steps_);
    brakes_ = true;
    join();
  }
  check_error();
}

void FollowerLoop::end() noexcept {
  if (is_foreign()) {
    if (thread_.joinable()) thread_.detach();
    return;
  }
  ends_ = true;  // Whoever waits for the robot to brake waits no longer.
  const std::lock_guard<std::mutex> lock(steps_);
  ends_ = true;  // A start may have come in between.
  join();
}

void FollowerLoop::join() noexcept {
  if (!thread_.joinable()) return;
  if (process_ == getpid()) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

FollowerState FollowerLoop::state() const {
  check_process();
  check_error();
  const std::lock_guard<std::mutex> lock(shared_);
  return state_;
}

CycleTimes FollowerLoop::times() const {
  check_process();
  const std::lock_guard<std::mutex> lock(shared_);
  return times_;
}

void FollowerLoop::check_error() const {
  const std::lock_guard<std::mutex> lock(shared_);
  if (!error_.empty()) throw std::runtime_error("the follower's thread ended: " + error_);
}

}  // namespace humanoid_rail
