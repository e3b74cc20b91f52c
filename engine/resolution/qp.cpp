#include "qp.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/QR>

namespace humanoid_rail {

namespace {

// Room is made for this many rows at first.
constexpr Eigen::Index LIKELY_ROWS = 256;
// Rows of what is kept that come this near to following from others do so.
constexpr double DEPENDENT_ROW = 1e-6;

}  // namespace

SafeVelocity::SafeVelocity(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : scene(robot, obstacles), projection(*robot) {
  const auto n = robot->n();
  for (Vector* vector : {&lower_, &upper_, &fallback_, &reference_, &velocity_, &linear_, &solution_})
    vector->setZero(n);
  hessian_.resize(n, n);
  CE_.resize(0, n);
  G_.resize(n, LIKELY_ROWS);
  h_.resize(LIKELY_ROWS);
}

const Vector& SafeVelocity::projection_velocity(const Eigen::Ref<const Vector>& q, double t, const TaskStack& tasks,
                                                const Gains& gains) {
  scene.observe(q, t, gains.horizon(), -INFINITE, seen_);
  return projection.velocity(scene, seen_, tasks, gains);
}

const Vector& SafeVelocity::velocity(const Eigen::Ref<const Vector>& q, double t, const TaskStack& tasks,
                                     const Gains& gains, const Safety& safety, double dt) {
  observe(q, t, gains, safety, seen_);
  return velocity(seen_, tasks, gains, safety, dt);
}

void SafeVelocity::observe(const Eigen::Ref<const Vector>& q, double t, const Gains& gains, const Safety& safety,
                           Observation& seen) {
  scene.glance(q, t, std::max(gains.horizon(), safety.horizon), safety.horizon, seen);
}

const Vector& SafeVelocity::velocity(const Observation& at, const TaskStack& tasks, const Gains& gains,
                                     const Safety& safety, double dt) {
  bound_joints(at.q, safety, dt);
  fallback_.setZero();
  return best_velocity(at, tasks, gains, safety, dt);
}

const Vector& SafeVelocity::velocity(const Observation& at, const TaskStack& tasks, const Gains& gains,
                                     const Safety& safety, double dt, const Reachable& reachable) {
  bound_joints(at.q, safety, dt);
  fallback_ = reachable.fallback;
  upper_ = upper_.cwiseMin(reachable.upper).cwiseMax(fallback_);
  lower_ = lower_.cwiseMax(reachable.lower).cwiseMin(fallback_);
  return best_velocity(at, tasks, gains, safety, dt);
}

// The velocity within the bounds that are set.
const Vector& SafeVelocity::best_velocity(const Observation& at, const TaskStack& tasks, const Gains& gains,
                                          const Safety& safety, double dt) {
  reference_ = projection.velocity(scene, at, tasks, gains);
  slow_down_reference();
  set_equalities(at, safety);
  count_ = 0;
  const double target = safety.target();
  for (const Nearest& pair : scene.pieces(at)) {
    if (pair.distance <= safety.horizon) add_row(pair, target, safety, dt);
  }
  for (const Nearest& pair : at.links) add_row(pair, target_of(pair.pair, safety), safety, dt);
  list_late_rows(at);
  velocity_ = reference_;
  const bool is_late = add_broken_rows(reference_, safety, dt, 1.0);
  if (!is_late && holds(velocity_, safety.precision)) return velocity_;
  const Matrix& J = projection.jacobian();
  const auto can_be_had = [&](double share) { return solve(J, safety, dt, share); };
  if (!std::any_of(safety.shares.begin(), safety.shares.end(), can_be_had)) velocity_ = fallback_;
  return velocity_;
}

// Velocities within the limits that keep positions within theirs: q_dot <= k (q_max - q), with k not more than 1/dt.
void SafeVelocity::bound_joints(const Vector& q, const Safety& safety, double dt) {
  const Limits& limits = scene.robot().limits;
  const double k = std::min(safety.limit_gain, 1.0 / dt);
  upper_ = limits.velocity.cwiseMin(safety.fastest).cwiseMin(k * (limits.upper - q)).cwiseMax(0.0);
  lower_ = (-limits.velocity).cwiseMax(-safety.fastest).cwiseMax(k * (limits.lower - q)).cwiseMin(0.0);
}

// Slowed down as a whole, eq. 4.9 stays on its path.
void SafeVelocity::slow_down_reference() {
  double slowed = 1.0;
  const Vector& fastest = scene.robot().limits.velocity;
  for (Eigen::Index i = 0; i < reference_.size(); ++i) {
    if (std::abs(reference_[i]) > fastest[i]) slowed = std::min(slowed, fastest[i] / std::abs(reference_[i]));
  }
  reference_ *= slowed;
}

void SafeVelocity::set_equalities(const Observation& at, const Safety& safety) {
  CE_.resize(0, reference_.size());
  ce_.resize(0);
  if (safety.equality) {
    const auto [A, b] = safety.equality(at.q, at.t);
    if (A.cols() != reference_.size() || A.rows() != b.size() || A.rows() > A.cols() || !A.allFinite() ||
        !b.allFinite()) {
      throw std::invalid_argument("equalities need finite, independent rows A (k, n) and sides b (k)");
    }
    CE_ = A;
    ce_ = -b;
  }
  if (safety.constraints) add_kept_rows(at, *safety.constraints);
}

// Adds independent rows of length 1 that span those of what is kept.
void SafeVelocity::add_kept_rows(const Observation& at, const TaskStack& kept) {
  kept.evaluate(scene.move_to(at.q), at.t, kept_error_, kept_rows_);
  Eigen::ColPivHouseholderQR<Matrix> qr;
  qr.setThreshold(DEPENDENT_ROW);
  qr.compute(kept_rows_.transpose());
  const Eigen::Index rank = qr.rank(), before = ce_.size();
  const Matrix basis = qr.householderQ() * Matrix::Identity(reference_.size(), rank);
  CE_.conservativeResize(before + rank, reference_.size());
  CE_.bottomRows(rank) = basis.transpose();
  ce_.conservativeResize(before + rank);
  ce_.tail(rank).setZero();
}

bool SafeVelocity::keeps_equalities(const Vector& velocity, double share, double precision) const {
  for (Eigen::Index i = 0; i < ce_.size(); ++i) {
    if (!(std::abs(share * CE_.row(i).dot(velocity) + ce_[i]) <= precision)) return false;
  }
  return true;
}

double SafeVelocity::target_of(int pair, const Safety& safety) const {
  return safety.target_of(scene.robot().kept_distance(pair, safety.distance));
}

void SafeVelocity::add_row(const Nearest& pair, double target, const Safety& safety, double dt) {
  const double side = make_row(pair, target, safety, dt);
  if (side > -INFINITE) h_[count_++] = side;
}

// The velocity damper d_dot >= -k (d - d_s): sets the next row and returns the side; minus infinity where no velocity
// within the joints' bounds can break it. What it asks for beyond the fallback is at most half of what they allow.
double SafeVelocity::make_row(const Nearest& pair, double target, const Safety& safety, double dt) {
  const double wanted = -safety.gain_for(dt) * (pair.distance - target) - pair.rate;
  make_room();
  auto row = G_.col(count_);
  scene.distance_gradient(pair, row);
  const double slowest = row.cwiseMax(0.0).dot(lower_) + row.cwiseMin(0.0).dot(upper_);
  const double fastest = row.cwiseMax(0.0).dot(upper_) + row.cwiseMin(0.0).dot(lower_);
  const double base = row.dot(fallback_);
  const double side = std::min(wanted, base + 0.5 * (fastest - base));
  return slowest >= side || fastest - slowest < safety.least_rate ? -INFINITE : side;
}

// The side of a row of which only a share counts beyond what the fallback gives.
double SafeVelocity::part(const Eigen::Ref<const Vector>& row, double side, double share) const {
  const double base = row.dot(fallback_);
  return side > base ? base + share * (side - base) : side;
}

void SafeVelocity::make_room() {
  if (count_ < G_.cols()) return;
  G_.conservativeResize(Eigen::NoChange, 2 * count_ + 1);
  h_.conservativeResize(2 * count_ + 1);
}

void SafeVelocity::list_late_rows(const Observation& at) {
  late_.resize(at.unmeasured.size());
  for (std::size_t i = 0; i < late_.size(); ++i) {
    late_[i].pair = at.unmeasured[i];
    late_[i].known = LateRow::Known::bound;
  }
}

// Adds those rows of pairs not measured before that a velocity breaks. Returns whether there are any.
//
// What is left out changes nothing. With the distance d >= b of a pair and its speed of approach -d_dot <= a, both
// bounds, the row d_dot >= -k (d - d_s) is kept by every velocity with a <= k (b - d_s), and so is a row that asks for
// less. A velocity that is the best of those which some of the rows allow, and keeps the others, is the best of those
// which all of them allow. Which rows are added follows from their distances alone, never from how good the bounds are.
bool SafeVelocity::add_broken_rows(const Vector& velocity, const Safety& safety, double dt, double share) {
  if (late_.empty()) return false;
  const LinkBoxes& boxes = scene.moving_boxes(velocity);
  const Eigen::Index before = count_;
  const double gain = safety.gain_for(dt);
  for (LateRow& late : late_) {
    using Known = LateRow::Known;
    if (late.known == Known::all) continue;
    if (late.known == Known::bound) {
      const double target = target_of(late.pair.pair, safety);
      const auto& [link, other] = scene.robot().self_collision_pairs[static_cast<std::size_t>(late.pair.pair)];
      if (boxes.approach(link, other) <= gain * (late.pair.bound - target)) continue;
      const Nearest nearest = scene.measure_links(late.pair.pair);
      late.side = nearest.distance <= safety.horizon ? make_row(nearest, target, safety, dt) : -INFINITE;
      late.known = late.side > -INFINITE ? Known::row : Known::all;
      if (late.known == Known::all) continue;
      late.row = G_.col(count_);
    }
    if (late.row.dot(velocity) >= part(late.row, late.side, share) - safety.precision) continue;
    late.known = Known::all;
    make_room();
    G_.col(count_) = late.row;
    h_[count_++] = late.side;
  }
  return count_ > before;
}

bool SafeVelocity::holds(const Vector& velocity, double precision) const {
  // Comparisons with what is no number are false.
  for (Eigen::Index i = 0; i < velocity.size(); ++i) {
    if (!(velocity[i] <= upper_[i] + precision && velocity[i] >= lower_[i] - precision)) return false;
  }
  for (Eigen::Index i = 0; i < count_; ++i) {
    if (!(G_.col(i).dot(velocity) >= h_[i] - precision)) return false;
  }
  return keeps_equalities(velocity, 1.0, precision);
}

// The same with all rows, also those that were not made before.
bool SafeVelocity::solve(const Matrix& J, const Safety& safety, double dt, double share) {
  do {
    if (!solve_known(J, safety, share)) return false;
  } while (add_broken_rows(velocity_, safety, dt, share));
  return true;
}

// Sets velocity to the closest to the reference: min |x - r|^2 + w |J (x - r)|^2 within the bounds, G x >= h and A x =
// b, where of what h asks for beyond the fallback only a share counts.
bool SafeVelocity::solve_known(const Matrix& J, const Safety& safety, double share) {
  set_program(J, safety.task_weight, share);
  const auto status = solver_.solve_quadprog(hessian_, linear_, CE_, ce_, CI_, ci_, solution_);
  if (status != eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL || !solution_.allFinite()) return false;
  velocity_ = solution_.cwiseMin(upper_).cwiseMax(lower_);
  // Rounding may mislead the solver where constraints all but contradict each other.
  for (Eigen::Index i = 0; i < count_; ++i) {
    if (G_.col(i).dot(velocity_) < part(G_.col(i), h_[i], share) - FEASIBLE) return false;
  }
  return keeps_equalities(velocity_);
}

void SafeVelocity::set_program(const Matrix& J, double task_weight, double share) {
  const Eigen::Index n = J.cols(), rows = count_ + 2 * n;
  if (rows != program_rows_ || ce_.size() != program_equalities_) {
    program_rows_ = rows;
    program_equalities_ = ce_.size();
    solver_.reset(static_cast<std::size_t>(n), static_cast<std::size_t>(ce_.size()), static_cast<std::size_t>(rows));
    CI_.resize(rows, n);
    ci_.resize(rows);
  }
  hessian_.noalias() = task_weight * J.transpose().lazyProduct(J);
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
    ci_[2 * n + i] = -scale * part(G_.col(i), h_[i], share);
  }
}

}  // namespace humanoid_rail
