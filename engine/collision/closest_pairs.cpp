#include "closest_pairs.hpp"

#include <algorithm>

namespace humanoid_rail {

namespace {

// The closest pair remains so until another is closer by this, m: some links are always equally far from each other.
constexpr double TIE = 1e-5;

// Follows pairs of a kind. A pair is measured only when it could be the closest: its distance has shrunk by no more
// than how far the two have come since it was measured last.
class Follower {
 public:
  explicit Follower(std::vector<Nearest> pairs) : pairs_(std::move(pairs)), bounds_(pairs_.size(), -INFINITE) {}

  [[nodiscard]] bool is_empty() const { return pairs_.empty(); }

  void move(const SweptDistance& swept, const EdgeBounds& moved, double duration) {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      bounds_[i] -= moved.of(pairs_[i]).length + swept.speed(pairs_[i]) * duration;
    }
  }

  [[nodiscard]] Nearest closest(SweptDistance& swept, const Snapshot& at) {
    std::vector<char> measured(pairs_.size(), char{0});
    for (;;) {
      // The one with the least bound is the closest once its bound is what was measured.
      const auto i = static_cast<std::size_t>(std::min_element(bounds_.begin(), bounds_.end()) - bounds_.begin());
      if (measured[i]) {
        before_ = i;
        return pairs_[i];
      }
      bounds_[i] = swept.measure(pairs_[i], at) - (i == before_ ? TIE : 0.0);
      measured[i] = 1;
    }
  }

 private:
  std::vector<Nearest> pairs_;
  std::vector<double> bounds_;
  std::size_t before_ = static_cast<std::size_t>(-1);
};

}  // namespace

ClosestPairs closest_pairs(std::shared_ptr<const Robot> robot, const Obstacles& obstacles,
                           const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q) {
  SweptDistance swept(robot, obstacles.pieces());
  auto with_obstacle = all_pairs(*robot, obstacles.pieces());
  const auto is_first = [](const Nearest& pair) { return pair.is_with_obstacle(); };
  const auto middle = std::stable_partition(with_obstacle.begin(), with_obstacle.end(), is_first);
  Follower links(std::vector<Nearest>(middle, with_obstacle.end()));
  Follower others(std::vector<Nearest>(with_obstacle.begin(), middle));
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
