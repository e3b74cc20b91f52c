#include "safety.hpp"

#include <algorithm>
#include <cmath>

namespace humanoid_rail {

namespace {

// What constraints are precise to, m/s and rad/s.
constexpr double PRECISION = 1e-9;
// What a solution has to satisfy them to.
constexpr double FEASIBLE = 1e-6;
// A speed limit that is none, m/s or rad/s.
constexpr double FASTEST = 1e4;

double part(double side, double share) { return side > 0.0 ? share * side : side; }

double margin(double distance) { return std::max(SHARE * distance, LEAST_MARGIN); }

}  // namespace

SafeVelocity::SafeVelocity(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : projection(robot, obstacles), self_clearances(robot) {
  const auto n = robot->n();
  for (const auto& [link, other] : robot->self_collision_pairs) common_.push_back(robot->common_joint(link, other));
  lower_.resize(n);
  upper_.resize(n);
  reference_.resize(n);
  velocity_.resize(n);
  hessian_.resize(n, n);
  linear_.resize(n);
  solution_.resize(n);
  CE_.resize(0, n);
  ce_.resize(0);
  const auto rows = obstacles.pieces().size() * static_cast<std::size_t>(robot->links()) + common_.size();
  const auto likely = static_cast<Eigen::Index>(std::min<std::size_t>(rows, 256));
  G_.resize(n, likely);
  h_.resize(likely);
}

const Vector& SafeVelocity::velocity(const Eigen::Ref<const Vector>& q, double t,
                                     const Eigen::Ref<const Vector>& targets, const Gains& gains,
                                     const Safety& safety, double dt) {
  look(q, t, gains, safety);
  return resolve(targets, gains, safety, dt);
}

void SafeVelocity::look(const Eigen::Ref<const Vector>& q, double t, const Gains& gains, const Safety& safety) {
  q_ = q;
  link_horizon_ = safety.distance + std::max(INFLUENCE, FREE_SPEED / safety.gain);
  obstacle_horizon_ = gains.c_kappa != 0.0 ? std::max(gains.epsilon, link_horizon_) : link_horizon_;
  projection.look(q, t, obstacle_horizon_);
  near_links_ = &self_clearances.within(link_horizon_, projection.kinematics);
}

const Vector& SafeVelocity::resolve(const Eigen::Ref<const Vector>& targets, const Gains& gains,
                                    const Safety& safety, double dt) {
  reference_ = projection.resolve(targets, gains);
  bound_joints(dt);
  // Slowed down as a whole, eq. 4.9 stays on its path.
  double slowed = 1.0;
  const Vector& fastest = projection.kinematics.robot().limits.velocity;
  for (Eigen::Index i = 0; i < reference_.size(); ++i) {
    if (std::abs(reference_[i]) > fastest[i]) slowed = std::min(slowed, fastest[i] / std::abs(reference_[i]));
  }
  reference_ *= slowed;
  count_ = 0;
  if (projection.clearances.obstacles() > 0) {
    for (const Nearest& pair : near_obstacles()) {
      if (pair.distance <= link_horizon_) add_row(pair, safety, dt, true);
    }
  }
  for (const Nearest& pair : *near_links_) add_row(pair, safety, dt, false);
  velocity_ = reference_;
  if (!holds(velocity_)) {
    const Matrix& J = projection.kinematics.jacobian();
    const bool solved = std::any_of(std::begin(SHARES), std::end(SHARES), [&](double share) { return solve(J, share); });
    if (!solved) velocity_.setZero();
  }
  return velocity_;
}

// Velocities within the limits that keep positions within theirs: q_dot <= k (q_max - q), with k not more than 1/dt.
void SafeVelocity::bound_joints(double dt) {
  const Limits& limits = projection.kinematics.robot().limits;
  const double k = std::min(LIMIT_GAIN, 1.0 / dt);
  upper_ = limits.velocity.cwiseMin(FASTEST).cwiseMin(k * (limits.upper - q_)).cwiseMax(0.0);
  lower_ = (-limits.velocity).cwiseMax(-FASTEST).cwiseMax(k * (limits.lower - q_)).cwiseMin(0.0);
}

// The velocity damper d_dot >= -k (d - d_s), unless no velocity within the joints' bounds can break it. What it asks for
// away from an obstacle is at most half of what they allow.
void SafeVelocity::add_row(const Nearest& pair, const Safety& safety, double dt, bool with_obstacle) {
  const auto& kinematics = projection.kinematics;
  const Robot& robot = kinematics.robot();
  const double target = safety.distance + margin(safety.distance);
  const double wanted = -std::min(safety.gain, 1.0 / dt) * (pair.distance - target) - pair.rate;
  if (count_ == G_.cols()) {
    G_.conservativeResize(Eigen::NoChange, 2 * count_ + 1);
    h_.conservativeResize(2 * count_ + 1);
  }
  auto row = G_.col(count_);
  row.setZero();
  if (with_obstacle) {
    kinematics.add_wrench(pair.wrench(), robot.joint_of(pair.link), 0, -1.0, row);
  } else {
    const auto common = common_[static_cast<std::size_t>(pair.pair)];
    kinematics.add_wrench(pair.wrench(), robot.joint_of(pair.link), common, -1.0, row);
    kinematics.add_wrench(pair.wrench(), robot.joint_of(pair.other), common, 1.0, row);
  }
  const double slowest = row.cwiseMax(0.0).dot(lower_) + row.cwiseMin(0.0).dot(upper_);
  const double fastest = row.cwiseMax(0.0).dot(upper_) + row.cwiseMin(0.0).dot(lower_);
  const double h = std::min(wanted, 0.5 * fastest);
  if (slowest >= h || fastest - slowest < LEAST_RATE) return;
  h_[count_++] = h;
}

bool SafeVelocity::holds(const Vector& velocity) const {
  for (Eigen::Index i = 0; i < velocity.size(); ++i) {
    if (velocity[i] > upper_[i] + PRECISION || velocity[i] < lower_[i] - PRECISION) return false;
  }
  for (Eigen::Index i = 0; i < count_; ++i) {
    if (G_.col(i).dot(velocity) < h_[i] - PRECISION) return false;
  }
  return true;
}

// Sets velocity to the closest to the reference: min |x - r|^2 + w |J (x - r)|^2 within the bounds and G x >= h, where of
// h > 0 only a share counts.
bool SafeVelocity::solve(const Matrix& J, double share) {
  const Eigen::Index n = J.cols(), rows = count_ + 2 * n;
  if (ci_.size() != rows) {
    solver_.reset(static_cast<std::size_t>(n), 0, static_cast<std::size_t>(rows));
    CI_.resize(rows, n);
    ci_.resize(rows);
  }
  hessian_.noalias() = TASK_WEIGHT * J.transpose().lazyProduct(J);
  hessian_.diagonal().array() += 1.0;
  linear_.noalias() = -hessian_.lazyProduct(reference_);
  CI_.topRows(2 * n).setZero();
  CI_.topRows(n).diagonal().setOnes();
  CI_.middleRows(n, n).diagonal().setConstant(-1.0);
  ci_.head(n) = -lower_;
  ci_.segment(n, n) = upper_;
  for (Eigen::Index i = 0; i < count_; ++i) {
    // The solver takes what is small for zero, so rows have length 1.
    const double scale = 1.0 / G_.col(i).norm();
    CI_.row(2 * n + i) = scale * G_.col(i);
    ci_[2 * n + i] = -scale * part(h_[i], share);
  }
  const auto status = solver_.solve_quadprog(hessian_, linear_, CE_, ce_, CI_, ci_, solution_);
  if (status != eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL || !solution_.allFinite()) return false;
  velocity_ = solution_.cwiseMin(upper_).cwiseMax(lower_);
  // Rounding may mislead the solver where constraints all but contradict each other.
  for (Eigen::Index i = 0; i < count_; ++i) {
    if (G_.col(i).dot(velocity_) < part(h_[i], share) - FEASIBLE) return false;
  }
  return true;
}

}  // namespace humanoid_rail
