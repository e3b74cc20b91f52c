// Integrates q_dot of eq. 4.9 until the tasks are done, or cannot be.
#pragma once

#include <string>
#include <vector>

#include "velocity.hpp"

namespace humanoid_rail {

struct Settings {
  double tolerance = 0.0;           // Norm of e that ends the motion, m.
  double dt = 0.0;                  // Time between samples, s.
  double max_time = 0.0;            // Longest motion, s.
  double rtol = 0.0, atol = 0.0;    // Of the integrator.
  int max_evaluations = 0;          // Evaluations of q_dot after which a motion has stalled.
  double patience = 0.0;            // How long a motion may be held by a singularity, s.
  double progress = 0.0;            // How long the hands may get no nearer, s; of the safe velocity alone.
  double planning_time = INFINITE;  // How long planning may take, s; of the safe velocity alone.
};

// While a singularity holds a motion, the error in the lost direction does not fall by this share.
constexpr double HELD = 0.05;

// How long a singularity has held a motion; resolution/integrate.py explains it.
struct SingularityWatch {
  double since = INFINITE;  // When it began, s.
  double error = INFINITE;  // The error in the lost direction then, m.

  // Looks at an error in the lost direction, m, at a time, s.
  void look(double t, double lost, double tolerance) {
    if (lost <= tolerance) {
      *this = {};
    } else if (lost < (1.0 - HELD) * error) {
      *this = {t, lost};
    }
  }
};

enum class Status { reached, stalled, time_limit, singular, overrun, out_of_time };

struct Integration {
  Status status = Status::stalled;
  double left = INFINITE;  // |e| at the end, m.
  int evaluations = 0;     // Of q_dot.
  std::string broken;      // Why the integrator could not go on, if so.
  std::size_t n = 0;       // Length of a configuration.
  // Samples (N) and (N, n): 0, dt, 2 dt, ... and the end.
  std::vector<double> t, q;
  // Where the integrator's steps begin, (M) and (M, n), and how fast the motion is there.
  std::vector<double> visited_t, visited_q, visited_velocity;

  void sample(double time, const Eigen::Ref<const Vector>& at);
  void visit(double time, const Eigen::Ref<const Vector>& at, const Eigen::Ref<const Vector>& velocity);
};

// Integrates q_dot of eq. 4.9 from a start (n) by the method of Dormand and Prince.
[[nodiscard]] Integration integrate(SceneKinematics& scene, GradientProjection& method, const Vector& start,
                                    const TaskStack& tasks, const Gains& gains, const Settings& settings);

}  // namespace humanoid_rail
