// How near the links of a robot are to obstacles, the psi of eq. 3.3, and to each other. Beside
// humanoid_rail/kinematics.py and shapes.py.
#pragma once

#include <memory>
#include <vector>

#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>
#include <coal/distance_func_matrix.h>

#include "kinematics.hpp"

namespace humanoid_rail {

// Obstacles, each made of one convex piece or more, at rest or moving at a constant velocity.
class Obstacles {
 public:
  struct Piece {
    std::shared_ptr<coal::CollisionGeometry> shape;
    coal::Transform3s placement;  // At t = 0.
    Eigen::Vector3d velocity;     // m/s
    int obstacle;

    coal::Transform3s at(double t) const { return {placement.getRotation(), placement.getTranslation() + t * velocity}; }
    bool moves() const { return !velocity.isZero(0.0); }
  };

  // Adds an obstacle of one piece.
  void add(std::shared_ptr<coal::CollisionGeometry> shape, const coal::Transform3s& placement,
           const Eigen::Vector3d& velocity);
  // Adds an obstacle of convex pieces, each the hull of points (k, 3).
  void add_convex(const std::vector<Matrix>& pieces, const coal::Transform3s& placement,
                  const Eigen::Vector3d& velocity);

  const std::vector<Piece>& pieces() const { return pieces_; }
  int size() const { return size_; }
  // Whether any of them does.
  bool move() const;

 private:
  std::vector<Piece> pieces_;
  int size_ = 0;
};

// The shortest way from a link to a piece of an obstacle, or to another link.
struct Nearest {
  int pair;                // The pairs of a robot among obstacles are numbered; so are those of its own links.
  int link;
  int other;               // The obstacle, or the other link.
  int piece;               // Of the obstacle.
  double distance;         // m; negative in penetration.
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   // On the link, in the base frame.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // From the link to the other, in penetration too.
  double rate;             // How fast the distance grows by the obstacle's own motion, m/s.

  // A unit force along the normal at the point, at the base's origin: d psi/dq is minus what it does on the joints of
  // the link, and plus what it does on those of the other link.
  pinocchio::Force wrench() const { return {normal, point.cross(normal)}; }
};

// Measures the distance of two shapes, with the workspace that takes.
class DistanceMeter {
 public:
  DistanceMeter() : solver_(request_) {}
  // Sets distance, point and normal.
  void measure(const coal::CollisionGeometry& a, const coal::Transform3s& placement_a, const coal::CollisionGeometry& b,
               const coal::Transform3s& placement_b, Nearest& nearest);

 private:
  coal::DistanceRequest request_;
  coal::DistanceResult result_;
  coal::GJKSolver solver_;
};

// Finds which obstacles are near, with the workspace that takes. Not to be shared between threads.
class Clearances {
 public:
  Clearances(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);
  Clearances(const Clearances&) = delete;  // The tree points into what is here.
  Clearances& operator=(const Clearances&) = delete;

  // Moves the obstacles to where they are at a time, s.
  void move_to(double t);
  // Returns, link by link, every pair of a link and an obstacle whose distance is not more than the horizon. What lies
  // in bounding boxes farther away is not measured. The result holds until the next call.
  const std::vector<Nearest>& within(double horizon, const Kinematics& kinematics);
  // The same, or the shortest distance of all where every one is beyond the horizon.
  const std::vector<Nearest>& within_or_nearest(double horizon, const Kinematics& kinematics);
  // The pairs of a link and a piece of an obstacle that the last call found within its horizon.
  const std::vector<Nearest>& pieces_within() const { return compound_ ? nearest_pieces_ : nearest_; }

  int obstacles() const { return obstacles_; }
  const std::vector<Obstacles::Piece>& pieces() const { return pieces_; }

 private:
  struct Body {
    const Obstacles::Piece* piece;
    int index;
    coal::Transform3s placement;  // Now.
  };
  struct Candidates : coal::CollisionCallBackBase {
    bool collide(coal::CollisionObject* piece, coal::CollisionObject* link) override;
    std::vector<const Body*> found;
  };

  void measure(int link, const coal::Transform3s& placement, const Body& body, double horizon);

  std::shared_ptr<const Robot> robot_;
  std::vector<Obstacles::Piece> pieces_;
  int obstacles_;
  bool compound_;  // Whether an obstacle has more than one piece.
  double t_ = 0.0;
  std::vector<Body> bodies_;
  std::vector<std::pair<Body*, coal::CollisionObject*>> moving_;
  std::vector<coal::CollisionObject> links_;
  std::vector<coal::CollisionObject> boxed_;
  std::vector<const Body*> unbounded_;
  // Not coal's array of nodes, which is never freed.
  coal::DynamicAABBTreeCollisionManager tree_;
  Candidates candidates_;
  std::vector<Nearest> nearest_, nearest_pieces_;
  std::vector<std::size_t> first_of_;  // For each obstacle, one after where the link at hand has it in nearest_.
  DistanceMeter meter_;
};

// Finds which links are near each other: of all pairs that the robot has to check. Not to be shared between threads.
class SelfClearances {
 public:
  explicit SelfClearances(std::shared_ptr<const Robot> robot);

  // Returns every pair whose distance is not more than the horizon, in the robot's order. Holds until the next call.
  const std::vector<Nearest>& within(double horizon, const Kinematics& kinematics);

 private:
  std::shared_ptr<const Robot> robot_;
  std::vector<coal::Transform3s> placements_;
  std::vector<Eigen::Vector3d> middles_;
  std::vector<Nearest> nearest_;
  DistanceMeter meter_;
};

}  // namespace humanoid_rail
