// How far the points of links can get while the joints move at constant rates.
//
// Seen from the body of a joint further in, the origin of joint j is x_j = x_i + R_i c for the joint i before it, with
// a constant offset c. With the rates constant, |w_i| <= turn_i and |w_dot_i| <= twist_i,
//
//   |x_j'|  <= |x_i'|  + turn_i |c|
//   |x_j''| <= |x_i''| + (twist_i + turn_i^2) |c|
//
// and so on to the points of a link. Turns about parallel axes add up with their signs (a chest that stays level does
// not turn); the others at most in size: w = sum_r w_r a_r, where each axis a_r is carried by the turns before it, so
// that turn = sum_r |w_r| and twist = sum_r |w_r| sum_{s < r} |w_s|. A sliding joint, c + a q, adds |q'| and 2 turn
// |q'|.
//
// Bounds of this kind are those of conservative advancement (Mirtich 1996; Zhang, Lee and Kim 2006).
#pragma once

#include <vector>

#include "../model/robot.hpp"

namespace humanoid_rail {

// For every point of a link whose joints move at constant rates for a unit of time.
struct Displacement {
  double length = 0.0;     // The longest path of a point, m.
  double curvature = 0.0;  // The largest second derivative by that time, m.
};

// Bounds from the lengths of the links and the rates of the joints alone, valid in every configuration.
class MotionBound {
 public:
  explicit MotionBound(const Robot& robot);

  // Sets the displacement of every link that the body of a joint carries relative to that body, 0 for the base. The
  // others are left as they are. `change` (nv) is how far the joints move, `slide` (nv) the farthest that each is from
  // 0 meanwhile.
  void displacements(const Vector& change, const Vector& slide, pinocchio::JointIndex from,
                     std::vector<Displacement>& links);
  // The largest coordinate that a point of a link may have, m, times the turns that rounding is carried through.
  [[nodiscard]] double size(const Vector& slide) const;

 private:
  void list_carried();
  struct Joint {
    pinocchio::JointIndex parent = 0;
    Eigen::Index v = 0;
    bool slides = false;
    double offset = 0.0;    // From the parent's origin, at 0, m.
    double parallel = 0.0;  // 1 or -1 where the axis is parallel to that of the parent's turn, else 0.
  };
  // What is known of the body of a joint.
  struct Motion {
    double length = 0.0, curvature = 0.0;                     // Of its origin.
    double turn = 0.0, twist = 0.0;                           // Bounds of angular velocity and angular acceleration.
    double turn_before = 0.0, twist_before = 0.0, run = 0.0;  // The latest turns about parallel axes, and all before.
  };

  std::vector<Joint> joints_;
  std::vector<double> extent_;  // For each link, how far its points are from its joint's origin, m.
  double thickest_ = 0.0;       // The largest radius of a ball around a link, m.
  std::vector<pinocchio::JointIndex> joint_of_;
  // What the body of each joint carries, from it outwards.
  std::vector<std::vector<std::size_t>> joints_on_, links_on_;
  std::vector<Motion> motions_;
};

}  // namespace humanoid_rail
