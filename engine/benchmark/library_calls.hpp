// The bare library calls that an evaluation of eq. 4.9 is made of: what `make benchmark` measures the engine by.
#pragma once

#include "../resolution/qp.hpp"

namespace humanoid_rail {

// Seconds that one configuration takes: the Jacobians of all joints, the placements of the hands and of the collision
// bodies, and coal's distance of every link from every obstacle. Means over all configurations (N, n), repeated.
[[nodiscard]] double library_call_seconds(const Robot& robot, const Obstacles& obstacles, const Matrix& configurations,
                                          int repeats);

// Seconds that one evaluation of eq. 4.9 takes, likewise.
[[nodiscard]] double velocity_seconds(SafeVelocity& method, const Matrix& configurations, const TaskStack& tasks,
                                      const Gains& gains, int repeats);

// Seconds that one safe velocity takes, likewise.
[[nodiscard]] double safe_velocity_seconds(SafeVelocity& method, const Matrix& configurations, const TaskStack& tasks,
                                           const Gains& gains, const Safety& safety, double dt, int repeats);

}  // namespace humanoid_rail
