// The velocity closest to eq. 4.9's that keeps clear and within limits. Beside humanoid_rail/safety.py.
#pragma once

#include <eiquadprog/eiquadprog-fast.hpp>

#include "resolution.hpp"

namespace humanoid_rail {

// Parameters of the constraints, as in safety.py.
struct Safety {
  double distance;  // The safety distance, m.
  double gain;      // Of the velocity dampers, 1/s.
};

// How far beyond the safety distance pairs are looked at: so far that their damper would allow this speed, m/s, but at
// least so far, m.
constexpr double FREE_SPEED = 2.0, INFLUENCE = 0.5;
// How fast a joint may approach its position limit, 1/s.
constexpr double LIMIT_GAIN = 10.0;
// The weight of the hands' deviation from eq. 4.9 against that of the joints.
constexpr double TASK_WEIGHT = 1000.0;
// The dampers keep to the safety distance and a little more, so that what a step bends towards an obstacle is made good
// before the distance itself is reached: a share of it, but at least this much, m.
constexpr double SHARE = 0.1, LEAST_MARGIN = 1e-3;
// A distance that no velocity changes faster than this is left alone, m/s.
constexpr double LEAST_RATE = 1e-6;
// How much of the speed away from what is too near is asked for, until as much can be had at once.
constexpr double SHARES[] = {1.0, 0.5, 0.25, 0.125, 0.0};

// q_dot of the quadratic program, with the workspace that takes. Not to be shared between threads.
class SafeVelocity {
 public:
  SafeVelocity(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);

  // Returns q_dot (n), m/s and rad/s, at a configuration (n) and a time in s, for targets x_f (3h) in m; it is to be
  // held for dt, s.
  const Vector& velocity(const Eigen::Ref<const Vector>& q, double t, const Eigen::Ref<const Vector>& targets,
                         const Gains& gains, const Safety& safety, double dt);
  // The two halves of that.
  void look(const Eigen::Ref<const Vector>& q, double t, const Gains& gains, const Safety& safety);
  const Vector& resolve(const Eigen::Ref<const Vector>& targets, const Gains& gains, const Safety& safety, double dt);

  // What look() found, and within which horizons, m.
  const std::vector<Nearest>& near_obstacles() const { return projection.clearances.pieces_within(); }
  const std::vector<Nearest>& near_links() const { return *near_links_; }
  double obstacle_horizon() const { return obstacle_horizon_; }
  double link_horizon() const { return link_horizon_; }
  // The rows G q_dot >= h of the last resolve() (m, n) and (m): of the pairs that can bind.
  Matrix rows() const { return G_.leftCols(count_).transpose(); }
  Vector sides() const { return h_.head(count_); }

  GradientProjection projection;
  SelfClearances self_clearances;

 private:
  void bound_joints(double dt);
  void add_row(const Nearest& pair, const Safety& safety, double dt, bool with_obstacle);
  bool holds(const Vector& velocity) const;
  bool solve(const Matrix& J, double share);

  Vector q_;
  const std::vector<Nearest>* near_links_ = nullptr;
  double obstacle_horizon_ = 0.0, link_horizon_ = 0.0;
  std::vector<pinocchio::JointIndex> common_;  // For each pair of links the joint that carries both.
  Vector lower_, upper_;
  Matrix G_;  // A column for each row of the constraints.
  Vector h_;
  Eigen::Index count_ = 0;
  Vector reference_, velocity_;
  eiquadprog::solvers::EiquadprogFast solver_;
  Matrix hessian_, CI_, CE_;
  Vector linear_, ci_, ce_, solution_;
};

}  // namespace humanoid_rail
