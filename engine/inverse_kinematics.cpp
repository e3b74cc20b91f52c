#include "inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace humanoid_rail {

namespace {

constexpr int MAX_ITERATIONS = 60;
// What the hands are brought to their targets to, m.
constexpr double ARRIVED = 1e-7;
// How much farther apart than they have to be pairs are brought, m.
constexpr double SPARE = 2e-3;
// The damping: this share of what is left of the squared errors, and this much, m^2.
constexpr double DAMPING_SHARE = 0.1, LEAST_DAMPING = 1e-6;
// The longest step of a joint, at its speed limit, s.
constexpr double LONGEST_STEP = 0.3;
// The search ends after so many steps in a row none of which took away this share of what was left.
constexpr double WORTHWHILE = 0.03;
constexpr int PATIENCE = 12;
// How often a step is solved again with joints held at their limits.
constexpr int HOLDS = 4;

}  // namespace

InverseKinematics::InverseKinematics(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : kinematics_(robot), clearances_(robot, obstacles), self_clearances_(robot), scale_(robot->limits.velocity) {
  for (double& speed : scale_) speed = std::isfinite(speed) ? speed : 1.0;
}

Posture InverseKinematics::solve(const Eigen::Ref<const Vector>& start, const Eigen::Ref<const Vector>& targets,
                                 const Eigen::Ref<const Vector>& weights, double distance) {
  const Limits& limits = kinematics_.robot().limits;
  const bool apart = distance > -INFINITE;
  const double wanted = distance + SPARE;
  Vector q = start.cwiseMin(limits.upper).cwiseMax(limits.lower);
  Posture best{q, INFINITE, INFINITE};
  double least = INFINITE;
  for (int iteration = 0, waited = 0; iteration < MAX_ITERATIONS && waited <= PATIENCE; ++iteration) {
    kinematics_.move_to(q);
    error_ = weights.cwiseProduct(targets - kinematics_.hands());
    Posture here{q, error_.norm(), INFINITE};
    double left = error_.squaredNorm();
    weighted_ = weights.asDiagonal() * kinematics_.jacobian();
    square_.noalias() = weighted_.transpose().lazyProduct(weighted_);
    right_.noalias() = weighted_.transpose() * error_;
    if (apart) {
      if (clearances_.obstacles() > 0) {
        clearances_.within(wanted, kinematics_);
        for (const Nearest& pair : clearances_.pieces_within()) keep_apart(pair, wanted, here, left);
      }
      for (const Nearest& pair : self_clearances_.within(wanted, kinematics_)) keep_apart(pair, wanted, here, left);
    }
    if (here.error <= ARRIVED && (!apart || here.clearance >= distance)) return here;
    waited = left < (1.0 - WORTHWHILE) * least ? 0 : waited + 1;
    if (left < least) {
      least = left;
      best = here;
    }
    step(DAMPING_SHARE * left + LEAST_DAMPING, q);
  }
  return best;
}

// Adds the row of a pair that is too near.
void InverseKinematics::keep_apart(const Nearest& pair, double wanted, Posture& here, double& left) {
  here.clearance = std::min(here.clearance, pair.distance);
  const double lacking = wanted - pair.distance;
  if (lacking <= 0.0) return;
  const Robot& robot = kinematics_.robot();
  gradient_.setZero(robot.n());
  kinematics_.add_wrench(pair.wrench(), robot.joint_of(pair.link), 0, -1.0, gradient_);
  if (pair.piece < 0) kinematics_.add_wrench(pair.wrench(), robot.joint_of(pair.other), 0, 1.0, gradient_);
  square_.noalias() += gradient_ * gradient_.transpose();
  right_ += lacking * gradient_;
  left += lacking * lacking;
}

// Moves a configuration by the step of the normal equations; a joint that would go beyond a limit goes to it, and the
// others make up for that.
void InverseKinematics::step(double damping, Vector& q) {
  const Limits& limits = kinematics_.robot().limits;
  square_ = scale_.asDiagonal() * square_ * scale_.asDiagonal();
  right_ = right_.cwiseProduct(scale_);
  square_.diagonal().array() += damping;
  for (int hold = 0; hold < HOLDS; ++hold) {
    x_ = square_.ldlt().solve(right_);
    const double longest = x_.cwiseAbs().maxCoeff();
    if (longest > LONGEST_STEP) x_ *= LONGEST_STEP / longest;
    next_ = q + x_.cwiseProduct(scale_);
    bool holds = false;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      if (next_[i] >= limits.lower[i] && next_[i] <= limits.upper[i]) continue;
      holds = true;
      const double moved = ((next_[i] > limits.upper[i] ? limits.upper[i] : limits.lower[i]) - q[i]) / scale_[i];
      right_ -= moved * square_.col(i);
      square_.row(i).setZero();
      square_.col(i).setZero();
      square_(i, i) = 1.0;
      right_[i] = moved;
    }
    if (!holds) break;
  }
  q = next_.cwiseMin(limits.upper).cwiseMax(limits.lower);
}

}  // namespace humanoid_rail
