#include "clearance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <coal/shape/geometric_shapes.h>
#include <pinocchio/collision/coal-pinocchio-conversions.hpp>

namespace humanoid_rail {

namespace {

// How far to look for the nearest obstacle, first and, before everything, last, m.
constexpr double FIRST_REACH = 0.25;
constexpr double LAST_REACH = 1e3;

const coal::DistanceFunctionMatrix& distance_functions() {
  static const coal::DistanceFunctionMatrix functions;
  return functions;
}

}  // namespace

void Obstacles::add(std::shared_ptr<coal::CollisionGeometry> shape, const coal::Transform3s& placement,
                    const Eigen::Vector3d& velocity) {
  pieces_.push_back({std::move(shape), placement, velocity, size_++});
}

void Obstacles::add_convex(const std::vector<Matrix>& pieces, const coal::Transform3s& placement,
                           const Eigen::Vector3d& velocity) {
  for (const Matrix& vertices : pieces) {
    auto points = std::make_shared<std::vector<coal::Vec3s>>();
    for (Eigen::Index i = 0; i < vertices.rows(); ++i) points->emplace_back(vertices.row(i));
    const auto count = static_cast<unsigned int>(points->size());
    std::shared_ptr<coal::CollisionGeometry> hull(coal::ConvexBase::convexHull(points, count, true, "Qt"));
    pieces_.push_back({std::move(hull), placement, velocity, size_});
  }
  ++size_;
}

bool Obstacles::move() const {
  return std::any_of(pieces_.begin(), pieces_.end(), [](const Piece& piece) { return piece.moves(); });
}

void DistanceMeter::measure(const coal::CollisionGeometry& a, const coal::Transform3s& placement_a,
                            const coal::CollisionGeometry& b, const coal::Transform3s& placement_b, Nearest& nearest) {
  const auto kind_a = a.getNodeType(), kind_b = b.getNodeType();
  const auto is_round = [](coal::NODE_TYPE kind) { return kind == coal::GEOM_CAPSULE || kind == coal::GEOM_SPHERE; };
  // Between round shapes distances have closed forms.
  if (!is_round(kind_a) || !is_round(kind_b)) solver_.set(request_);
  result_.min_distance = std::numeric_limits<double>::max();
  distance_functions().distance_matrix[kind_a][kind_b](&a, placement_a, &b, placement_b, &solver_, request_, result_);
  nearest.distance = result_.min_distance;
  nearest.point = result_.nearest_points[0];
  nearest.normal = result_.normal;
}

bool Clearances::Candidates::collide(coal::CollisionObject* piece, coal::CollisionObject*) {
  found.push_back(static_cast<const Body*>(piece->getUserData()));
  return false;  // Go on.
}

Clearances::Clearances(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : robot_(std::move(robot)),
      pieces_(obstacles.pieces()),
      obstacles_(obstacles.size()),
      compound_(pieces_.size() != static_cast<std::size_t>(obstacles_)),
      first_of_(static_cast<std::size_t>(obstacles_)) {
  // The robot has its boxes already, and other threads may be reading them.
  for (const auto& body : robot_->bodies.geometryObjects) links_.emplace_back(body.geometry, false);
  boxed_.reserve(pieces_.size());
  bodies_.reserve(pieces_.size());
  for (const Obstacles::Piece& piece : pieces_) {
    bodies_.push_back({&piece, static_cast<int>(bodies_.size()), piece.placement});
    Body& body = bodies_.back();
    coal::CollisionObject* object = nullptr;
    if (piece.shape->getNodeType() == coal::GEOM_HALFSPACE) {
      unbounded_.push_back(&body);
    } else {
      boxed_.emplace_back(piece.shape, piece.placement);
      object = &boxed_.back();
      object->setUserData(&body);
    }
    if (piece.moves()) moving_.emplace_back(&body, object);
  }
  std::vector<coal::CollisionObject*> objects;
  for (auto& object : boxed_) objects.push_back(&object);
  tree_.registerObjects(objects);
  tree_.setup();
  candidates_.found.reserve(pieces_.size());
  nearest_.reserve(links_.size() * static_cast<std::size_t>(obstacles_));
  if (compound_) nearest_pieces_.reserve(links_.size() * pieces_.size());
}

void Clearances::move_to(double t) {
  if (t == t_) return;
  t_ = t;
  for (auto& [body, object] : moving_) {
    body->placement = body->piece->at(t);
    if (object == nullptr) continue;
    object->setTransform(body->placement);
    object->computeAABB();
    tree_.update(object);
  }
}

const std::vector<Nearest>& Clearances::within(double horizon, const Kinematics& kinematics) {
  for (const Nearest& pair : nearest_) first_of_[static_cast<std::size_t>(pair.other)] = 0;
  nearest_.clear();
  nearest_pieces_.clear();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const int link = static_cast<int>(i);
    const coal::Transform3s placement = pinocchio::toCoalTransform3s(kinematics.body(link));
    const std::size_t begin = nearest_.size();
    links_[i].setTransform(placement);
    links_[i].computeAABB();
    links_[i].getAABB().expand(horizon);
    candidates_.found.assign(unbounded_.begin(), unbounded_.end());
    tree_.collide(&links_[i], &candidates_);
    for (const Body* body : candidates_.found) measure(link, placement, *body, horizon);
    for (std::size_t k = begin; k < nearest_.size(); ++k) first_of_[static_cast<std::size_t>(nearest_[k].other)] = 0;
  }
  return nearest_;
}

const std::vector<Nearest>& Clearances::within_or_nearest(double horizon, const Kinematics& kinematics) {
  if (pieces_.empty() || !within(horizon, kinematics).empty()) return nearest_;
  for (double reach = std::max(horizon, FIRST_REACH); within(reach, kinematics).empty();) {
    if (std::isinf(reach)) throw std::runtime_error("a distance that is not a number");
    reach = reach < LAST_REACH ? 2.0 * reach : INFINITE;
  }
  const auto shorter = [](const Nearest& a, const Nearest& b) { return a.distance < b.distance; };
  const double shortest = std::min_element(nearest_.begin(), nearest_.end(), shorter)->distance;
  const auto longer = [&](const Nearest& pair) { return pair.distance > shortest; };
  for (auto* pairs : {&nearest_, &nearest_pieces_}) {
    pairs->erase(std::remove_if(pairs->begin(), pairs->end(), longer), pairs->end());
  }
  return nearest_;
}

// Measures a link against a piece and keeps the result where it is the nearest piece of its obstacle so far.
void Clearances::measure(int link, const coal::Transform3s& placement, const Body& body, double horizon) {
  const Obstacles::Piece& piece = *body.piece;
  Nearest nearest;
  const auto& shape = *robot_->bodies.geometryObjects[static_cast<std::size_t>(link)].geometry;
  meter_.measure(shape, placement, *piece.shape, body.placement, nearest);
  if (!(nearest.distance <= horizon)) return;
  nearest.pair = link * static_cast<int>(pieces_.size()) + body.index;
  nearest.link = link;
  nearest.other = piece.obstacle;
  nearest.piece = body.index;
  nearest.rate = nearest.normal.dot(piece.velocity);
  if (compound_) nearest_pieces_.push_back(nearest);
  std::size_t& first = first_of_[static_cast<std::size_t>(piece.obstacle)];
  if (first == 0) {
    nearest_.push_back(nearest);
    first = nearest_.size();
  } else if (nearest.distance < nearest_[first - 1].distance) {
    nearest_[first - 1] = nearest;
  }
}

SelfClearances::SelfClearances(std::shared_ptr<const Robot> robot)
    : robot_(std::move(robot)),
      placements_(static_cast<std::size_t>(robot_->links())),
      middles_(static_cast<std::size_t>(robot_->links())) {
  nearest_.reserve(robot_->self_collision_pairs.size());
}

const std::vector<Nearest>& SelfClearances::within(double horizon, const Kinematics& kinematics) {
  nearest_.clear();
  const auto& bodies = robot_->bodies.geometryObjects;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    placements_[i] = pinocchio::toCoalTransform3s(kinematics.body(static_cast<int>(i)));
    middles_[i] = placements_[i].transform(bodies[i].geometry->aabb_center);
  }
  int pair = -1;
  for (const auto& [link, other] : robot_->self_collision_pairs) {
    ++pair;
    const auto a = static_cast<std::size_t>(link), b = static_cast<std::size_t>(other);
    const auto &shape_a = *bodies[a].geometry, &shape_b = *bodies[b].geometry;
    const double reach = horizon + shape_a.aabb_radius + shape_b.aabb_radius;
    if ((middles_[a] - middles_[b]).squaredNorm() > reach * reach) continue;
    Nearest nearest;
    meter_.measure(shape_a, placements_[a], shape_b, placements_[b], nearest);
    if (!(nearest.distance <= horizon)) continue;
    nearest.pair = pair;
    nearest.link = link;
    nearest.other = other;
    nearest.piece = -1;
    nearest.rate = 0.0;
    nearest_.push_back(nearest);
  }
  return nearest_;
}

}  // namespace humanoid_rail
