// How near two bodies are, and what measures it.
#pragma once

#include <coal/collision_data.h>
#include <coal/narrowphase/narrowphase.h>
#include <pinocchio/spatial/force.hpp>

#include "../types.hpp"

namespace humanoid_rail {

// The shortest line from a link to a piece of an obstacle, or to another link.
struct Nearest {
  int pair = -1;  // The pairs of a robot among obstacles are numbered; so are those of its own links.
  int link = -1;
  int other = -1;                                    // The obstacle, or the other link.
  int piece = -1;                                    // The piece of all obstacles' pieces; -1 for two links.
  double distance = INFINITE;                        // m; negative in penetration.
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   // On the link, in the base frame.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // From the link to the other, in penetration too.
  double rate = 0.0;                                 // How fast the distance grows by the obstacle's own motion, m/s.

  [[nodiscard]] bool is_with_obstacle() const { return piece >= 0; }
  // A unit force along the normal at the point, at the base's origin: d psi/dq is minus what it does on the joints of
  // the link, and plus what it does on those of the other link.
  [[nodiscard]] pinocchio::Force wrench() const { return {normal, point.cross(normal)}; }
};

// Measures the distance of two shapes. Holds its workspace.
class DistanceMeter {
 public:
  // Without depths of penetration, which cost many times what distances do, those without a closed form are infinite.
  explicit DistanceMeter(bool depths = true);
  // Sets distance, point and normal.
  void measure(const coal::CollisionGeometry& a, const coal::Transform3s& placement_a, const coal::CollisionGeometry& b,
               const coal::Transform3s& placement_b, Nearest& nearest);

 private:
  coal::DistanceRequest request_, cylinder_request_;
  coal::DistanceResult result_;
  coal::GJKSolver solver_;
};

}  // namespace humanoid_rail
