// Ways among the configurations in which constraints hold, by small steps that are each brought back onto them
// (Berenson, Srinivasa, Ferguson and Kuffner 2009).
#pragma once

#include <optional>
#include <vector>

#include "../kinematics/inverse_kinematics.hpp"
#include "rrt_connect.hpp"

namespace humanoid_rail {

// Points are configurations in the units in which the search measures them. Not to be shared between threads.
class Manifold {
 public:
  Manifold(const std::shared_ptr<const Robot>& robot, std::shared_ptr<const TaskStack> constraints,
           const Vector& units);

  // Goes from a point towards another by steps on the manifold, no farther than a length. Returns the points after the
  // first, up to where the way is not free or gets no nearer.
  [[nodiscard]] std::vector<Vector> walk(const Vector& from, const Vector& to, double longest, bool& arrived,
                                         const EdgeTest& is_free);
  // A path (K, n) with the same ends that is shorter, or as long: random pairs of its points are joined by walks.
  [[nodiscard]] Rows shortened(const Rows& path, Random& random, const EdgeTest& is_free,
                               const std::function<bool()>& is_over);

 private:
  [[nodiscard]] std::optional<Vector> projected(const Vector& point);

  InverseKinematics solver_;
  std::shared_ptr<const TaskStack> constraints_;
  Vector units_;
};

}  // namespace humanoid_rail
