// The closest bodies at each moment of a motion.
#pragma once

#include "swept_distance.hpp"

namespace humanoid_rail {

// The closest pair of a kind at each moment, as measured there; empty where there are no such pairs.
struct ClosestPairs {
  std::vector<Nearest> obstacles, links;
};

// At times (K), in order, and configurations (K, n).
[[nodiscard]] ClosestPairs closest_pairs(std::shared_ptr<const Robot> robot, const Obstacles& obstacles,
                                         const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q);

}  // namespace humanoid_rail
