#include "swept_distance.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include <coal/narrowphase/support_functions.h>
#include <coal/shape/geometric_shapes.h>
#include <pinocchio/collision/coal-pinocchio-conversions.hpp>

#include "../interruption.hpp"

namespace humanoid_rail {

namespace {

// coal's depths of penetration are precise to this share of one, the depth and, of cylinders, their size, m.
constexpr double DEPTH_PRECISION = 5e-6;

// The size of what coal approximates by flat pieces where it looks for a depth, m.
double size_of_cylinder(const coal::CollisionGeometry& shape) {
  return shape.getNodeType() == coal::GEOM_CYLINDER ? shape.aabb_radius : 0.0;
}

// The largest coordinate of a shape along a direction of length 1.
double support(const coal::CollisionGeometry& geometry, const Eigen::Matrix3d& rotation,
               const Eigen::Vector3d& translation, const Eigen::Vector3d& direction) {
  const double middle = direction.dot(translation);
  const auto kind = geometry.getNodeType();
  if (kind == coal::GEOM_CAPSULE) {  // The paper's robot is made of these.
    const auto& capsule = static_cast<const coal::Capsule&>(geometry);
    return middle + std::abs(rotation.col(2).dot(direction)) * capsule.halfLength + capsule.radius;
  }
  if (kind == coal::GEOM_SPHERE) return middle + static_cast<const coal::Sphere&>(geometry).radius;
  const Eigen::Vector3d local = rotation.transpose() * direction;
  if (kind == coal::GEOM_BOX) {
    return middle + local.cwiseAbs().dot(static_cast<const coal::Box&>(geometry).halfSide);
  }
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
      if (!robot.moves(link) && !pieces[i].moves()) continue;
      pair.pair = link * static_cast<int>(pieces.size()) + static_cast<int>(i);
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

SweptDistance::SweptDistance(std::shared_ptr<const Robot> robot, std::vector<Obstacles::Piece> pieces, bool depths)
    : robot_(robot),
      pieces_(std::move(pieces)),
      kinematics_(robot),
      motion_bound_(*robot),
      meter_(depths),
      origins_{0} {
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
  edge_bounds(bounds);
}

// The same, of the changes and places that are set.
void SweptDistance::edge_bounds(EdgeBounds& bounds) {
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

Levers SweptDistance::levers(const Vector& slide) {
  const Eigen::Index n = robot_->n();
  Levers found{Matrix(robot_->links(), n), Matrix(static_cast<Eigen::Index>(origin_of_.size()), n)};
  EdgeBounds moved;
  slide_ = slide;
  for (Eigen::Index i = 0; i < n; ++i) {
    change_ = robot_->coupling.col(i);
    edge_bounds(moved);
    const auto lengths = [i](const std::vector<Displacement>& from, Matrix& to) {
      for (std::size_t k = 0; k < from.size(); ++k) to(static_cast<Eigen::Index>(k), i) = from[k].length;
    };
    lengths(moved.links, found.links);
    lengths(moved.pairs, found.pairs);
  }
  return found;
}

double SweptDistance::size(const Vector& slide, double time) const {
  double largest = motion_bound_.size(slide);
  for (const auto& piece : pieces_) {
    largest = std::max(largest, piece.placement.getTranslation().norm() + piece.size() + piece.velocity.norm() * time);
  }
  return largest;
}

double SweptDistance::measure(Nearest& pair, const Snapshot& at) {
  const auto link = body(at, pair.link);
  double proven = 0.0, size = 1.0;
  if (pair.is_with_obstacle()) {
    size += size_of_cylinder(*pieces_[static_cast<std::size_t>(pair.piece)].shape);
    measure_roughly(pair, link, link, at.t);
    if (pair.distance > -INFINITE) proven = separation_from(pair, normal_of(pair), link, at.t);
  } else {
    const auto other = body(at, pair.other);
    measure_roughly(pair, link, other, at.t);
    if (pair.distance > -INFINITE) proven = separation_of_links(pair, pair.normal, link, other);
  }
  if (pair.distance == -INFINITE) return pair.distance;
  // In penetration coal's depth is closer to the truth: its normal need not be the one along which that is smallest.
  const double depth = pair.distance - DEPTH_PRECISION * (size + std::abs(pair.distance));
  pair.distance = pair.distance < 0.0 ? std::max(proven, depth) : proven;
  if (!std::isfinite(pair.distance)) throw std::runtime_error("a distance that is not a number");
  return pair.distance;
}

void SweptDistance::measure_roughly(Nearest& pair, const Snapshot& at) {
  const auto link = body(at, pair.link);
  measure_roughly(pair, link, pair.is_with_obstacle() ? link : body(at, pair.other), at.t);
}

// The same with a link and the other link where they are; where there is no other link, its place does not matter.
void SweptDistance::measure_roughly(Nearest& pair, const pinocchio::SE3& link, const pinocchio::SE3& other, double t) {
  Interruption::poll();
  const auto shape = [&](int i) -> const coal::CollisionGeometry& {
    return *robot_->bodies.geometryObjects[static_cast<std::size_t>(i)].geometry;
  };
  if (pair.is_with_obstacle()) {
    const auto& piece = pieces_[static_cast<std::size_t>(pair.piece)];
    meter_.measure(shape(pair.link), pinocchio::toCoalTransform3s(link), *piece.shape, piece.at(t), pair);
  } else {
    meter_.measure(shape(pair.link), pinocchio::toCoalTransform3s(link), shape(pair.other),
                   pinocchio::toCoalTransform3s(other), pair);
  }
}

double SweptDistance::separation(const Nearest& pair, const Snapshot& at) const {
  return separation(pair, normal_of(pair), at);
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

// The smaller of the separations at a and b by planes with the normal of the pair's nearest points at a moment; for two
// links the normal is carried by the body that carries both.
double SweptDistance::gap(const Nearest& pair, const Snapshot& at, const Snapshot& a, const Snapshot& b) const {
  const Eigen::Vector3d normal = normal_of(pair);
  if (pair.is_with_obstacle()) return std::min(separation(pair, normal, a), separation(pair, normal, b));
  const auto origin = origins_[origin_of_[static_cast<std::size_t>(pair.pair)]];
  const Eigen::Vector3d carried = at.joints[origin].rotation().transpose() * normal;
  const auto separated = [&](const Snapshot& moment) {
    return separation(pair, moment.joints[origin].rotation() * carried, moment);
  };
  return std::min(separated(a), separated(b));
}

// The normal of a half-space is its own: it does not end in another direction.
Eigen::Vector3d SweptDistance::normal_of(const Nearest& pair) const {
  if (!pair.is_with_obstacle()) return pair.normal;
  const auto& piece = pieces_[static_cast<std::size_t>(pair.piece)];
  if (piece.shape->getNodeType() != coal::GEOM_HALFSPACE) return pair.normal;
  return -(piece.placement.getRotation() * static_cast<const coal::Halfspace&>(*piece.shape).n);
}

double SweptDistance::separation(const Nearest& pair, const Eigen::Vector3d& normal, const Snapshot& at) const {
  const auto link = body(at, pair.link);
  return pair.is_with_obstacle() ? separation_from(pair, normal, link, at.t)
                                 : separation_of_links(pair, normal, link, body(at, pair.other));
}

double SweptDistance::separation_from(const Nearest& pair, const Eigen::Vector3d& normal, const pinocchio::SE3& link,
                                      double t) const {
  const auto& piece = pieces_[static_cast<std::size_t>(pair.piece)];
  const auto& placement = piece.placement;
  const double obstacle =
      piece.shape->getNodeType() == coal::GEOM_HALFSPACE
          ? static_cast<const coal::Halfspace&>(*piece.shape).d - normal.dot(placement.getTranslation())
          : support(*piece.shape, placement.getRotation(), placement.getTranslation(), -normal);
  return -obstacle - coordinate(pair.link, link, normal) + t * normal.dot(piece.velocity);
}

double SweptDistance::separation_of_links(const Nearest& pair, const Eigen::Vector3d& normal,
                                          const pinocchio::SE3& link, const pinocchio::SE3& other) const {
  return -coordinate(pair.other, other, -normal) - coordinate(pair.link, link, normal);
}

// The largest coordinate of a link at a placement along a direction of length 1.
double SweptDistance::coordinate(int link, const pinocchio::SE3& placement, const Eigen::Vector3d& direction) const {
  const auto& shape = *robot_->bodies.geometryObjects[static_cast<std::size_t>(link)].geometry;
  return support(shape, placement.rotation(), placement.translation(), direction);
}

}  // namespace humanoid_rail
