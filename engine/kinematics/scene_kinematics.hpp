// A robot among obstacles, and what is seen there at one moment.
#pragma once

#include "clearance.hpp"

namespace humanoid_rail {

// What is near a robot at a moment: a value, in which nothing refers to what found it.
struct Observation {
  double t = 0.0;  // s
  Vector q;        // (n)
  NearObstacles near;
  std::vector<Nearest> links;
  std::vector<Unmeasured> unmeasured;  // Pairs of links, in the order of their numbers; none of them is in `links`.
  // Pairs farther apart than these were not looked at, m.
  double obstacle_horizon = -INFINITE, link_horizon = -INFINITE;
};

// A robot among obstacles. Holds its workspace. Not to be shared between threads.
class SceneKinematics {
 public:
  SceneKinematics(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
      : kinematics_(robot), obstacles_(robot, obstacles), links_(robot) {}

  [[nodiscard]] const Robot& robot() const { return kinematics_.robot(); }
  [[nodiscard]] const Obstacles& obstacles() const { return obstacles_.obstacles(); }
  [[nodiscard]] const Kinematics& kinematics() const { return kinematics_; }

  // Moves the robot to a configuration (n).
  const Kinematics& move_to(const Eigen::Ref<const Vector>& q) {
    kinematics_.move_to(q);
    return kinematics_;
  }
  // The same, for the hands alone.
  const Kinematics& move_hands_to(const Eigen::Ref<const Vector>& q) {
    kinematics_.move_hands_to(q);
    return kinematics_;
  }
  // Puts an obstacle elsewhere, where it is at t = 0, with another velocity.
  void place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity) {
    obstacles_.place(obstacle, placement, velocity);
  }
  // Moves robot and obstacles, and finds what is within the horizons; minus infinity for nothing.
  void observe(const Eigen::Ref<const Vector>& q, double t, double obstacle_horizon, double link_horizon,
               Observation& seen);
  // The same, but pairs of links that take long to measure are not measured.
  void glance(const Eigen::Ref<const Vector>& q, double t, double obstacle_horizon, double link_horizon,
              Observation& seen);
  // The same, but of obstacles the nearest one in any case, and no links.
  void observe_nearest(const Eigen::Ref<const Vector>& q, double t, double horizon, Observation& seen);
  // The pairs of a link and a piece of an obstacle.
  [[nodiscard]] const std::vector<Nearest>& pieces(const Observation& seen) const {
    return seen.near.by_piece(obstacles().is_compound());
  }
  // Measures a pair of links where the robot is.
  [[nodiscard]] Nearest measure_links(int pair) { return links_.measure(pair, kinematics_); }
  // The boxes around the links there, with a velocity (n).
  const LinkBoxes& moving_boxes(const Vector& velocity) { return links_.moving_boxes(kinematics_, velocity); }
  // Sets d psi/dq (n) of a pair where the robot is.
  void distance_gradient(const Nearest& pair, Eigen::Ref<Vector> gradient) const;

 private:
  void observe_obstacles(const Eigen::Ref<const Vector>& q, double t, double horizon, Observation& seen);

  Kinematics kinematics_;
  ObstacleClearances obstacles_;
  LinkClearances links_;
};

}  // namespace humanoid_rail
