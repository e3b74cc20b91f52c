#include "validity.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <tuple>

#include <coal/shape/geometric_shapes.h>
#include <pinocchio/collision/coal-pinocchio-conversions.hpp>

namespace humanoid_rail {

namespace {

// While links get farther than this on a part of the way, only boxes around them are looked at, m.
constexpr double LONG = 0.3;
// Where two get no farther than this relative to each other and still cannot be told to keep their distance, they do
// not, m.
constexpr double SHORT = 1e-3;

}  // namespace

Validity::Validity(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance)
    : robot_(robot),
      pieces_(obstacles.pieces()),
      distance_(distance),
      kinematics_(robot),
      sweep_(robot, pieces_),
      boxes_(static_cast<std::size_t>(robot->links())) {
  Nearest pair{};
  for (int link = 0; link < robot->links(); ++link) {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      pair.pair = static_cast<int>(pairs_.size());
      pair.link = link;
      pair.piece = static_cast<int>(i);
      pair.other = pieces_[i].obstacle;
      pairs_.push_back(pair);
    }
  }
  for (std::size_t i = 0; i < robot->self_collision_pairs.size(); ++i) {
    pair.pair = static_cast<int>(i);
    std::tie(pair.link, pair.other) = robot->self_collision_pairs[i];
    pair.piece = -1;
    pairs_.push_back(pair);
  }
  all_.resize(pairs_.size());
  std::iota(all_.begin(), all_.end(), 0);
  for (const auto& piece : pieces_) {
    if (piece.shape->getNodeType() == coal::GEOM_HALFSPACE) {
      piece_boxes_.push_back({Eigen::Vector3d::Constant(-INFINITE), Eigen::Vector3d::Constant(INFINITE)});
      continue;
    }
    piece.shape->computeLocalAABB();
    const coal::AABB& own = piece.shape->aabb_local;
    const Eigen::Vector3d middle = piece.placement.transform(Eigen::Vector3d(own.center()));
    const Eigen::Vector3d half = piece.placement.getRotation().cwiseAbs() * (0.5 * (own.max_ - own.min_));
    piece_boxes_.push_back({middle - half, middle + half});
  }
}

bool Validity::holds_at(const Eigen::Ref<const Vector>& q) {
  if (!is_within_limits(q)) return false;
  const auto snapshot = look(q);
  for (int link = 0; link < robot_->links(); ++link) {
    boxes_[static_cast<std::size_t>(link)] = box(*snapshot, link).grown(distance_);
  }
  return std::all_of(all_.begin(), all_.end(), [&](int i) {
    Nearest pair = pairs_[static_cast<std::size_t>(i)];
    return boxes_are_apart(i) || measure(pair, *snapshot) >= distance_;
  });
}

bool Validity::holds_between(const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b) {
  // Most ways that fail do so at the end or in the middle.
  if (!is_within_limits(a) || !holds_at(b) || !holds_at(0.5 * (a + b))) return false;
  full_a_ = robot_->offset + robot_->coupling * a;
  full_b_ = robot_->offset + robot_->coupling * b;
  sweep_.measure(full_a_, full_b_, ways_);
  farthest_ = 0.0;
  for (const Reach& reach : ways_.links) farthest_ = std::max(farthest_, reach.travel);
  parts_.clear();
  parts_.push_back({1.0, look(a), look(b), all_, {}});
  for (; !parts_.empty(); parts_.pop_front()) {
    Part& part = parts_.front();
    if (!keeps(part)) return false;
    if (part.pairs.empty() && part.measured.empty()) continue;
    if (!halve(part)) return false;
  }
  return true;
}

