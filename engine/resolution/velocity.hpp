// Redundancy resolution at the velocity level: eq. 4.6 to 4.9.
#pragma once

#include <functional>
#include <vector>

#include "../kinematics/scene_kinematics.hpp"
#include "../kinematics/task.hpp"
#include "pseudo_inverse.hpp"

namespace humanoid_rail {

// Parameters of eq. 4.9, as in resolution/velocity.py.
struct Gains {
  Vector gain;  // Diagonal of K (m), 1/s.
  double c_mu = 0.0;
  double c_kappa = 0.0;
  double epsilon = 0.0;         // m
  double singular_value = 0.0;  // Below it the pseudo-inverse is damped.
  // Further secondary objectives: a velocity (n) at a configuration (n) and a time in s. May be empty.
  std::function<Vector(const Vector& q, double t)> objective;

  // How far obstacles matter to eq. 4.8, m; minus infinity if they do not.
  [[nodiscard]] double horizon() const { return c_kappa != 0.0 ? epsilon : -INFINITE; }
};

// q_dot of eq. 4.9 for a robot among obstacles. Holds its workspace. Not to be shared between threads.
// Evaluations allocate nothing, except what Eigen's SVD does at singularities, coal's GJK for boxes and meshes, tasks
// that turn hands, and functions of the user's.
class GradientProjection {
 public:
  explicit GradientProjection(const Robot& robot);

  // Returns q_dot (n), m/s and rad/s, where an observation was made. Its horizon has to be the activation distance or
  // more.
  const Vector& velocity(SceneKinematics& scene, const Observation& at, const TaskStack& tasks, const Gains& gains);
  // e of eq. 4.1 (m) where velocity() was asked for last.
  [[nodiscard]] const Vector& error() const { return error_; }
  // J (m, n) there.
  [[nodiscard]] const Matrix& jacobian() const { return jacobian_; }
  // How much of the error lies in a direction that J has lost there, m; 0 if there is none.
  [[nodiscard]] double lost_error() const;

 private:
  void set_secondary(const SceneKinematics& scene, const Observation& at, const Gains& gains);

  PseudoInverse pseudoinverse_;
  Vector error_, Ke_;
  Matrix jacobian_;
  Vector gradient_, secondary_, velocity_;
  std::vector<pinocchio::Force> wrenches_;
};

}  // namespace humanoid_rail
