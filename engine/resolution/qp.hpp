// The velocity closest to eq. 4.9's that keeps clear of everything and within the limits; resolution/qp.py explains it.
#pragma once

#include <algorithm>
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
  double margin_share = 0.0;   // The dampers keep to the safety distance and this share of it more, ...
  double least_margin = 0.0;   // ... at least this much more, m.
  double limit_gain = 0.0;     // How fast a joint may approach its position limit, 1/s.
  double task_weight = 0.0;    // Of the tasks' deviation from eq. 4.9 against that of the joints.
  double least_rate = 0.0;     // A distance that no velocity changes faster than this is left alone, m/s.
  double fastest = 0.0;        // The limit of joints without a speed limit, m/s or rad/s.
  double precision = 0.0;      // Of constraints, m/s and rad/s.
  std::vector<double> shares;  // Of the speed away from what is too near, until one can be had.
  // Independent rows A (k, n) of length 1 and sides b (k) of A q_dot = b at a configuration (n) and a time in s. May be
  // empty.
  std::function<std::pair<Matrix, Vector>(const Vector& q, double t)> equality;
  // What holds and goes on to: its rows are equalities with sides 0. May be none.
  std::shared_ptr<const TaskStack> constraints;

  // The gain where a velocity is held for so long, s.
  [[nodiscard]] double gain_for(double dt) const { return std::min(gain, 1.0 / dt); }
  // The distance that the dampers keep to, m.
  [[nodiscard]] double target() const { return distance + std::max(margin_share * distance, least_margin); }
  // The same of a pair of links.
  [[nodiscard]] double target_of(double kept) const {
    return kept < distance ? std::min(kept + margin_share * kept, target()) : target();
  }
};

// Velocities that can be had: within bounds (n), and one of them (n) that always may be chosen, m/s and rad/s.
struct Reachable {
  Vector lower, upper, fallback;
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
  // The same among the velocities that can be had; where the constraints allow none of them it is the fallback. Rows
  // ask for more than that gives only as far as can be had.
  const Vector& velocity(const Observation& at, const TaskStack& tasks, const Gains& gains, const Safety& safety,
                         double dt, const Reachable& reachable);
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
  // The row of a pair of links that was not measured: it is made once a velocity could break it.
  struct LateRow {
    enum class Known { bound, row, all };  // The bound alone, the row too, or that it is no longer needed.
    Unmeasured pair;
    Known known = Known::bound;
    Vector row;
    double side = 0.0;
  };

  const Vector& best_velocity(const Observation& at, const TaskStack& tasks, const Gains& gains, const Safety& safety,
                              double dt);
  void bound_joints(const Vector& q, const Safety& safety, double dt);
  [[nodiscard]] double part(const Eigen::Ref<const Vector>& row, double side, double share) const;
  void slow_down_reference();
  void set_equalities(const Observation& at, const Safety& safety);
  void add_kept_rows(const Observation& at, const TaskStack& kept);
  void add_row(const Nearest& pair, double target, const Safety& safety, double dt);
  [[nodiscard]] double make_row(const Nearest& pair, double target, const Safety& safety, double dt);
  void make_room();
  void list_late_rows(const Observation& at);
  [[nodiscard]] bool add_broken_rows(const Vector& velocity, const Safety& safety, double dt, double share);
  [[nodiscard]] double target_of(int pair, const Safety& safety) const;
  [[nodiscard]] bool holds(const Vector& velocity, double precision) const;
  [[nodiscard]] bool solve(const Matrix& J, const Safety& safety, double dt, double share);
  [[nodiscard]] bool solve_known(const Matrix& J, const Safety& safety, double share);
  void set_program(const Matrix& J, double task_weight, double share);

  Observation seen_;
  Vector lower_, upper_;
  Vector fallback_;  // Always allowed: 0, unless velocities that can be had are given.
  Matrix G_;         // A column for each row of the constraints.
  Vector h_;
  Eigen::Index count_ = 0;
  std::vector<LateRow> late_;  // In the order of their pairs.
  Vector reference_, velocity_;
  eiquadprog::solvers::EiquadprogFast solver_;
  Eigen::Index program_rows_ = -1, program_equalities_ = -1;
  Matrix hessian_, CI_, CE_;
  Vector linear_, ci_, ce_, solution_, kept_error_;
  Matrix kept_rows_;
};

}  // namespace humanoid_rail
