// How far the points of links can get while the joints move at constant rates. Beside humanoid_rail/travel.py.
#pragma once

#include <vector>

#include "robot.hpp"

namespace humanoid_rail {

// For every point of a link whose joints move at constant rates for a unit of time.
struct Reach {
  double travel;     // The longest way, m.
  double curvature;  // The largest second derivative by that time, m.
};

// Bounds from the lengths of the links and the rates of the joints alone, valid in every configuration.
class Travel {
 public:
  explicit Travel(const Robot& robot);

  // Sets the reach of every link that the body of a joint carries relative to that body, 0 for the base. The others are
  // left as they are. `change` (nv) is how far the joints move, `slide` (nv) the farthest that each is from 0 on the way.
  void reach(const Vector& change, const Vector& slide, pinocchio::JointIndex from, std::vector<Reach>& links) const;

 private:
  struct Joint {
    pinocchio::JointIndex parent;
    Eigen::Index v;
    bool slides;
    double offset;    // From the parent's origin, at 0, m.
    double parallel;  // 1 or -1 where the axis is parallel to that of the parent's turn, else 0.
  };
  // What is known of the body of a joint.
  struct Motion {
    double travel = 0.0, curvature = 0.0;  // Of its origin.
    double turn = 0.0, twist = 0.0;        // Bounds of angular velocity and angular acceleration.
    double turn_before = 0.0, twist_before = 0.0, run = 0.0;  // The latest turns about parallel axes, and all before.
  };

  std::vector<Joint> joints_;
  std::vector<double> extent_;  // For each link, how far its points are from its joint's origin, m.
  std::vector<pinocchio::JointIndex> joint_of_;
  // What the body of each joint carries, from it outwards.
  std::vector<std::vector<std::size_t>> joints_on_, links_on_;
  mutable std::vector<Motion> motions_;
};

}  // namespace humanoid_rail
