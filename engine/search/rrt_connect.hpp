// RRT-Connect (Kuffner and LaValle 2000): a tree that grows from the start and one from all goals, until they meet.
#pragma once

#include <functional>
#include <optional>

#include "../types.hpp"
#include "random.hpp"

namespace humanoid_rail {

// Whether a robot can go straight from one point to another.
using EdgeTest = std::function<bool(const Vector&, const Vector&)>;

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
                                 Random& random, const EdgeTest& is_free, const std::function<bool()>& is_over);

}  // namespace humanoid_rail
