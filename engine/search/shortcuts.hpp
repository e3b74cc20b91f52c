// Shorter paths by straight edges between their points.
#pragma once

#include "rrt_connect.hpp"

namespace humanoid_rail {

// Returns a path (K, n) with the same ends that is shorter, or as long. Random pairs of its points are joined by
// straight edges where these are free, points are left out, and corners are drawn in, as a rope would be.
[[nodiscard]] Rows shortened(const Rows& path, Random& random, const EdgeTest& is_free,
                             const std::function<bool()>& is_over);

}  // namespace humanoid_rail
