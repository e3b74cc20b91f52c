#include "scene_kinematics.hpp"

namespace humanoid_rail {

void SceneKinematics::observe(const Eigen::Ref<const Vector>& q, double t, double obstacle_horizon, double link_horizon,
                              Observation& seen) {
  observe_obstacles(q, t, obstacle_horizon, seen);
  seen.link_horizon = link_horizon;
  if (link_horizon > -INFINITE) links_.within(link_horizon, kinematics_, seen.links);
}

void SceneKinematics::glance(const Eigen::Ref<const Vector>& q, double t, double obstacle_horizon, double link_horizon,
                             Observation& seen) {
  observe_obstacles(q, t, obstacle_horizon, seen);
  seen.link_horizon = link_horizon;
  links_.glance(link_horizon, kinematics_, seen.links, seen.unmeasured);
}

void SceneKinematics::observe_obstacles(const Eigen::Ref<const Vector>& q, double t, double horizon,
                                        Observation& seen) {
  seen.t = t;
  seen.q = q;
  seen.obstacle_horizon = horizon;
  kinematics_.move_to(q);
  obstacles_.move_to(t);
  seen.near.obstacles.clear();
  seen.near.pieces.clear();
  seen.links.clear();
  seen.unmeasured.clear();
  if (obstacles().size() > 0 && horizon > -INFINITE) obstacles_.within(horizon, kinematics_, seen.near);
}

void SceneKinematics::observe_nearest(const Eigen::Ref<const Vector>& q, double t, double horizon, Observation& seen) {
  seen.t = t;
  seen.q = q;
  seen.obstacle_horizon = horizon;
  seen.link_horizon = -INFINITE;
  seen.links.clear();
  seen.unmeasured.clear();
  kinematics_.move_to(q);
  obstacles_.move_to(t);
  obstacles_.within_or_nearest(horizon, kinematics_, seen.near);
}

void SceneKinematics::distance_gradient(const Nearest& pair, Eigen::Ref<Vector> gradient) const {
  const Robot& robot = kinematics_.robot();
  gradient.setZero();
  const auto wrench = pair.wrench();
  if (pair.is_with_obstacle()) {
    kinematics_.add_wrench(wrench, robot.joint_of(pair.link), 0, -1.0, gradient);
    return;
  }
  // What moves both links alike leaves their distance as it is.
  const auto common = robot.common_joints()[static_cast<std::size_t>(pair.pair)];
  kinematics_.add_wrench(wrench, robot.joint_of(pair.link), common, -1.0, gradient);
  kinematics_.add_wrench(wrench, robot.joint_of(pair.other), common, 1.0, gradient);
}

}  // namespace humanoid_rail
