// Moves by the safe velocity, step by step. Beside humanoid_rail/rollout.py.
#pragma once

#include "certificate.hpp"
#include "integration.hpp"
#include "safety.hpp"

namespace humanoid_rail {

// A motion in steps of dt with a constant velocity each, and the contact that ended it, if one did.
struct Rollout {
  Integration motion;
  std::optional<Contact> overrun;
};

// Moves from a start (n) to the targets. Every step is proven free of contact before it is made.
Rollout rollout(SafeVelocity& method, const Obstacles& obstacles, const Vector& start, const Vector& targets,
                const Gains& gains, const Safety& safety, const Settings& settings);

}  // namespace humanoid_rail
