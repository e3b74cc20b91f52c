// What rounding may take from a proven distance.
#pragma once

#include <limits>

namespace humanoid_rail {

// Two bodies that come nearer to each other touch, as far as anybody can tell, m.
constexpr double CONTACT = 1e-6;
// Rounding takes at most this share of the largest coordinate from the separation of two bodies; docs/safety.md says
// how that was found.
constexpr double RELATIVE_ROUNDING = 64.0 * std::numeric_limits<double>::epsilon();

// What is taken off a proven distance, m, where no coordinate is larger than `size`, m.
[[nodiscard]] constexpr double margin(double size) { return CONTACT + RELATIVE_ROUNDING * size; }

}  // namespace humanoid_rail