// Leaves of the pairs on a part of the way those that it cannot tell to keep their distance. False if one does not.
bool Validity::keeps(Part& part) {
  const double length = part.length;
  const auto may_touch = [&](const Candidate& pair) {
    const Reach& whole = ways_.of(pair.here);
    const Reach reach{length * whole.travel, length * length * whole.curvature};
    return sweep_.least(pair.here, *part.from, pair.there, *part.to, reach, distance_) < distance_;
  };
  if (part.pairs.empty()) {
    auto& pairs = part.measured;
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), std::not_fn(may_touch)), pairs.end());
  } else {
    for (int link = 0; link < robot_->links(); ++link) {
      const auto i = static_cast<std::size_t>(link);
      // Every point of a link is as far from the straight line between its ends as this.
      const double bend = length * length * ways_.links[i].curvature / 8.0;
      const Box one = box(*part.from, link), two = box(*part.to, link);
      boxes_[i] = Box{one.low.cwiseMin(two.low), one.high.cwiseMax(two.high)}.grown(bend + distance_);
    }
    auto& pairs = part.pairs;
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [&](int i) { return boxes_are_apart(i); }), pairs.end());
    if (length * farthest_ > LONG) return true;
    for (const int i : pairs) {
      const Nearest& pair = pairs_[static_cast<std::size_t>(i)];
      Candidate candidate{pair, pair};
      if (measure(candidate.here, *part.from) < distance_ || measure(candidate.there, *part.to) < distance_) return false;
      if (may_touch(candidate)) part.measured.push_back(candidate);
    }
    pairs.clear();
  }
  return std::none_of(part.measured.begin(), part.measured.end(),
                      [&](const Candidate& pair) { return length * ways_.of(pair.here).travel <= SHORT; });
}

// Adds both halves of a part. False if a pair does not keep its distance in the middle.
bool Validity::halve(const Part& part) {
  const auto middle = look(0.5 * (part.from->q + part.to->q));
  Part first{0.5 * part.length, part.from, middle, part.pairs, part.measured};
  Part second{0.5 * part.length, middle, part.to, part.pairs, part.measured};
  for (std::size_t i = 0; i < part.measured.size(); ++i) {
    if (measure(first.measured[i].there, *middle) < distance_) return false;
    second.measured[i].here = first.measured[i].there;
  }
  parts_.push_back(std::move(first));
  parts_.push_back(std::move(second));
  return true;
}

bool Validity::is_within_limits(const Eigen::Ref<const Vector>& q) const {
  const Limits& limits = robot_->limits;
  return (q.array() >= limits.lower.array()).all() && (q.array() <= limits.upper.array()).all();
}

std::shared_ptr<const Snapshot> Validity::look(const Eigen::Ref<const Vector>& q) {
  auto snapshot = std::make_shared<Snapshot>();
  kinematics_.move_joints_to(q);
  sweep_.take(0.0, q, kinematics_, *snapshot);
  return snapshot;
}

Validity::Box Validity::box(const Snapshot& at, int link) const {
  const auto& geometry = *robot_->bodies.geometryObjects[static_cast<std::size_t>(link)].geometry;
  const auto body = sweep_.body(at, link);
  const coal::AABB& own = geometry.aabb_local;
  const Eigen::Vector3d middle = body.act(Eigen::Vector3d(own.center()));
  Eigen::Vector3d half = body.rotation().cwiseAbs() * (0.5 * (own.max_ - own.min_));
  if (geometry.getNodeType() == coal::GEOM_CAPSULE) {
    const auto& capsule = static_cast<const coal::Capsule&>(geometry);
    half = (capsule.halfLength * body.rotation().col(2).cwiseAbs()).array() + capsule.radius;
  }
  return {middle - half, middle + half};
}

bool Validity::boxes_are_apart(int i) const {
  const Nearest& pair = pairs_[static_cast<std::size_t>(i)];
  const Box& other = pair.piece >= 0 ? piece_boxes_[static_cast<std::size_t>(pair.piece)]
                                     : boxes_[static_cast<std::size_t>(pair.other)];
  return boxes_[static_cast<std::size_t>(pair.link)].is_apart_from(other);
}

double Validity::measure(Nearest& pair, const Snapshot& at) {
  const auto& bodies = robot_->bodies.geometryObjects;
  const auto shape = [&](int link) -> const coal::CollisionGeometry& {
    return *bodies[static_cast<std::size_t>(link)].geometry;
  };
  const auto placement = [&](int link) { return pinocchio::toCoalTransform3s(sweep_.body(at, link)); };
  if (pair.piece >= 0) {
    const auto& piece = pieces_[static_cast<std::size_t>(pair.piece)];
    meter_.measure(shape(pair.link), placement(pair.link), *piece.shape, piece.placement, pair);
  } else {
    meter_.measure(shape(pair.link), placement(pair.link), shape(pair.other), placement(pair.other), pair);
  }
  return pair.distance;
}

}  // namespace humanoid_rail
