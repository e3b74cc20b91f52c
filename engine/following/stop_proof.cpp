#include "stop_proof.hpp"

#include <algorithm>
#include <tuple>

#include "../collision/margin.hpp"

namespace humanoid_rail {

namespace {

// A pair that is nearer than the safety distance may come nearer by this on an edge, though not at its end, m.
constexpr double DIP = 1e-4;
// Distances of such a pair are compared to this, m.
constexpr double DISTANCE_PRECISION = 1e-6;
// Two bodies that get no farther than this relative to each other, and cannot be told to keep apart, do not, m.
constexpr double SHORTEST_EDGE = 1e-4;
// coal's distances are precise to about 1e-6 (1 + distance), m. What is a thousand times that farther apart needs no
// proof.
constexpr double UNMEASURED_RESERVE = 1e-3;

}  // namespace

StopProof::StopProof(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance, Vector speeds,
                     double latency)
    : swept_(robot, obstacles.pieces(), false),
      obstacles_(obstacles),
      distance_(distance),
      speeds_(std::move(speeds)),
      fastest_(speeds_.size() > 0 ? speeds_.maxCoeff() : 0.0),
      latency_(latency),
      link_distances_(robot->self_collision_pairs.size()) {
  set_apart();
}

// What rounding may take from a distance, wherever the robot is.
void StopProof::set_apart() {
  const Robot& robot = swept_.robot();
  const Vector farthest = robot.limits.lower.cwiseAbs().cwiseMax(robot.limits.upper.cwiseAbs());
  const Vector slide = robot.offset.cwiseAbs() + Coupling(robot.coupling.cwiseAbs()) * farthest;
  apart_ = std::max(apart_, 2.0 * margin(swept_.size(slide, 0.0)));
}

void StopProof::place(int obstacle, const coal::Transform3s& placement) {
  const auto [first, end] = obstacles_.pieces_of(obstacle);
  for (std::size_t i = first; i < end; ++i) {
    const coal::Transform3s there = placement * swept_.pieces()[i].within;
    swept_.place(i, there);
    apart_ = std::max(apart_, 2.0 * margin(there.getTranslation().norm() + swept_.pieces()[i].size()));
  }
}

std::optional<Nearest> StopProof::unproven(SceneKinematics& scene, const Observation& seen, const Vector& to,
                                           double duration) {
  swept_.snapshot(0.0, seen.q, from_);
  swept_.snapshot(0.0, to, to_);
  swept_.edge_bounds(seen.q, to, bounds_);
  double length = 0.0;
  for (const Displacement& moved : bounds_.links) length = std::max(length, moved.length);
  // What is beyond this horizon keeps apart.
  const double widest = std::max(distance_, fastest_ * (latency_ + duration) + apart_);
  const double horizon = (length + widest + UNMEASURED_RESERVE) / (1.0 - UNMEASURED_RESERVE);
  const std::vector<Nearest>* pieces = &scene.pieces(seen);
  if (horizon > seen.obstacle_horizon && scene.obstacles().size() > 0) {
    scene.observe(seen.q, 0.0, horizon, -INFINITE, far_);
    pieces = &scene.pieces(far_);
  }
  for (const Nearest& pair : *pieces) {
    const Displacement& moved = bounds_.links[static_cast<std::size_t>(pair.link)];
    if (!keeps(pair, moved, drift(pair.other, duration))) return pair;
  }
  std::fill(link_distances_.begin(), link_distances_.end(), seen.link_horizon);
  for (const Nearest& pair : seen.links) link_distances_[static_cast<std::size_t>(pair.pair)] = pair.distance;
  for (const Unmeasured& pair : seen.unmeasured) link_distances_[static_cast<std::size_t>(pair.pair)] = pair.bound;
  Nearest pair;
  for (std::size_t i = 0; i < link_distances_.size(); ++i) {
    pair.pair = static_cast<int>(i);
    std::tie(pair.link, pair.other) = swept_.robot().self_collision_pairs[i];
    pair.distance = link_distances_[i];
    if (!keeps(pair, bounds_.pairs[i], 0.0)) {
      swept_.measure(pair, from_);
      return pair;
    }
  }
  return std::nullopt;
}

// Whether a pair, whose distance is not less at the beginning of the edge, keeps apart on it, although its obstacle may
// be elsewhere by `drift`, m. Bodies that do not move need no proof: what comes to them, a stop cannot help.
bool StopProof::keeps(Nearest pair, const Displacement& moved, double drift) {
  if (moved.length == 0.0) return true;
  const double kept = pair.is_with_obstacle() ? distance_ : swept_.robot().kept_distance(pair.pair, distance_);
  const double apart = drift + apart_;
  const double reserve = UNMEASURED_RESERVE * (1.0 + std::max(0.0, pair.distance));
  if (pair.distance - moved.length >= std::max(kept, apart) + reserve) return true;
  const double distance = swept_.measure(pair, from_);
  const double wanted = std::max(apart, distance >= kept ? kept : distance - DIP);
  if (distance < wanted) return false;
  Nearest there = pair;
  swept_.measure(there, to_);
  if (there.distance < std::min(kept, distance) - DISTANCE_PRECISION || there.distance < wanted) return false;
  return keeps_between(pair, from_, there, to_, moved, wanted, 0);
}

bool StopProof::keeps_between(const Nearest& here, const Snapshot& a, const Nearest& there, const Snapshot& b,
                              const Displacement& moved, double wanted, std::size_t halvings) {
  if (swept_.lower_bound(here, a, there, b, moved, wanted) >= wanted) return true;
  if (moved.length <= SHORTEST_EDGE || halvings == MAX_HALVINGS) return false;
  Snapshot& middle = middles_[halvings];
  middle_q_ = 0.5 * (a.q + b.q);
  swept_.snapshot(0.0, middle_q_, middle);
  Nearest between = here;
  if (swept_.measure(between, middle) < wanted) return false;
  const Displacement half{0.5 * moved.length, 0.25 * moved.curvature};
  return keeps_between(here, a, between, middle, half, wanted, halvings + 1) &&
         keeps_between(between, middle, there, b, half, wanted, halvings + 1);
}

}  // namespace humanoid_rail
