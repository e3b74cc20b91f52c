#include "step_judge.hpp"

#include <algorithm>

#include "rollout.hpp"

namespace humanoid_rail {

namespace {

// Rounding may take this much from a distance in a step, m.
constexpr double DISTANCE_ROUNDING = 1e-9;

}  // namespace

StepJudge::StepJudge(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double safety_distance)
    : swept_(std::move(robot), obstacles.pieces()), safety_distance_(safety_distance) {
  for (const auto& piece : obstacles.pieces()) fastest_ = std::max(fastest_, piece.velocity.norm());
}

Step StepJudge::judge(const Place& a, const Place& b) {
  swept_.edge_bounds(a.snapshot.q, b.snapshot.q, bounds_);
  const bool is_compound = !b.seen.near.pieces.empty() || !a.seen.near.pieces.empty();
  const double drift = fastest_ * (b.snapshot.t - a.snapshot.t);
  const Kind obstacles{a.seen.near.by_piece(is_compound), b.seen.near.by_piece(is_compound), b.seen.obstacle_horizon,
                       bounds_.links, drift};
  const Kind links{a.seen.links, b.seen.links, b.seen.link_horizon, bounds_.pairs, 0.0};
  bool is_safe = true;
  if (!keeps_apart(obstacles, a, b, is_safe) || !keeps_apart(links, a, b, is_safe)) return Step::blocked;
  return is_safe ? Step::safe : Step::free;
}

bool StepJudge::keeps_apart(const Kind& kind, const Place& a, const Place& b, bool& is_safe) const {
  // What is within neither horizon stays apart if nothing gets so far.
  for (const Displacement& moved : kind.moved) {
    if (kind.horizon - (moved.length + kind.drift) / 2.0 < APART) return false;
  }
  auto i = kind.before.begin();
  for (const Nearest& there : kind.after) {
    while (i != kind.before.end() && i->pair < there.pair) ++i;
    const bool was_near = i != kind.before.end() && i->pair == there.pair;
    const double was = was_near ? i->distance : kind.horizon;
    Displacement moved = bounds_.of(there);
    moved.length += kind.drift;
    const double bound = was_near ? swept_.lower_bound(*i, a.snapshot, there, b.snapshot, moved, APART)
                                  : (was + there.distance - moved.length) / 2.0;
    if (bound < APART) return false;
    if (there.distance < std::min(safety_distance_, was) - DISTANCE_ROUNDING) is_safe = false;
  }
  // Those that have left the horizon.
  auto j = kind.after.begin();
  for (const Nearest& here : kind.before) {
    while (j != kind.after.end() && j->pair < here.pair) ++j;
    if (j != kind.after.end() && j->pair == here.pair) continue;
    if ((here.distance + kind.horizon - bounds_.of(here).length - kind.drift) / 2.0 < APART) return false;
  }
  return true;
}

}  // namespace humanoid_rail
