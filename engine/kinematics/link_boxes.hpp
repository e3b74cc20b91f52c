// Boxes around the links of a robot: what they tell of distances costs a hundredth of measuring two meshes.
#pragma once

#include <memory>
#include <vector>

#include "kinematics.hpp"

namespace humanoid_rail {

// Holds its workspace. Not to be shared between threads.
class LinkBoxes {
 public:
  explicit LinkBoxes(std::shared_ptr<const Robot> robot);

  // Moves the boxes to where a robot is that was moved as a whole. Returns false where they were there already.
  bool move_to(const Kinematics& kinematics);
  // Gives them a velocity (n) there.
  void set_velocity(const Kinematics& kinematics, const Vector& velocity);

  // Whether balls around two links are farther apart than this, m.
  [[nodiscard]] bool are_apart(int link, int other, double distance) const {
    const Ball &a = ball(link), &b = ball(other);
    const double reach = distance + a.radius + b.radius;
    return (a.middle - b.middle).squaredNorm() > reach * reach;
  }
  // A lower bound of the distance of two links, from boxes around them, m. Only of pairs that take long to measure.
  [[nodiscard]] double distance(int link, int other) const;
  // An upper bound of how fast the distance of two links shrinks, m/s; negative if it is bound to grow. The same.
  [[nodiscard]] double approach(int link, int other) const;

 private:
  struct Ball {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // In the base frame.
    double radius = 0.0;                               // m
  };
  // Around the same middle.
  struct Box {
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    Eigen::Vector3d half = Eigen::Vector3d::Zero();  // Half of its sides, m.
  };
  [[nodiscard]] const Ball& ball(int link) const { return balls_[static_cast<std::size_t>(link)]; }
  [[nodiscard]] const Box& box(int link) const { return boxes_[static_cast<std::size_t>(link)]; }

  std::shared_ptr<const Robot> robot_;
  Vector q_, full_velocity_;
  std::vector<Ball> balls_;
  std::vector<Box> boxes_;
  bool turn_ = false;  // Whether there are pairs that take long to measure: only then it matters how boxes are turned.
  std::vector<pinocchio::Motion> motions_;  // Of the joints' bodies, at the base's origin.
};

}  // namespace humanoid_rail
