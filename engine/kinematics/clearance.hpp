// How near the links of a robot are to obstacles, the psi of eq. 3.3, and to each other.
#pragma once

#include <memory>
#include <vector>

#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>

#include "../scene/obstacles.hpp"
#include "distance.hpp"
#include "kinematics.hpp"
#include "link_boxes.hpp"

namespace humanoid_rail {

// Which obstacles are near.
struct NearObstacles {
  std::vector<Nearest> obstacles;  // For each link and obstacle the nearest piece.
  std::vector<Nearest> pieces;     // Every piece; empty where each obstacle has just one.

  // The pairs of a link and a piece.
  [[nodiscard]] const std::vector<Nearest>& by_piece(bool is_compound) const {
    return is_compound ? pieces : obstacles;
  }
};

// Finds which obstacles are near. A link and an obstacle neither of which ever moves are no pair. Holds its workspace.
// Not to be shared between threads.
class ObstacleClearances {
 public:
  ObstacleClearances(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);
  ObstacleClearances(const ObstacleClearances&) = delete;  // The tree points into what is here.
  ObstacleClearances& operator=(const ObstacleClearances&) = delete;

  // Moves the obstacles to where they are at a time, s.
  void move_to(double t);
  // Puts an obstacle elsewhere, where it is at t = 0, with another velocity. Its pieces are found there from then on.
  void place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity);
  // Finds, link by link, every pair of a link and an obstacle whose distance is not more than the horizon. What lies in
  // bounding boxes farther away is not measured.
  void within(double horizon, const Kinematics& kinematics, NearObstacles& found);
  // The same, or the shortest distance of all where every one is beyond the horizon.
  void within_or_nearest(double horizon, const Kinematics& kinematics, NearObstacles& found);

  [[nodiscard]] const Obstacles& obstacles() const { return obstacles_; }
  [[nodiscard]] const std::vector<Obstacles::Piece>& pieces() const { return obstacles_.pieces(); }

 private:
  struct Body {
    const Obstacles::Piece* piece = nullptr;
    int index = 0;
    coal::Transform3s placement;              // Now.
    coal::CollisionObject* object = nullptr;  // In the tree, unless it has no bounds.
  };
  struct Candidates : coal::CollisionCallBackBase {
    bool collide(coal::CollisionObject* piece, coal::CollisionObject* link) override;
    std::vector<const Body*> found;
  };

  void put(Body& body, double t);
  void measure(int link, const coal::Transform3s& placement, const Body& body, double horizon, NearObstacles& found);

  std::shared_ptr<const Robot> robot_;
  Obstacles obstacles_;
  double t_ = 0.0;
  bool has_pairs_ = false;
  double shortest_before_ = 0.0;  // What within_or_nearest found last beyond its horizon, m.
  std::vector<Body> bodies_;
  std::vector<Body*> moving_;
  std::vector<coal::CollisionObject> links_;
  std::vector<coal::CollisionObject> boxed_;
  std::vector<const Body*> unbounded_;
  // Not coal's array of nodes, which is never freed.
  coal::DynamicAABBTreeCollisionManager tree_;
  Candidates candidates_;
  std::vector<std::size_t> seen_at_;  // For each obstacle, where the link at hand has it in the result, if it is there.
  DistanceMeter meter_;
};

// A pair of links that was not measured.
struct Unmeasured {
  int pair = -1;       // Its number.
  double bound = 0.0;  // Its distance is not less, m.
};

// Finds which links are near each other: of all pairs that the robot has to check. Not to be shared between threads.
class LinkClearances {
 public:
  explicit LinkClearances(std::shared_ptr<const Robot> robot);

  // Finds every pair whose distance is not more than the horizon, in the robot's order.
  void within(double horizon, const Kinematics& kinematics, std::vector<Nearest>& found);
  // The same, but those that take long to measure are not measured, only listed, if they may be within the horizon.
  void glance(double horizon, const Kinematics& kinematics, std::vector<Nearest>& found,
              std::vector<Unmeasured>& unmeasured);
  // Measures a pair.
  [[nodiscard]] Nearest measure(int pair, const Kinematics& kinematics);
  // The boxes around the links, with a velocity (n).
  const LinkBoxes& moving_boxes(const Kinematics& kinematics, const Vector& velocity);

 private:
  void move_to(const Kinematics& kinematics);
  void find(double horizon, const Kinematics& kinematics, std::vector<Nearest>& found,
            std::vector<Unmeasured>* unmeasured);
  void measure(int link, int other, Nearest& nearest);

  std::shared_ptr<const Robot> robot_;
  LinkBoxes boxes_;
  std::vector<coal::Transform3s> placements_;
  DistanceMeter meter_;
};

}  // namespace humanoid_rail
