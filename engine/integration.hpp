// Integrates q_dot until the hands reach their targets, or cannot. Beside humanoid_rail/integration.py.
#pragma once

#include "resolution.hpp"

namespace humanoid_rail {

struct Settings {
  double tolerance;     // Norm of e that ends the motion, m.
  double dt;            // Time between samples, s.
  double max_time;      // Longest motion, s.
  double rtol, atol;    // Of the integrator.
  int max_evaluations;  // Evaluations of q_dot after which a motion is called stalled.
  double patience;      // How long a motion may be held by a singularity, s.
  double progress;      // How long the hands may get no nearer, s; of the safe velocity alone.
  double planning_time;  // How long planning may take, s; of the safe velocity alone.
};

enum class Status { reached, stalled, time_limit, singular, overrun, out_of_time };

struct Integration {
  Status status;
  double left;         // |e| at the end, m.
  int evaluations;     // Of q_dot.
  std::string broken;  // Why the integrator could not go on, if so.
  std::size_t n;       // Length of a configuration.
  // Samples (N) and (N, n): 0, dt, 2 dt, ... and the end.
  std::vector<double> t, q;
  // Where the integrator's steps begin, (M) and (M, n), and how fast the motion is there.
  std::vector<double> visited_t, visited_q, visited_velocity;
};

// Integrates q_dot of eq. 4.9 from a start (n) by the method of Dormand and Prince.
Integration integrate(GradientProjection& method, const Vector& start, const Vector& targets, const Gains& gains,
                      const Settings& settings);

}  // namespace humanoid_rail
