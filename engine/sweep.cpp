#include "sweep.hpp"

#include <algorithm>
#include <cmath>

#include <coal/narrowphase/support_functions.h>
#include <coal/shape/geometric_shapes.h>

namespace humanoid_rail {

namespace {

// The largest coordinate of a shape along a direction of length 1.
double support(const coal::CollisionGeometry& geometry, const Eigen::Matrix3d& rotation,
               const Eigen::Vector3d& translation, const Eigen::Vector3d& direction) {
  const double middle = direction.dot(translation);
  if (geometry.getNodeType() == coal::GEOM_CAPSULE) {  // What this robot is made of.
    const auto& capsule = static_cast<const coal::Capsule&>(geometry);
    return middle + std::abs(rotation.col(2).dot(direction)) * capsule.halfLength + capsule.radius;
  }
  const Eigen::Vector3d local = rotation.transpose() * direction;
  int hint = 0;
  const auto& shape = static_cast<const coal::ShapeBase&>(geometry);
  return middle + local.dot(coal::details::getSupport<coal::details::SupportOptions::WithSweptSphere>(&shape, local, hint));
}

}  // namespace

Sweep::Sweep(std::shared_ptr<const Robot> robot, const std::vector<Obstacles::Piece>& pieces)
    : robot_(std::move(robot)), pieces_(pieces), travel_(*robot_), origins_{0} {
  for (const auto& [link, other] : robot_->self_collision_pairs) {
    const auto origin = robot_->common_joint(link, other);
    auto place = std::find(origins_.begin(), origins_.end(), origin);
    if (place == origins_.end()) place = origins_.insert(place, origin);
    origin_of_.push_back(static_cast<std::size_t>(place - origins_.begin()));
  }
  pairs_of_.resize(origins_.size());
  for (std::size_t pair = 0; pair < origin_of_.size(); ++pair) pairs_of_[origin_of_[pair]].push_back(pair);
  reach_.resize(static_cast<std::size_t>(robot_->links()));
}

void Sweep::take(double t, const Eigen::Ref<const Vector>& q, const Kinematics& kinematics, Snapshot& snapshot) const {
  snapshot.t = t;
  snapshot.q = q;
  snapshot.joints = kinematics.joints();
}

void Sweep::measure(const Vector& full_a, const Vector& full_b, Ways& ways) {
  change_ = full_b - full_a;
  slide_ = full_a.cwiseAbs().cwiseMax(full_b.cwiseAbs());
  ways.links.resize(reach_.size());
  ways.pairs.resize(origin_of_.size());
  travel_.reach(change_, slide_, 0, ways.links);
  for (std::size_t origin = 0; origin < origins_.size(); ++origin) {
    if (pairs_of_[origin].empty()) continue;
    travel_.reach(change_, slide_, origins_[origin], reach_);
    for (const std::size_t pair : pairs_of_[origin]) {
      const auto& [link, other] = robot_->self_collision_pairs[pair];
      const Reach &one = reach_[static_cast<std::size_t>(link)], &two = reach_[static_cast<std::size_t>(other)];
      ways.pairs[pair] = {one.travel + two.travel, one.curvature + two.curvature};
    }
  }
}

double Sweep::least(const Nearest& here, const Snapshot& a, const Nearest& there, const Snapshot& b,
                    const Reach& reach, double wanted) const {
  // At any moment the distance has shrunk from either end by no more than the way from there.
  double bound = (here.distance + there.distance - reach.travel) / 2.0;
  // A plane between the two: each one's coordinate along its normal bends away from a straight line by no more than an
  // eighth of its second derivative.
  if (bound < wanted) bound = std::max(bound, gap(here, a, a, b) - reach.curvature / 8.0);
  if (bound < wanted) bound = std::max(bound, gap(there, b, a, b) - reach.curvature / 8.0);
  return bound;
}

// The smaller of the distances at a and b between the planes, with the normal of the pair's nearest points at a moment,
// that touch the one and the other; for two links in the body that carries both.
double Sweep::gap(const Nearest& pair, const Snapshot& at, const Snapshot& a, const Snapshot& b) const {
  const auto& bodies = robot_->bodies.geometryObjects;
  const auto link = static_cast<std::size_t>(pair.link);
  const auto& shape = *bodies[link].geometry;
  const auto coordinate = [&](const Snapshot& snapshot, const Eigen::Vector3d& direction) {
    const auto body = this->body(snapshot, pair.link);
    return support(shape, body.rotation(), body.translation(), direction);
  };
  if (pair.piece >= 0) {
    const auto& piece = pieces_[static_cast<std::size_t>(pair.piece)];
    const auto& rotation = piece.placement.getRotation();
    const auto* half_space = piece.shape->getNodeType() == coal::GEOM_HALFSPACE
                                 ? static_cast<const coal::Halfspace*>(piece.shape.get())
                                 : nullptr;
    const Eigen::Vector3d normal = half_space ? Eigen::Vector3d(-(rotation * half_space->n)) : pair.normal;
    const Eigen::Vector3d& center = piece.placement.getTranslation();
    const double obstacle = half_space ? half_space->d - normal.dot(center)
                                       : support(*piece.shape, rotation, center, -normal);
    const double speed = normal.dot(piece.velocity);
    return -obstacle + std::min(speed * a.t - coordinate(a, normal), speed * b.t - coordinate(b, normal));
  }
  const auto other = static_cast<std::size_t>(pair.other);
  const auto origin = origins_[origin_of_[static_cast<std::size_t>(pair.pair)]];
  const Eigen::Vector3d normal = at.joints[origin].rotation().transpose() * pair.normal;
  const auto apart = [&](const Snapshot& snapshot) {
    const Eigen::Vector3d direction = snapshot.joints[origin].rotation() * normal;
    const auto body = this->body(snapshot, pair.other);
    return -support(*bodies[other].geometry, body.rotation(), body.translation(), -direction) -
           coordinate(snapshot, direction);
  };
  return std::min(apart(a), apart(b));
}

}  // namespace humanoid_rail
