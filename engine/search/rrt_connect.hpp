// RRT-Connect (Kuffner and LaValle 2000): a tree that grows from the start and one from all goals, until they meet.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "../types.hpp"
#include "random.hpp"

namespace humanoid_rail {

// Whether a robot can go straight from one point to another.
using EdgeTest = std::function<bool(const Vector&, const Vector&)>;

// Goes from one point towards another, no farther than a length. Returns the points on the way after the first, none
// where the way is not free, and says whether the last one is the other.
using Steer = std::function<std::vector<Vector>(const Vector& from, const Vector& to, double longest, bool& arrived)>;

// Goes straight, by one edge.
[[nodiscard]] Steer straight(const EdgeTest& is_free);

// Where paths are looked for.
struct SearchBox {
  Vector lower, upper;  // (n)
};

struct Growth {
  std::optional<Rows> path;  // From the start to a goal (K, n), ...
  Eigen::Index goal = 0;     // ... which has this number.
  Rows from_start;           // The points of the start's tree.
};

// Looks for a path from a start (n) to one of some goals (K, n) until `is_over`. Distances are Euclidean; no edge is
// longer than `longest`.
[[nodiscard]] Growth rrt_connect(const Vector& start, const Rows& goals, const SearchBox& box, double longest,
                                 Random& random, const Steer& steer, const std::function<bool()>& is_over);

}  // namespace humanoid_rail
