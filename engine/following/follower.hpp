// Follows targets cycle by cycle among obstacles that are moved, with a proven stop at all times;
// humanoid_rail/following/follower.py explains it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "../resolution/qp.hpp"
#include "stop_proof.hpp"

namespace humanoid_rail {

// What is to be reached, and how.
struct Goal {
  TaskStack tasks;
  Gains gains;
};

struct FollowerSettings {
  double dt = 0.0;         // Length of a cycle, s.
  double tolerance = 0.0;  // The tasks are reached where |e| is not more, m.
  Vector acceleration;     // Limits of the joints (n), m/s^2 and rad/s^2.
  Vector obstacle_speeds;  // No point of an obstacle is faster, m/s.
  double latency = 0.0;    // No place of an obstacle is known later than this, s.
};

enum class FollowerStatus { following, reached, braking, stopped };

// A robot at the end of a cycle.
struct FollowerState {
  long cycle = 0;   // How many there have been.
  Vector q;         // (n), m and rad.
  Vector velocity;  // (n), that of the cycle, m/s and rad/s.
  FollowerStatus status = FollowerStatus::stopped;
  double left = INFINITE;           // |e|, m.
  bool proven = true;               // Whether the stop is.
  Vector stop;                      // Where it ends (n), m and rad.
  long cycles_to_rest = 0;          // How many cycles it takes.
  int jumped = -1;                  // An obstacle that got farther than its speed allows, if one did.
  Nearest closest;                  // Of the pairs that were measured at the beginning of the cycle.
  std::optional<Nearest> blocking;  // A pair that kept a velocity from being proven.
};

// Holds its workspace. Not to be shared between threads.
class Follower {
 public:
  // Throws std::invalid_argument where the start (n) is beyond the limits, or a limit is missing.
  Follower(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, const Vector& start,
           std::shared_ptr<const Goal> goal, const Safety& safety, FollowerSettings settings);

  // Takes a goal and gives back the one before.
  void swap_goal(std::shared_ptr<const Goal>& goal) { goal_.swap(goal); }
  // Says where an obstacle is now, and how fast it moves on until something else is said, m/s.
  void place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity);
  // Makes a cycle. To brake is to go on with the stop, whatever the targets are.
  const FollowerState& step(bool brakes = false);

  [[nodiscard]] const FollowerState& state() const { return state_; }
  [[nodiscard]] const FollowerSettings& settings() const { return settings_; }
  [[nodiscard]] bool is_at_rest() const { return state_.velocity.isZero(0.0); }
  [[nodiscard]] const Robot& robot() const { return method_.scene.robot(); }
  [[nodiscard]] int obstacles() const { return method_.scene.obstacles().size(); }
  // A pair that touches at the configuration where the robot is, if one does.
  [[nodiscard]] std::optional<Nearest> contact();

 private:
  // A velocity that falls to 0 in equal parts.
  struct Braking {
    Vector velocity;  // In the cycle that it begins with (n).
    long cycles = 0;  // Until rest.
    long done = 0;
  };
  // Where an obstacle was when the stop was proven.
  struct Body {
    coal::Transform3s placement, proven;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    double radius = 0.0;  // Around its origin, m.
  };

  [[nodiscard]] int find_jump() const;
  [[nodiscard]] Nearest closest() const;
  void set_reachable();
  [[nodiscard]] bool choose(bool brakes);
  [[nodiscard]] bool is_stop_proven(const Vector& velocity);
  void begin_stop();
  void advance(bool is_chosen);
  void move_obstacles();
  [[nodiscard]] long cycles_to_rest(const Vector& velocity) const;

  SafeVelocity method_;
  StopProof proof_;
  std::shared_ptr<const Goal> goal_;
  Safety safety_;
  FollowerSettings settings_;
  double limit_gain_ = 0.0;  // How fast a joint may approach its position limit so that it can brake, 1/s.
  std::vector<Body> bodies_;
  FollowerState state_;
  Braking braking_;
  long proven_at_ = -1;  // The cycle in which the stop was proven.
  Observation seen_;
  Reachable reachable_;
  Vector wanted_, candidate_, stop_, error_;
};

}  // namespace humanoid_rail
