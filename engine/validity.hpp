// Whether a robot keeps its distance from everything, at a configuration or all the way between two. Beside
// humanoid_rail/validity.py, which explains it.
#pragma once

#include <deque>

#include "sweep.hpp"

namespace humanoid_rail {

// A robot among obstacles where they are at t = 0, with the workspace that takes. Not to be shared between threads.
class Validity {
 public:
  // The distance that links keep from obstacles and from each other is in m.
  Validity(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance);
  Validity(const Validity&) = delete;  // The sweep refers to the pieces here.
  Validity& operator=(const Validity&) = delete;

  // Whether a configuration (n) is within the limits and every pair keeps its distance there.
  bool holds_at(const Eigen::Ref<const Vector>& q);
  // Whether that is proven of the straight way between two configurations (n).
  bool holds_between(const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b);
  const Robot& robot() const { return *robot_; }

 private:
  struct Box {
    Eigen::Vector3d low, high;

    bool is_apart_from(const Box& other) const {
      return (low.array() > other.high.array()).any() || (high.array() < other.low.array()).any();
    }
    Box grown(double by) const { return {low.array() - by, high.array() + by}; }
  };
  // A pair that may come too near on a part of the way, as measured at its ends.
  struct Candidate {
    Nearest here, there;
  };
  // A part of the way.
  struct Part {
    double length;  // Of the whole way 1.
    std::shared_ptr<const Snapshot> from, to;
    std::vector<int> pairs;        // Those that are looked at, before they are measured ...
    std::vector<Candidate> measured;  // ... and after.
  };

  bool is_within_limits(const Eigen::Ref<const Vector>& q) const;
  std::shared_ptr<const Snapshot> look(const Eigen::Ref<const Vector>& q);
  Box box(const Snapshot& at, int link) const;
  bool boxes_are_apart(int pair) const;
  double measure(Nearest& pair, const Snapshot& at);
  bool keeps(Part& part);
  bool halve(const Part& part);

  std::shared_ptr<const Robot> robot_;
  std::vector<Obstacles::Piece> pieces_;
  double distance_;
  Kinematics kinematics_;
  Sweep sweep_;
  DistanceMeter meter_;
  std::vector<Nearest> pairs_;    // All of them.
  std::vector<int> all_;          // Their places.
  std::vector<Box> piece_boxes_;
  std::vector<Box> boxes_;        // Of the links: all that they sweep, and the distance around it.
  Vector full_a_, full_b_;
  Ways ways_;                     // From one end to the other.
  double farthest_ = 0.0;         // Of all links.
  std::deque<Part> parts_;        // Still to be looked at, the longer ones first.
};

}  // namespace humanoid_rail
