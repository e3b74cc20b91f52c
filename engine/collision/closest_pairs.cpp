#include "closest_pairs.hpp"

#include <algorithm>
#include <functional>
#include <queue>

#include <coal/shape/geometric_shapes.h>

namespace humanoid_rail {

namespace {

// The closest pair remains so until another is closer by this, m: some links are always equally far from each other.
constexpr double TIE = 1e-5;

// Bounding spheres are taken to be closer to each other by this than they are computed to be, m.
constexpr double SPHERE_ROUNDING = 1e-9;

// A lower bound of the distance of a pair that nothing was measured of yet: that of their bounding spheres.
double sphere_bound(const Nearest& pair, const SweptDistance& swept, const Snapshot& at) {
  const auto& bodies = swept.robot().bodies.geometryObjects;
  const auto middle = [&](int link) -> Eigen::Vector3d {
    return swept.body(at, link).act(bodies[static_cast<std::size_t>(link)].geometry->aabb_center);
  };
  const auto radius = [&](int link) { return bodies[static_cast<std::size_t>(link)].geometry->aabb_radius; };
  if (!pair.is_with_obstacle()) {
    return (middle(pair.link) - middle(pair.other)).norm() - radius(pair.link) - radius(pair.other) - SPHERE_ROUNDING;
  }
  const auto& piece = swept.pieces()[static_cast<std::size_t>(pair.piece)];
  if (piece.shape->getNodeType() == coal::GEOM_HALFSPACE) return -INFINITE;  // It has no end.
  const Eigen::Vector3d other = piece.at(at.t).transform(piece.shape->aabb_center);
  return (middle(pair.link) - other).norm() - radius(pair.link) - piece.shape->aabb_radius - SPHERE_ROUNDING;
}

// Follows pairs of a kind. A pair is measured only when it could be the closest: its distance has shrunk by no more
// than how far the two have come since it was measured last.
class PairFollower {
 public:
  explicit PairFollower(std::vector<Nearest> pairs) : pairs_(std::move(pairs)) {}

  [[nodiscard]] bool is_empty() const { return pairs_.empty(); }

  void move(const SweptDistance& swept, const EdgeBounds& moved, double duration) {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      bounds_[i] -= moved.of(pairs_[i]).length + swept.speed(pairs_[i]) * duration;
    }
  }

  [[nodiscard]] Nearest closest(SweptDistance& swept, const Snapshot& at) {
    if (bounds_.empty()) {
      for (const Nearest& pair : pairs_) bounds_.push_back(sphere_bound(pair, swept, at));
    }
    std::vector<Bound> bounds;
    bounds.reserve(pairs_.size());
    for (std::size_t i = 0; i < pairs_.size(); ++i) bounds.emplace_back(bounds_[i], i);
    std::priority_queue queue(std::greater<Bound>{}, std::move(bounds));
    std::vector<char> measured(pairs_.size(), char{0});
    for (;;) {
      // The one with the least bound is the closest once its bound is what was measured.
      const std::size_t i = queue.top().second;
      if (measured[i]) {
        before_ = i;
        return pairs_[i];
      }
      queue.pop();
      bounds_[i] = swept.measure(pairs_[i], at) - (i == before_ ? TIE : 0.0);
      measured[i] = 1;
      queue.emplace(bounds_[i], i);
    }
  }

 private:
  using Bound = std::pair<double, std::size_t>;  // And the pair that has it.

  std::vector<Nearest> pairs_;
  std::vector<double> bounds_;  // Empty until the first moment.
  std::size_t before_ = static_cast<std::size_t>(-1);
};

}  // namespace

ClosestPairs closest_pairs(std::shared_ptr<const Robot> robot, const Obstacles& obstacles,
                           const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q) {
  SweptDistance swept(robot, obstacles.pieces());
  auto with_obstacle = all_pairs(*robot, obstacles.pieces());
  const auto is_first = [](const Nearest& pair) { return pair.is_with_obstacle(); };
  const auto middle = std::stable_partition(with_obstacle.begin(), with_obstacle.end(), is_first);
  PairFollower links(std::vector<Nearest>(middle, with_obstacle.end()));
  PairFollower others(std::vector<Nearest>(with_obstacle.begin(), middle));
  ClosestPairs found;
  EdgeBounds moved;
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    if (k > 0) {
      swept.edge_bounds(q.row(k - 1).transpose(), q.row(k).transpose(), moved);
      others.move(swept, moved, t[k] - t[k - 1]);
      links.move(swept, moved, 0.0);
    }
    const Snapshot at = swept.snapshot(t[k], q.row(k).transpose());
    if (!others.is_empty()) found.obstacles.push_back(others.closest(swept, at));
    if (!links.is_empty()) found.links.push_back(links.closest(swept, at));
  }
  return found;
}

}  // namespace humanoid_rail
