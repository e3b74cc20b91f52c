// How near the links of a robot are to obstacles: the psi of eq. 3.3. Beside humanoid_rail/kinematics.py and shapes.py.
#pragma once

#include <memory>
#include <vector>

#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>
#include <coal/distance_func_matrix.h>

#include "kinematics.hpp"

namespace humanoid_rail {

// Obstacles at rest, each made of one convex piece or more.
class Obstacles {
 public:
  struct Piece {
    std::shared_ptr<coal::CollisionGeometry> shape;
    coal::Transform3s placement;
    int obstacle;
  };

  // Adds an obstacle of one piece.
  void add(std::shared_ptr<coal::CollisionGeometry> shape, const coal::Transform3s& placement);
  // Adds an obstacle of convex pieces, each the hull of points (k, 3).
  void add_convex(const std::vector<Matrix>& pieces, const coal::Transform3s& placement);

  const std::vector<Piece>& pieces() const { return pieces_; }
  int size() const { return size_; }

 private:
  std::vector<Piece> pieces_;
  int size_ = 0;
};

// The shortest way from a link to an obstacle.
struct Nearest {
  int link;
  int obstacle;
  double distance;           // m; negative in penetration.
  Eigen::Vector3d point;     // On the link, in the base frame.
  Eigen::Vector3d normal;    // From the link to the obstacle, in penetration too.

  // A unit force along the normal at the point, at the base's origin: d psi/dq is minus what it does on the joints.
  pinocchio::Force wrench() const { return {normal, point.cross(normal)}; }
};

// Finds which obstacles are near, with the workspace that takes. Not to be shared between threads.
class Clearances {
 public:
  Clearances(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);
  Clearances(const Clearances&) = delete;  // The tree points into what is here.
  Clearances& operator=(const Clearances&) = delete;

  // Returns, link by link, every pair whose distance is not more than the horizon. What lies in bounding boxes farther
  // away is not measured. The result holds until the next call.
  const std::vector<Nearest>& within(double horizon, const Kinematics& kinematics);
  // The same, or the shortest distance of all where every one is beyond the horizon.
  const std::vector<Nearest>& within_or_nearest(double horizon, const Kinematics& kinematics);

  int obstacles() const { return obstacles_; }

 private:
  struct Candidates : coal::CollisionCallBackBase {
    bool collide(coal::CollisionObject* piece, coal::CollisionObject* link) override;
    std::vector<const Obstacles::Piece*> found;
  };

  void measure(int link, const coal::Transform3s& placement, const Obstacles::Piece& piece, double horizon);

  std::shared_ptr<const Robot> robot_;
  std::vector<Obstacles::Piece> pieces_;
  int obstacles_;
  std::vector<coal::CollisionObject> links_;
  std::vector<coal::CollisionObject> boxed_;
  std::vector<const Obstacles::Piece*> unbounded_;
  // Not coal's array of nodes, which is never freed.
  coal::DynamicAABBTreeCollisionManager tree_;
  Candidates candidates_;
  std::vector<Nearest> nearest_;
  std::vector<std::size_t> first_of_;  // For each obstacle, one after where the link at hand has it in nearest_.
  coal::DistanceRequest request_;
  coal::GJKSolver solver_;
};

}  // namespace humanoid_rail
