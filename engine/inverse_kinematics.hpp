// Configurations with the hands at their targets. Beside humanoid_rail/inverse_kinematics.py, which explains them.
#pragma once

#include "clearance.hpp"

namespace humanoid_rail {

// A configuration that was found, and how good it is.
struct Posture {
  Vector q;           // (n), within the limits.
  double error;       // Of the hands, weighted, m.
  double clearance;   // The smallest of all pairs nearer than asked for, m; infinite where there are none.
};

// A robot among obstacles where they are at t = 0, with the workspace that takes. Not to be shared between threads.
class InverseKinematics {
 public:
  InverseKinematics(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);

  // Looks, from a configuration (n), for one near it with the hands at their targets x_f (3h) in m, and all pairs at
  // least `distance` apart; if that is minus infinity they are left alone. Rows of weight 0 (3h) are free.
  Posture solve(const Eigen::Ref<const Vector>& start, const Eigen::Ref<const Vector>& targets,
                const Eigen::Ref<const Vector>& weights, double distance);
  const Robot& robot() const { return kinematics_.robot(); }

 private:
  void keep_apart(const Nearest& pair, double wanted, Posture& here, double& left);
  void step(double damping, Vector& q);

  Kinematics kinematics_;
  Clearances clearances_;
  SelfClearances self_clearances_;
  Matrix square_, weighted_;  // The normal equations: square x = right.
  Vector right_, error_, gradient_, x_, next_;
  Vector scale_;  // Of joints: their speed limits, 1 where there is none, 0 for those that do not move.
};

}  // namespace humanoid_rail
