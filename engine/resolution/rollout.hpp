// Follows the safe velocity step by step; each step is proven free of contact before it is made.
#pragma once

#include <optional>

#include "../collision/certifier.hpp"
#include "integrate.hpp"
#include "qp.hpp"

namespace humanoid_rail {

// A step keeps twice the margin of a proof between all pairs; this where coordinates are small, m.
constexpr double APART = 2.0 * CONTACT;
// |e| has to fall by this share for a motion to have made progress.
constexpr double PROGRESS = 0.01;

// A motion in steps of dt with a constant velocity each, and the contact that ended it, if one did.
struct RolloutResult {
  Integration motion;
  std::optional<Contact> overrun;
};

// Moves from a start (n) until the tasks are done, or nothing more can come of it.
[[nodiscard]] RolloutResult rollout(SafeVelocity& method, const Vector& start, const TaskStack& tasks,
                                    const Gains& gains, const Safety& safety, const Settings& settings);

}  // namespace humanoid_rail
