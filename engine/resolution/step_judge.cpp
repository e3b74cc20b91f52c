#include "step_judge.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "../collision/margin.hpp"

namespace humanoid_rail {

namespace {

// Rounding may take this much from a distance in a step where coordinates are small, m.
constexpr double DISTANCE_ROUNDING = 1e-9;

// coal's distances are precise to about 1e-6 (1 + distance), m. Pairs that stay farther apart than a thousand times
// that need no proof.
constexpr double RESERVE = 1e-3;

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
  if (!keeps_apart(obstacles, a, b, is_safe) || !keeps_apart(links, a, b, is_safe) ||
      !keeps_unmeasured_apart(a, b, is_safe)) {
    return Step::blocked;
  }
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
    const double bound = (was + there.distance - moved.length) / 2.0;
    if (bound < APART + RESERVE * (1.0 + there.distance)) {
      if (!was_near && (kind.horizon + proven(there, b).distance - moved.length) / 2.0 < margin_of(a, b)) return false;
      if (was_near && !is_proven_apart(*i, a, there, b, moved)) return false;
    }
    if (there.distance < std::min(kept(there), was) - DISTANCE_ROUNDING) is_safe = false;
  }
  // Those that have left the horizon.
  auto j = kind.after.begin();
  for (const Nearest& here : kind.before) {
    while (j != kind.after.end() && j->pair < here.pair) ++j;
    if (j != kind.after.end() && j->pair == here.pair) continue;
    const double moved = bounds_.of(here).length + kind.drift;
    if ((here.distance + kind.horizon - moved) / 2.0 >= APART + RESERVE * (1.0 + here.distance)) continue;
    if ((proven(here, a).distance + kind.horizon - moved) / 2.0 < margin_of(a, b)) return false;
  }
  return true;
}

bool StepJudge::keeps_unmeasured_apart(const Place& a, const Place& b, bool& is_safe) {
  auto i = a.seen.unmeasured.begin(), j = b.seen.unmeasured.begin();
  const auto end_a = a.seen.unmeasured.end(), end_b = b.seen.unmeasured.end();
  while (i != end_a || j != end_b) {
    const int pair = i == end_a ? j->pair : j == end_b ? i->pair : std::min(i->pair, j->pair);
    // What is not listed is beyond the horizon.
    const double bound_a = i != end_a && i->pair == pair ? (i++)->bound : a.seen.link_horizon;
    const double bound_b = j != end_b && j->pair == pair ? (j++)->bound : b.seen.link_horizon;
    if (!keeps_pair_apart(pair, bound_a, bound_b, a, b, is_safe)) return false;
  }
  return true;
}

bool StepJudge::keeps_pair_apart(int pair, double bound_a, double bound_b, const Place& a, const Place& b,
                                 bool& is_safe) {
  const Displacement& moved = bounds_.pairs[static_cast<std::size_t>(pair)];
  const auto far = [&](double before, double after) {
    return (before + after - moved.length) / 2.0 >= APART + RESERVE * (1.0 + std::max(0.0, after));
  };
  Nearest here;
  here.pair = pair;
  std::tie(here.link, here.other) = swept_.robot().self_collision_pairs[static_cast<std::size_t>(pair)];
  if (far(bound_a, bound_b) && bound_b >= kept(here)) return true;
  Nearest there = here;
  swept_.measure_roughly(here, a.snapshot);
  swept_.measure_roughly(there, b.snapshot);
  if (there.distance < std::min(kept(there), here.distance) - DISTANCE_ROUNDING) is_safe = false;
  return far(here.distance, there.distance) || is_proven_apart(here, a, there, b, moved);
}

double StepJudge::kept(const Nearest& pair) const {
  return pair.is_with_obstacle() ? safety_distance_ : swept_.robot().kept_distance(pair.pair, safety_distance_);
}

bool StepJudge::is_proven_apart(const Nearest& here, const Place& a, const Nearest& there, const Place& b,
                                const Displacement& moved) const {
  const double apart = margin_of(a, b);
  return swept_.lower_bound(proven(here, a), a.snapshot, proven(there, b), b.snapshot, moved, apart) >= apart;
}

// A pair with the distance that is proven of it, where the one that was measured is larger.
Nearest StepJudge::proven(Nearest pair, const Place& at) const {
  pair.distance = std::min(pair.distance, swept_.separation(pair, at.snapshot));
  return pair;
}

// What a step keeps between all pairs, m.
double StepJudge::margin_of(const Place& a, const Place& b) const {
  const Robot& robot = swept_.robot();
  const auto slide = [&robot](const Place& at) { return robot.full_configuration(at.snapshot.q).cwiseAbs().eval(); };
  const double latest = std::max(std::abs(a.snapshot.t), std::abs(b.snapshot.t));
  return 2.0 * margin(swept_.size(slide(a).cwiseMax(slide(b)), latest));
}

}  // namespace humanoid_rail
