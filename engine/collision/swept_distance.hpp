// A lower bound of clearances while a robot moves straight from one configuration to another, along an edge.
// humanoid_rail/collision/swept_distance.py explains the two bounds.
#pragma once

#include <vector>

#include "../kinematics/clearance.hpp"
#include "motion_bound.hpp"

namespace humanoid_rail {

// A robot at a moment.
struct Snapshot {
  double t = 0.0;                      // s
  Vector q;                            // (n)
  std::vector<pinocchio::SE3> joints;  // Where they are.
};

// How far links get relative to the base, and the two of each pair of links relative to each other, on an edge.
struct EdgeBounds {
  std::vector<Displacement> links, pairs;

  [[nodiscard]] const Displacement& of(const Nearest& pair) const {
    return pair.is_with_obstacle() ? links[static_cast<std::size_t>(pair.link)]
                                   : pairs[static_cast<std::size_t>(pair.pair)];
  }
};

// How far the points of links get at most, relative to the base, and the two of each pair of links relative to each
// other, where a coordinate changes by 1: a column for each coordinate, m/rad or 1.
struct Levers {
  Matrix links, pairs;
};

// All pairs of a link and a piece of which one moves, link by link, and then all pairs of links that have to be
// checked. Not measured yet.
[[nodiscard]] std::vector<Nearest> all_pairs(const Robot& robot, const std::vector<Obstacles::Piece>& pieces);

class SweptDistance {
 public:
  // Without depths the distance in penetration is minus infinity, which costs a fraction.
  SweptDistance(std::shared_ptr<const Robot> robot, std::vector<Obstacles::Piece> pieces, bool depths = true);

  [[nodiscard]] const Robot& robot() const { return *robot_; }
  [[nodiscard]] const std::vector<Obstacles::Piece>& pieces() const { return pieces_; }
  // Puts a piece of an obstacle elsewhere, where it is at t = 0.
  void place(std::size_t piece, const coal::Transform3s& placement) { pieces_[piece].placement = placement; }

  // Where a collision body is.
  [[nodiscard]] pinocchio::SE3 body(const Snapshot& at, int link) const {
    const auto& geometry = robot_->bodies.geometryObjects[static_cast<std::size_t>(link)];
    return at.joints[geometry.parentJoint] * geometry.placement;
  }

  // Returns where the robot is at a configuration (n).
  [[nodiscard]] Snapshot snapshot(double t, const Eigen::Ref<const Vector>& q);
  // The same, into a snapshot that is used again.
  void snapshot(double t, const Eigen::Ref<const Vector>& q, Snapshot& at);
  // The same, from kinematics that are there already.
  static void snapshot(double t, const Kinematics& kinematics, Snapshot& at);

  // Sets how far the bodies get on the edge between two configurations (n).
  void edge_bounds(const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b, EdgeBounds& bounds);

  // The levers of all coordinates, where no joint is farther from 0 than `slide` (nv).
  [[nodiscard]] Levers levers(const Vector& slide);
  // What rounding is a share of, m: the largest coordinate of anything, where no joint is farther from 0 than `slide`
  // (nv) and no time farther from 0 than this, s.
  [[nodiscard]] double size(const Vector& slide, double time) const;

  // Measures a pair at a moment: sets distance, point and normal. The distance is that of two planes with the normal
  // between the two bodies, which is a lower bound whatever the normal. Throws std::runtime_error.
  double measure(Nearest& pair, const Snapshot& at);
  // Sets the same, with the distance as coal measures it.
  void measure_roughly(Nearest& pair, const Snapshot& at);
  // The distance of the planes, with the normal of a pair, that touch its bodies at a moment.
  [[nodiscard]] double separation(const Nearest& pair, const Snapshot& at) const;

  // A lower bound of the distance of a pair on the edge from a to b, at both of which it was measured. `moved` is how
  // far the two get relative to each other; nothing closer is looked for once the bound is as wanted.
  [[nodiscard]] double lower_bound(const Nearest& here, const Snapshot& a, const Nearest& there, const Snapshot& b,
                                   const Displacement& moved, double wanted) const;
  // How fast the obstacle of a pair moves, m/s.
  [[nodiscard]] double speed(const Nearest& pair) const;

 private:
  void edge_bounds(EdgeBounds& bounds);
  void measure_roughly(Nearest& pair, const pinocchio::SE3& link, const pinocchio::SE3& other, double t);
  [[nodiscard]] Eigen::Vector3d normal_of(const Nearest& pair) const;
  [[nodiscard]] double separation(const Nearest& pair, const Eigen::Vector3d& normal, const Snapshot& at) const;
  [[nodiscard]] double separation_from(const Nearest& pair, const Eigen::Vector3d& normal, const pinocchio::SE3& link,
                                       double t) const;
  [[nodiscard]] double separation_of_links(const Nearest& pair, const Eigen::Vector3d& normal,
                                           const pinocchio::SE3& link, const pinocchio::SE3& other) const;
  [[nodiscard]] double coordinate(int link, const pinocchio::SE3& placement, const Eigen::Vector3d& direction) const;
  [[nodiscard]] double gap(const Nearest& from, const Snapshot& at, const Snapshot& a, const Snapshot& b) const;

  std::shared_ptr<const Robot> robot_;
  std::vector<Obstacles::Piece> pieces_;
  Kinematics kinematics_;
  MotionBound motion_bound_;
  DistanceMeter meter_;
  std::vector<pinocchio::JointIndex> origins_;      // What pairs move relative to, each once, the base first.
  std::vector<std::size_t> origin_of_;              // For each pair of links its place in origins_.
  std::vector<std::vector<std::size_t>> pairs_of_;  // For each of origins_ its pairs.
  std::vector<Displacement> moved_;                 // Of every link, relative to the origin at hand.
  Vector full_a_, full_b_, change_, slide_;
};

}  // namespace humanoid_rail
