#include "edge_checker.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

#include <coal/shape/geometric_shapes.h>

namespace humanoid_rail {

namespace {

// While links get farther than this on a part of the edge, only boxes around them are looked at, m.
constexpr double LONG = 0.3;
// Two bodies that get no farther than this relative to each other, and cannot be told to keep their distance, do not,
// m.
constexpr double SHORT = 1e-3;

}  // namespace

EdgeChecker::EdgeChecker(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance,
                         double own_share)
    : distance_(distance),
      own_share_(own_share),
      swept_(robot, obstacles.pieces(), false),
      pairs_(all_pairs(*robot, obstacles.pieces())),
      all_(pairs_.size()),
      boxes_(static_cast<std::size_t>(robot->links())) {
  std::iota(all_.begin(), all_.end(), 0);
  for (const auto& piece : swept_.pieces()) {
    if (piece.shape->getNodeType() == coal::GEOM_HALFSPACE) {
      piece_boxes_.push_back({Eigen::Vector3d::Constant(-INFINITE), Eigen::Vector3d::Constant(INFINITE)});
      continue;
    }
    const coal::AABB& own = piece.shape->aabb_local;
    const Eigen::Vector3d middle = piece.placement.transform(Eigen::Vector3d(own.center()));
    const Eigen::Vector3d half = piece.placement.getRotation().cwiseAbs() * (0.5 * (own.max_ - own.min_));
    piece_boxes_.push_back({middle - half, middle + half});
  }
}

bool EdgeChecker::is_valid(const Eigen::Ref<const Vector>& q) {
  if (!is_within_limits(q)) return false;
  const auto at = snapshot(q);
  for (int link = 0; link < robot().links(); ++link) {
    boxes_[static_cast<std::size_t>(link)] = box(*at, link).grown(distance_);
  }
  return std::all_of(all_.begin(), all_.end(), [&](int i) {
    Nearest pair = pairs_[static_cast<std::size_t>(i)];
    return boxes_are_apart(i) || swept_.measure(pair, *at) >= kept(pair);
  });
}

bool EdgeChecker::is_edge_valid(const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b) {
  // Most edges that are not valid are so at the end or in the middle.
  if (!is_within_limits(a) || !is_valid(b) || !is_valid(0.5 * (a + b))) return false;
  swept_.edge_bounds(a, b, bounds_);
  farthest_ = 0.0;
  for (const Displacement& moved : bounds_.links) farthest_ = std::max(farthest_, moved.length);
  parts_.clear();
  parts_.push_back({1.0, snapshot(a), snapshot(b), all_, {}});
  for (; !parts_.empty(); parts_.pop_front()) {
    Part& part = parts_.front();
    if (!keeps(part)) return false;
    if (part.pairs.empty() && part.measured.empty()) continue;
    if (!halve(part)) return false;
  }
  return true;
}

bool EdgeChecker::may_touch(const Candidate& pair, const Part& part) const {
  const Displacement& whole = bounds_.of(pair.here);
  const Displacement moved{part.length * whole.length, part.length * part.length * whole.curvature};
  const double distance = kept(pair.here);
  return swept_.lower_bound(pair.here, *part.from, pair.there, *part.to, moved, distance) < distance;
}

// Leaves of the pairs on a part of the edge those that it cannot tell to keep their distance. False if one does not.
bool EdgeChecker::keeps(Part& part) {
  if (part.pairs.empty()) {
    auto& pairs = part.measured;
    const auto are_apart = [&](const Candidate& pair) { return !may_touch(pair, part); };
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), are_apart), pairs.end());
  } else {
    grow_boxes(part);
    auto& pairs = part.pairs;
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [&](int i) { return boxes_are_apart(i); }), pairs.end());
    if (part.length * farthest_ > LONG) return true;
    if (!measure_ends(part)) return false;
  }
  return std::none_of(part.measured.begin(), part.measured.end(),
                      [&](const Candidate& pair) { return part.length * bounds_.of(pair.here).length <= SHORT; });
}

