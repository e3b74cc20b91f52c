#include "swept_distance.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <coal/narrowphase/support_functions.h>
#include <coal/shape/geometric_shapes.h>
#include <pinocchio/collision/coal-pinocchio-conversions.hpp>

namespace humanoid_rail {

namespace {

// The largest coordinate of a shape along a direction of length 1.
double support(const coal::CollisionGeometry& geometry, const Eigen::Matrix3d& rotation,
               const Eigen::Vector3d& translation, const Eigen::Vector3d& direction) {
  const double middle = direction.dot(translation);
  if (geometry.getNodeType() == coal::GEOM_CAPSULE) {  // The paper's robot is made of these.
    const auto& capsule = static_cast<const coal::Capsule&>(geometry);
    return middle + std::abs(rotation.col(2).dot(direction)) * capsule.halfLength + capsule.radius;
  }
  const Eigen::Vector3d local = rotation.transpose() * direction;
  int hint = 0;
  const auto& shape = static_cast<const coal::ShapeBase&>(geometry);
  constexpr auto OPTIONS = coal::details::SupportOptions::WithSweptSphere;
  return middle + local.dot(coal::details::getSupport<OPTIONS>(&shape, local, hint));
}

}  // namespace

std::vector<Nearest> all_pairs(const Robot& robot, const std::vector<Obstacles::Piece>& pieces) {
  std::vector<Nearest> pairs;
  Nearest pair;
  for (int link = 0; link < robot.links(); ++link) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      pair.pair = static_cast<int>(pairs.size());
      pair.link = link;
      pair.piece = static_cast<int>(i);
      pair.other = pieces[i].obstacle;
      pairs.push_back(pair);
    }
  }
  for (std::size_t i = 0; i < robot.self_collision_pairs.size(); ++i) {
    pair.pair = static_cast<int>(i);
    std::tie(pair.link, pair.other) = robot.self_collision_pairs[i];
    pair.piece = -1;
    pairs.push_back(pair);
  }
  return pairs;
}

SweptDistance::SweptDistance(std::shared_ptr<const Robot> robot, std::vector<Obstacles::Piece> pieces)
    : robot_(robot), pieces_(std::move(pieces)), kinematics_(robot), motion_bound_(*robot), origins_{0} {
  for (const auto origin : robot_->common_joints()) {
    auto place = std::find(origins_.begin(), origins_.end(), origin);
    if (place == origins_.end()) place = origins_.insert(place, origin);
    origin_of_.push_back(static_cast<std::size_t>(place - origins_.begin()));
  }
  pairs_of_.resize(origins_.size());
  for (std::size_t pair = 0; pair < origin_of_.size(); ++pair) pairs_of_[origin_of_[pair]].push_back(pair);
  moved_.resize(static_cast<std::size_t>(robot_->links()));
}

Snapshot SweptDistance::snapshot(double t, const Eigen::Ref<const Vector>& q) {
  Snapshot at;
  snapshot(t, q, at);
  return at;
}

void SweptDistance::snapshot(double t, const Eigen::Ref<const Vector>& q, Snapshot& at) {
  kinematics_.move_joints_to(q);
  snapshot(t, kinematics_, at);
}

void SweptDistance::snapshot(double t, const Kinematics& kinematics, Snapshot& at) {
  at.t = t;
  at.q = kinematics.configuration();
  at.joints = kinematics.joints();
}

void SweptDistance::edge_bounds(const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b,
                                EdgeBounds& bounds) {
  full_a_ = robot_->offset;
  full_a_.noalias() += robot_->coupling * a;
  full_b_ = robot_->offset;
  full_b_.noalias() += robot_->coupling * b;
  change_ = full_b_ - full_a_;
  slide_ = full_a_.cwiseAbs().cwiseMax(full_b_.cwiseAbs());
  bounds.links.resize(moved_.size());
  bounds.pairs.resize(origin_of_.size());
  motion_bound_.displacements(change_, slide_, 0, bounds.links);
  for (std::size_t origin = 0; origin < origins_.size(); ++origin) {
    if (pairs_of_[origin].empty()) continue;
    motion_bound_.displacements(change_, slide_, origins_[origin], moved_);
    for (const std::size_t pair : pairs_of_[origin]) {
      const auto& [link, other] = robot_->self_collision_pairs[pair];
      const auto &one = moved_[static_cast<std::size_t>(link)], &two = moved_[static_cast<std::size_t>(other)];
      bounds.pairs[pair] = {one.length + two.length, one.curvature + two.curvature};
    }
  }
}

double SweptDistance::measure(Nearest& pair, const Snapshot& at) {
  const auto shape = [&](int link) -> const coal::CollisionGeometry& {
    return *robot_->bodies.geometryObjects[static_cast<std::size_t>(link)].geometry;
  };
  const auto placement = [&](int link) { return pinocchio::toCoalTransform3s(body(at, link)); };
  if (pair.is_with_obstacle()) {
    const auto& piece = pieces_[static_cast<std::size_t>(pair.piece)];
    meter_.measure(shape(pair.link), placement(pair.link), *piece.shape, piece.at(at.t), pair);
  } else {
    meter_.measure(shape(pair.link), placement(pair.link), shape(pair.other), placement(pair.other), pair);
  }
  return pair.distance;
}

double SweptDistance::speed(const Nearest& pair) const {
  return pair.is_with_obstacle() ? pieces_[static_cast<std::size_t>(pair.piece)].velocity.norm() : 0.0;
}

double SweptDistance::lower_bound(const Nearest& here, const Snapshot& a, const Nearest& there, const Snapshot& b,
                                  const Displacement& moved, double wanted) const {
  // At any moment the distance has shrunk from either end by no more than the path from there.
  double bound = (here.distance + there.distance - moved.length) / 2.0;
  // A plane between the two: each one's coordinate along its normal bends away from a straight line by no more than an
  // eighth of its second derivative.
  if (bound < wanted) bound = std::max(bound, gap(here, a, a, b) - moved.curvature / 8.0);
  if (bound < wanted) bound = std::max(bound, gap(there, b, a, b) - moved.curvature / 8.0);
  return bound;
}

// The smaller of the distances at a and b between the planes, with the normal of the pair's nearest points at a moment,
// that touch the one and the other; for two links in the body that carries both.
double SweptDistance::gap(const Nearest& pair, const Snapshot& at, const Snapshot& a, const Snapshot& b) const {
  const auto& bodies = robot_->bodies.geometryObjects;
  const auto link = static_cast<std::size_t>(pair.link);
  const auto& shape = *bodies[link].geometry;
  const auto coordinate = [&](const Snapshot& snapshot, const Eigen::Vector3d& direction) {
    const auto body = this->body(snapshot, pair.link);
    return support(shape, body.rotation(), body.translation(), direction);
  };
  if (pair.is_with_obstacle()) {
    const auto& piece = pieces_[static_cast<std::size_t>(pair.piece)];
    const auto& rotation = piece.placement.getRotation();
    const auto* half_space = piece.shape->getNodeType() == coal::GEOM_HALFSPACE
                                 ? static_cast<const coal::Halfspace*>(piece.shape.get())
                                 : nullptr;
    const Eigen::Vector3d normal = half_space ? Eigen::Vector3d(-(rotation * half_space->n)) : pair.normal;
    const Eigen::Vector3d& center = piece.placement.getTranslation();
    const double obstacle =
        half_space ? half_space->d - normal.dot(center) : support(*piece.shape, rotation, center, -normal);
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
