#include "velocity.hpp"

#include <cmath>
#include <stdexcept>

namespace humanoid_rail {

GradientProjection::GradientProjection(const Robot& robot)
    : gradient_(robot.model.nv),
      secondary_(robot.n()),
      velocity_(robot.n()),
      wrenches_(static_cast<std::size_t>(robot.model.njoints)) {}

const Vector& GradientProjection::velocity(SceneKinematics& scene, const Observation& at, const TaskStack& tasks,
                                           const Gains& gains) {
  const Kinematics& kinematics = scene.move_to(at.q);
  set_secondary(scene, at, gains);
  tasks.evaluate(kinematics, at.t, error_, jacobian_);
  Ke_ = gains.gain.cwiseProduct(error_);
  pseudoinverse_.decompose(jacobian_, gains.singular_value);
  pseudoinverse_.redundant_velocity(jacobian_, Ke_, secondary_, velocity_);
  return velocity_;
}

// q_dot_0 = c_mu (d mu/dq)^T - c_kappa sum_i (d kappa(psi_i)/dq)^T, eq. 4.8, with kappa = (psi - epsilon)^2 within
// epsilon, first with respect to all joints and then, by S^T, to the actuated ones; and further objectives.
void GradientProjection::set_secondary(const SceneKinematics& scene, const Observation& at, const Gains& gains) {
  const Kinematics& kinematics = scene.kinematics();
  const Robot& robot = kinematics.robot();
  gradient_.setZero();
  if (gains.c_mu != 0.0) kinematics.add_manipulability_gradient(gains.c_mu, gradient_);
  if (gains.c_kappa != 0.0 && !at.near.obstacles.empty()) {
    for (auto& wrench : wrenches_) wrench.setZero();
    for (const Nearest& pair : at.near.obstacles) {
      if (pair.distance >= gains.epsilon) continue;
      const double slope = 2.0 * (pair.distance - gains.epsilon);
      wrenches_[robot.joint_of(pair.link)] += pair.wrench() * (gains.c_kappa * slope);
    }
    kinematics.add_wrenches(wrenches_, gradient_);
  }
  secondary_.noalias() = robot.coupling.transpose() * gradient_;
  if (gains.objective) {
    const Vector further = gains.objective(at.q, at.t);
    if (further.size() != secondary_.size()) throw std::invalid_argument("an objective needs a velocity of each joint");
    secondary_ += further;
  }
}

double GradientProjection::lost_error() const {
  const auto lost = pseudoinverse_.lost_direction();
  return lost ? std::abs(lost->dot(error_)) : 0.0;
}

}  // namespace humanoid_rail
