// How near a robot is to everything at samples of a motion, and how that changes with them.
#pragma once

#include "../kinematics/scene_kinematics.hpp"

namespace humanoid_rail {

// The pairs that a small change of the samples may bring too near. R rows, n joints.
struct ClearanceRows {
  Eigen::VectorXi sample;  // (R)
  Vector spare;            // (R), m: how much farther apart the pair is than it has to be; negative if it is too near.
  Rows gradient;           // (R, n), of the spare distance.
  Vector least;            // (N), m: the smallest spare distance at each sample; infinite beyond the horizon.
};

// Returns the rows at samples (N, n) among obstacles where they are at t = 0, where every pair keeps a distance, or the
// smaller one of its own. Pairs farther apart than the horizon are left out, and those that are not too near after any
// change of the sample within `reach` (n) to first order.
[[nodiscard]] ClearanceRows clearance_rows(SceneKinematics& scene, const Eigen::Ref<const Rows>& samples,
                                           double distance, double horizon, const Eigen::Ref<const Vector>& reach);

}  // namespace humanoid_rail
