#include "inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace humanoid_rail {

namespace {

// The search takes at most this many steps.
constexpr int MAX_ITERATIONS = 60;
// The tasks are done where the norm of their errors is at most this, m.
constexpr double ARRIVED = 1e-7;
// Pairs are brought this much farther apart than they have to be, m.
constexpr double SPARE = 2e-3;
// The same of pairs of links with a distance of their own, as a share of that.
constexpr double OWN_SPARE_SHARE = 0.05;
// The damping is this share of what is left of the squared errors, ...
constexpr double DAMPING_SHARE = 0.1;
// ... and this much more, m^2.
constexpr double LEAST_DAMPING = 1e-6;
// No joint moves farther in a step than at its speed limit in this time, s.
constexpr double LONGEST_STEP = 0.3;
// A step is worth while if it takes away this share of what was left.
constexpr double WORTHWHILE = 0.03;
// The search ends after this many steps in a row that were not worth while.
constexpr int MAX_IDLE_STEPS = 12;
// A step is solved again at most this often with joints held at their limits.
constexpr int MAX_HOLDS = 4;
// A goal is pulled towards the start at most this often.
constexpr int PULLS = 8;

}  // namespace

InverseKinematics::InverseKinematics(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : scene_(robot, obstacles), scale_(robot->limits.velocity) {
  for (double& speed : scale_) speed = std::isfinite(speed) ? speed : 1.0;
}

Posture InverseKinematics::solve(const Eigen::Ref<const Vector>& start, const TaskStack& tasks, double distance) {
  const Limits& limits = robot().limits;
  const double wanted = distance + SPARE;
  Vector q = start.cwiseMin(limits.upper).cwiseMax(limits.lower);
  Posture best;
  best.q = q;
  double least = INFINITE;
  for (int iteration = 0, idle = 0; iteration < MAX_ITERATIONS && idle <= MAX_IDLE_STEPS; ++iteration) {
    scene_.observe(q, 0.0, wanted, wanted, seen_);
    tasks.evaluate(scene_.kinematics(), 0.0, error_, jacobian_);
    error_ = -error_;
    Posture here;
    here.q = q;
    here.error = error_.norm();
    double left = error_.squaredNorm();
    square_.noalias() = jacobian_.transpose().lazyProduct(jacobian_);
    right_.noalias() = jacobian_.transpose() * error_;
    if (distance > -INFINITE) keep_all_apart(distance, here, left);
    here.reached = here.error <= ARRIVED && here.apart;
    if (here.reached) return here;
    idle = left < (1.0 - WORTHWHILE) * least ? 0 : idle + 1;
    if (left < least) {
      least = left;
      best = here;
    }
    step(DAMPING_SHARE * left + LEAST_DAMPING, q);
  }
  return best;
}

Vector InverseKinematics::pulled(const Eigen::Ref<const Vector>& goal, const Eigen::Ref<const Vector>& start,
                                 const TaskStack& tasks, double distance) {
  Vector best = goal;
  double share = 0.5, least = length(best - start);
  for (int pull = 0; pull < PULLS; ++pull) {
    const Posture found = solve(best + share * (start - best), tasks, distance);
    const double nearer = length(found.q - start);
    if (found.reached && nearer < least) {
      best = found.q;
      least = nearer;
    } else {
      share /= 2.0;
    }
  }
  return best;
}

// In units of the speed limits.
double InverseKinematics::length(const Vector& step) const {
  return (scale_.array() > 0.0).select(step.array() / scale_.array(), 0.0).matrix().norm();
}

std::pair<Vector, Matrix> InverseKinematics::evaluate(const Eigen::Ref<const Vector>& q, const TaskStack& tasks) {
  tasks.evaluate(scene_.move_to(q), 0.0, error_, jacobian_);
  return {error_, jacobian_};
}

const Vector& InverseKinematics::errors(const Eigen::Ref<const Vector>& q, const TaskStack& tasks) {
  tasks.error(scene_.move_hands_to(q), 0.0, error_);
  return error_;
}

void InverseKinematics::keep_all_apart(double distance, Posture& here, double& left) {
  for (const Nearest& pair : scene_.pieces(seen_)) keep_apart(pair, distance, SPARE, here, left);
  for (const Nearest& pair : seen_.links) {
    const double kept = robot().kept_distance(pair.pair, distance);
    // Those with a distance of their own may never be much farther apart.
    keep_apart(pair, kept, kept < distance ? std::min(SPARE, OWN_SPARE_SHARE * kept) : SPARE, here, left);
  }
}

// Adds the row of a pair that is too near.
void InverseKinematics::keep_apart(const Nearest& pair, double distance, double spare, Posture& here, double& left) {
  here.clearance = std::min(here.clearance, pair.distance);
  if (pair.distance < distance) here.apart = false;
  const double lacking = distance + spare - pair.distance;
  if (lacking <= 0.0) return;
  gradient_.resize(robot().n());
  scene_.distance_gradient(pair, gradient_);
  square_.noalias() += gradient_ * gradient_.transpose();
  right_ += lacking * gradient_;
  left += lacking * lacking;
}

// Moves a configuration by the step of the normal equations; a joint that would go beyond a limit goes to it, and the
// others make up for that.
void InverseKinematics::step(double damping, Vector& q) {
  const Limits& limits = robot().limits;
  square_ = scale_.asDiagonal() * square_ * scale_.asDiagonal();
  right_ = right_.cwiseProduct(scale_);
  square_.diagonal().array() += damping;
  for (int hold = 0; hold < MAX_HOLDS; ++hold) {
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
