// A lower bound of clearances while a robot moves from one configuration straight to another. Beside
// humanoid_rail/sweep.py, which explains it.
#pragma once

#include <vector>

#include "clearance.hpp"
#include "travel.hpp"

namespace humanoid_rail {

// A robot at a moment.
struct Snapshot {
  double t;  // s
  Vector q;  // (n)
  std::vector<pinocchio::SE3> joints;  // Where they are.
};

// How far links get from the base, and the two of each pair of links from each other, on a straight way.
struct Ways {
  std::vector<Reach> links, pairs;

  const Reach& of(const Nearest& pair) const {
    return pair.piece >= 0 ? links[static_cast<std::size_t>(pair.link)] : pairs[static_cast<std::size_t>(pair.pair)];
  }
};

class Sweep {
 public:
  // The pieces of the obstacles have to outlive it.
  Sweep(std::shared_ptr<const Robot> robot, const std::vector<Obstacles::Piece>& pieces);

  // Where a collision body is.
  pinocchio::SE3 body(const Snapshot& at, int link) const {
    const auto& geometry = robot_->bodies.geometryObjects[static_cast<std::size_t>(link)];
    return at.joints[geometry.parentJoint] * geometry.placement;
  }

  // Keeps where the kinematics are.
  void take(double t, const Eigen::Ref<const Vector>& q, const Kinematics& kinematics, Snapshot& snapshot) const;

  // Sets the ways between two configurations of all joints (nq).
  void measure(const Vector& full_a, const Vector& full_b, Ways& ways);

  // A lower bound of the distance of a pair on the straight way from a to b, at both of which it was measured. `reach`
  // is how far the two get relative to each other; nothing closer is looked for once the bound is as wanted.
  double least(const Nearest& here, const Snapshot& a, const Nearest& there, const Snapshot& b, const Reach& reach,
               double wanted) const;

 private:
  double gap(const Nearest& from, const Snapshot& at, const Snapshot& a, const Snapshot& b) const;

  std::shared_ptr<const Robot> robot_;
  const std::vector<Obstacles::Piece>& pieces_;
  Travel travel_;
  std::vector<pinocchio::JointIndex> origins_;  // What pairs move relative to, each once, the base first.
  std::vector<std::size_t> origin_of_;          // For each pair of links its place in origins_.
  std::vector<std::vector<std::size_t>> pairs_of_;  // For each of origins_ its pairs.
  std::vector<Reach> reach_;                    // Of every link.
  Vector change_, slide_;
};

}  // namespace humanoid_rail
