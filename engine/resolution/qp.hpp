// The velocity closest to eq. 4.9's that keeps clear of everything and within the limits; resolution/qp.py explains it.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include <eiquadprog/eiquadprog-fast.hpp>

#include "velocity.hpp"

namespace humanoid_rail {

// Parameters of the constraints; resolution/qp.py says what they mean.
struct Safety {
  double distance = 0.0;       // The safety distance, m.
  double gain = 0.0;           // Of the velocity dampers, 1/s.
  double horizon = 0.0;        // Pairs farther apart are left out, m.
  double target = 0.0;         // The distance that the dampers keep to, m.
  double limit_gain = 0.0;     // How fast a joint may approach its position limit, 1/s.
  double task_weight = 0.0;    // Of the tasks' deviation from eq. 4.9 against that of the joints.
  double least_rate = 0.0;     // A distance that no velocity changes faster than this is left alone, m/s.
  double fastest = 0.0;        // The limit of joints without a speed limit, m/s or rad/s.
  double precision = 0.0;      // Of constraints, m/s and rad/s.
  std::vector<double> shares;  // Of the speed away from what is too near, until one can be had.
  // Independent rows A (k, n) of length 1 and sides b (k) of A q_dot = b at a configuration (n) and a time in s. May be
  // empty.
  std::function<std::pair<Matrix, Vector>(const Vector& q, double t)> equality;
};

// A solution has to satisfy its constraints to this, m/s and rad/s.
constexpr double FEASIBLE = 1e-6;

// q_dot of the quadratic program. Holds its workspace. Not to be shared between threads.
class SafeVelocity {
 public:
  SafeVelocity(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);

  // Returns q_dot of eq. 4.9 (n), m/s and rad/s, at a configuration (n) and a time in s.
  const Vector& projection_velocity(const Eigen::Ref<const Vector>& q, double t, const TaskStack& tasks,
                                    const Gains& gains);
  // Returns q_dot (n) of the program there; it is to be held for dt, s. 0 where the constraints allow none.
  const Vector& velocity(const Eigen::Ref<const Vector>& q, double t, const TaskStack& tasks, const Gains& gains,
                         const Safety& safety, double dt);
  // The same where an observation was made, by observe().
  const Vector& velocity(const Observation& at, const TaskStack& tasks, const Gains& gains, const Safety& safety,
                         double dt);
  // Finds what the program needs to know at a configuration (n) and a time in s.
  void observe(const Eigen::Ref<const Vector>& q, double t, const Gains& gains, const Safety& safety,
               Observation& seen);

  // Whether a share of a velocity (n) satisfies the equalities of the last velocity's program.
  [[nodiscard]] bool keeps_equalities(const Vector& velocity, double share = 1.0, double precision = FEASIBLE) const;
  // The rows G q_dot >= h of the last velocity (m, n) and (m): of the pairs that can bind.
  [[nodiscard]] Matrix rows() const { return G_.leftCols(count_).transpose(); }
  [[nodiscard]] Vector sides() const { return h_.head(count_); }

  SceneKinematics scene;
  GradientProjection projection;

 private:
  void bound_joints(const Vector& q, const Safety& safety, double dt);
  void slow_down_reference();
  void set_equalities(const Observation& at, const Safety& safety);
  void add_row(const Nearest& pair, const Safety& safety, double dt);
  [[nodiscard]] bool holds(const Vector& velocity, double precision) const;
  [[nodiscard]] bool solve(const Matrix& J, const Safety& safety, double share);
  void set_program(const Matrix& J, double task_weight, double share);

  Observation seen_;
  Vector lower_, upper_;
  Matrix G_;  // A column for each row of the constraints.
  Vector h_;
  Eigen::Index count_ = 0;
  Vector reference_, velocity_;
  eiquadprog::solvers::EiquadprogFast solver_;
  Eigen::Index program_rows_ = -1, program_equalities_ = -1;
  Matrix hessian_, CI_, CE_;
  Vector linear_, ci_, ce_, solution_;
};

}  // namespace humanoid_rail
