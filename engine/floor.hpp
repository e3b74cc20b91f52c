// The bare library calls that an evaluation of eq. 4.9 is made of: what `humanoid-rail benchmark` measures the engine by.
#pragma once

#include "safety.hpp"

namespace humanoid_rail {

// Seconds that one configuration takes: the Jacobians of all joints, the placements of the hands and of the collision
// bodies, and coal's distance of every link from every obstacle. Means over all configurations (N, n), repeated.
double floor_seconds(const Robot& robot, const Obstacles& obstacles, const Matrix& configurations, int repeats);

// Seconds that one evaluation of eq. 4.9 takes, likewise.
double velocity_seconds(GradientProjection& method, const Matrix& configurations, const Vector& targets,
                        const Gains& gains, int repeats);

// Seconds that one safe velocity takes, likewise.
double safe_velocity_seconds(SafeVelocity& method, const Matrix& configurations, const Vector& targets,
                             const Gains& gains, const Safety& safety, double dt, int repeats);

}  // namespace humanoid_rail
