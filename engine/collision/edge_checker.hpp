// Whether a robot keeps its distance from everything, at a configuration or on the edge between two. An edge is not
// sampled but proven: it is halved until the bounds of swept distances show of every pair that it keeps its distance.
#pragma once

#include <deque>

#include "swept_distance.hpp"

namespace humanoid_rail {

// A robot among obstacles where they are at t = 0. Holds its workspace. Not to be shared between threads.
class EdgeChecker {
 public:
  // The distance that links keep from obstacles and from each other is in m. Pairs of links with a smaller one of their
  // own keep at least this share of that.
  EdgeChecker(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance, double own_share);

  // Whether a configuration (n) is within the limits and every pair keeps its distance there.
  [[nodiscard]] bool is_valid(const Eigen::Ref<const Vector>& q);
  // Whether that is proven of the edge between two configurations (n).
  [[nodiscard]] bool is_edge_valid(const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b);
  [[nodiscard]] const Robot& robot() const { return swept_.robot(); }

 private:
  struct Box {
    Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();

    [[nodiscard]] bool is_apart_from(const Box& other) const {
      return (low.array() > other.high.array()).any() || (high.array() < other.low.array()).any();
    }
    [[nodiscard]] Box grown(double by) const { return {low.array() - by, high.array() + by}; }
  };
  // A pair that may come too near on a part of the edge, as measured at its ends.
  struct Candidate {
    Nearest here, there;
  };
  // A part of the edge.
  struct Part {
    double length = 1.0;  // Of the whole edge 1.
    std::shared_ptr<const Snapshot> from, to;
    std::vector<int> pairs;           // Those that are looked at, before they are measured ...
    std::vector<Candidate> measured;  // ... and after.
  };

  [[nodiscard]] double kept(const Nearest& pair) const;
  [[nodiscard]] bool is_within_limits(const Eigen::Ref<const Vector>& q) const;
  [[nodiscard]] std::shared_ptr<const Snapshot> snapshot(const Eigen::Ref<const Vector>& q);
  [[nodiscard]] Box box(const Snapshot& at, int link) const;
  void grow_boxes(const Part& part);
  [[nodiscard]] bool boxes_are_apart(int pair) const;
  [[nodiscard]] bool keeps(Part& part);
  [[nodiscard]] bool measure_ends(Part& part);
  [[nodiscard]] bool halve(const Part& part);
  [[nodiscard]] bool may_touch(const Candidate& pair, const Part& part) const;

  double distance_, own_share_;
  SweptDistance swept_;
  std::vector<Nearest> pairs_;  // All of them.
  std::vector<int> all_;        // Their places.
  std::vector<Box> piece_boxes_;
  std::vector<Box> boxes_;  // Of the links: all that they sweep, and the distance around it.
  EdgeBounds bounds_;       // From one end to the other.
  double farthest_ = 0.0;   // How far any link gets.
  std::deque<Part> parts_;  // Still to be looked at, the longer ones first.
};

}  // namespace humanoid_rail
