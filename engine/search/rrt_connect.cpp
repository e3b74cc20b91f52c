#include "rrt_connect.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace humanoid_rail {

namespace {

// Points that are nearer to each other than this are the same.
constexpr double SAME = 1e-9;

class Tree {
 public:
  explicit Tree(Eigen::Index n) : n_(n) {}

  int add(const Vector& point, int parent) {
    numbers_.insert(numbers_.end(), point.data(), point.data() + n_);
    parents_.push_back(parent);
    return static_cast<int>(parents_.size()) - 1;
  }
  [[nodiscard]] Eigen::Map<const Vector> point(int i) const { return {numbers_.data() + i * n_, n_}; }
  [[nodiscard]] int size() const { return static_cast<int>(parents_.size()); }

  [[nodiscard]] int nearest(const Vector& to) const {
    int found = 0;
    double least = INFINITE;
    for (int i = 0; i < size(); ++i) {
      const double squared = (point(i) - to).squaredNorm();
      if (squared < least) {
        least = squared;
        found = i;
      }
    }
    return found;
  }

  // The points from one to the root, and the number of that.
  [[nodiscard]] std::pair<std::vector<Vector>, int> to_root(int i) const {
    std::vector<Vector> points;
    int root = i;
    for (; i >= 0; i = parents_[static_cast<std::size_t>(i)]) {
      points.emplace_back(point(i));
      root = i;
    }
    return {points, root};
  }

 private:
  Eigen::Index n_;
  std::vector<double> numbers_;
  std::vector<int> parents_;
};

// Grows a tree from one of its points towards another. Returns the new point's number, or -1.
int extend(Tree& tree, int from, const Vector& to, double longest, const Steer& steer, bool& arrived) {
  const Vector here = tree.point(from);
  arrived = (to - here).norm() <= SAME;
  if (arrived) return from;
  const auto reached = steer(here, to, longest, arrived);
  for (const Vector& point : reached) from = tree.add(point, from);
  return reached.empty() ? -1 : from;
}

Rows joined(std::vector<Vector> from_start, const std::vector<Vector>& to_goal) {
  std::reverse(from_start.begin(), from_start.end());
  // Where the trees meet both have the point.
  from_start.insert(from_start.end(), to_goal.begin() + 1, to_goal.end());
  Rows path(static_cast<Eigen::Index>(from_start.size()), from_start.front().size());
  for (Eigen::Index i = 0; i < path.rows(); ++i) path.row(i) = from_start[static_cast<std::size_t>(i)].transpose();
  return path;
}

Vector somewhere(const SearchBox& box, Random& random) {
  Vector point(box.lower.size());
  for (Eigen::Index i = 0; i < point.size(); ++i) point[i] = random.between(box.lower[i], box.upper[i]);
  return point;
}

}  // namespace

Steer straight(const EdgeTest& is_free) {
  return [is_free](const Vector& from, const Vector& to, double longest, bool& arrived) {
    const double distance = (to - from).norm();
    arrived = distance <= longest;
    const Vector there = arrived ? to : Vector(from + longest / distance * (to - from));
    return is_free(from, there) ? std::vector<Vector>{there} : std::vector<Vector>{};
  };
}

Growth rrt_connect(const Vector& start, const Rows& goals, const SearchBox& box, double longest, Random& random,
                   const Steer& steer, const std::function<bool()>& is_over) {
  Tree from_start(start.size()), from_goals(start.size());
  from_start.add(start, -1);
  for (Eigen::Index i = 0; i < goals.rows(); ++i) from_goals.add(goals.row(i).transpose(), -1);
  Tree *growing = &from_start, *other = &from_goals;
  Growth found;
  while (!is_over() && !found.path) {
    bool arrived = false;
    const Vector sample = somewhere(box, random);
    const int there = extend(*growing, growing->nearest(sample), sample, longest, steer, arrived);
    if (there >= 0) {
      const Vector meeting = growing->point(there);
      int last = other->nearest(meeting);
      arrived = false;
      while (!arrived && last >= 0 && !is_over()) last = extend(*other, last, meeting, longest, steer, arrived);
      if (arrived && last >= 0) {
        const bool forwards = growing == &from_start;
        const auto [to_goal, goal] = from_goals.to_root(forwards ? last : there);
        found.path = joined(from_start.to_root(forwards ? there : last).first, to_goal);
        found.goal = goal;
      }
    }
    std::swap(growing, other);
  }
  found.from_start.resize(from_start.size(), start.size());
  for (int i = 0; i < from_start.size(); ++i) found.from_start.row(i) = from_start.point(i).transpose();
  return found;
}

}  // namespace humanoid_rail