// Measures the pairs of a part at its ends, and keeps those that may touch. False if one does not keep its distance.
bool EdgeChecker::measure_ends(Part& part) {
  for (const int i : part.pairs) {
    const Nearest& pair = pairs_[static_cast<std::size_t>(i)];
    Candidate candidate{pair, pair};
    const double distance = kept(pair);
    if (swept_.measure(candidate.here, *part.from) < distance) return false;
    if (swept_.measure(candidate.there, *part.to) < distance) return false;
    if (may_touch(candidate, part)) part.measured.push_back(candidate);
  }
  part.pairs.clear();
  return true;
}

// Sets the boxes around all that the links sweep on a part of the edge.
void EdgeChecker::grow_boxes(const Part& part) {
  for (int link = 0; link < robot().links(); ++link) {
    const auto i = static_cast<std::size_t>(link);
    // Every point of a link is at most this far from the straight line between its ends.
    const double bend = part.length * part.length * bounds_.links[i].curvature / 8.0;
    const Box one = box(*part.from, link), two = box(*part.to, link);
    boxes_[i] = Box{one.low.cwiseMin(two.low), one.high.cwiseMax(two.high)}.grown(bend + distance_);
  }
}

// Adds both halves of a part. False if a pair does not keep its distance in the middle.
bool EdgeChecker::halve(const Part& part) {
  const auto middle = snapshot(0.5 * (part.from->q + part.to->q));
  Part first{0.5 * part.length, part.from, middle, part.pairs, part.measured};
  Part second{0.5 * part.length, middle, part.to, part.pairs, part.measured};
  for (std::size_t i = 0; i < part.measured.size(); ++i) {
    if (swept_.measure(first.measured[i].there, *middle) < kept(first.measured[i].there)) return false;
    second.measured[i].here = first.measured[i].there;
  }
  parts_.push_back(std::move(first));
  parts_.push_back(std::move(second));
  return true;
}

// The distance that a pair keeps, m.
double EdgeChecker::kept(const Nearest& pair) const {
  if (pair.is_with_obstacle()) return distance_;
  return robot().kept_distance(pair.pair, distance_, own_share_);
}

bool EdgeChecker::is_within_limits(const Eigen::Ref<const Vector>& q) const {
  const Limits& limits = robot().limits;
  return (q.array() >= limits.lower.array()).all() && (q.array() <= limits.upper.array()).all();
}

std::shared_ptr<const Snapshot> EdgeChecker::snapshot(const Eigen::Ref<const Vector>& q) {
  auto at = std::make_shared<Snapshot>();
  swept_.snapshot(0.0, q, *at);
  return at;
}

EdgeChecker::Box EdgeChecker::box(const Snapshot& at, int link) const {
  const auto& geometry = *robot().bodies.geometryObjects[static_cast<std::size_t>(link)].geometry;
  const auto body = swept_.body(at, link);
  const coal::AABB& own = geometry.aabb_local;
  const Eigen::Vector3d middle = body.act(Eigen::Vector3d(own.center()));
  Eigen::Vector3d half = body.rotation().cwiseAbs() * (0.5 * (own.max_ - own.min_));
  if (geometry.getNodeType() == coal::GEOM_CAPSULE) {
    const auto& capsule = static_cast<const coal::Capsule&>(geometry);
    half = (capsule.halfLength * body.rotation().col(2).cwiseAbs()).array() + capsule.radius;
  }
  return {middle - half, middle + half};
}

bool EdgeChecker::boxes_are_apart(int i) const {
  const Nearest& pair = pairs_[static_cast<std::size_t>(i)];
  const Box& other = pair.is_with_obstacle() ? piece_boxes_[static_cast<std::size_t>(pair.piece)]
                                             : boxes_[static_cast<std::size_t>(pair.other)];
  return boxes_[static_cast<std::size_t>(pair.link)].is_apart_from(other);
}

}  // namespace humanoid_rail
