// Everything that is true of a robot among obstacles at a configuration, or along a motion, as values.
#pragma once

#include "scene_kinematics.hpp"

namespace humanoid_rail {

// Shapes: n actuated joints, h hands, L links, O obstacles, K pieces of all obstacles, P pairs of links.
struct State {
  Vector hands;           // (3h), m
  Rows rotations;         // (3h, 3), from the hands' frames to the base frame.
  Rows jacobian;          // (3h, n)
  Rows angular_jacobian;  // (3h, n)
  double manipulability = 0.0;
  Vector manipulability_gradient;  // (n)
  Rows clearance;                  // (L, O), m
  Rows clearance_gradient;         // (L O, n)
  Rows piece_distance;             // (L, K), m
  Rows piece_gradient;             // (L K, n)
  Rows piece_rate;                 // (L, K), m/s
  Vector link_distance;            // (P), m
  Rows link_gradient;              // (P, n)
};

// The values of a state without its derivatives.
struct Measurement {
  Vector hands;  // (3h), m
  double manipulability = 0.0;
  Rows clearance;        // (L, O), m; infinite beyond the horizon, but for the shortest.
  Vector link_distance;  // (P), m
};

// What is true along a motion of N configurations.
struct Course {
  Rows hands;             // (N, 3h), m
  Vector manipulability;  // (N)
  Rows clearance;         // (N, O), of the nearest link, m
};

[[nodiscard]] State state(SceneKinematics& scene, const Eigen::Ref<const Vector>& q, double t);
[[nodiscard]] Measurement measure(SceneKinematics& scene, const Eigen::Ref<const Vector>& q, double t, double horizon);
// At times (N) and configurations (N, n).
[[nodiscard]] Course along(SceneKinematics& scene, const Eigen::Ref<const Vector>& t,
                           const Eigen::Ref<const Rows>& motion, double horizon);

}  // namespace humanoid_rail
