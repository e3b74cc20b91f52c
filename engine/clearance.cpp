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

void Obstacles::add(std::shared_ptr<coal::CollisionGeometry> shape, const coal::Transform3s& placement) {
  pieces_.push_back({std::move(shape), placement, size_++});
}

void Obstacles::add_convex(const std::vector<Matrix>& pieces, const coal::Transform3s& placement) {
  for (const Matrix& vertices : pieces) {
    auto points = std::make_shared<std::vector<coal::Vec3s>>();
    for (Eigen::Index i = 0; i < vertices.rows(); ++i) points->emplace_back(vertices.row(i));
    const auto count = static_cast<unsigned int>(points->size());
    std::shared_ptr<coal::CollisionGeometry> hull(coal::ConvexBase::convexHull(points, count, true, "Qt"));
    pieces_.push_back({std::move(hull), placement, size_});
  }
  ++size_;
}

bool Clearances::Candidates::collide(coal::CollisionObject* piece, coal::CollisionObject*) {
  found.push_back(static_cast<const Obstacles::Piece*>(piece->getUserData()));
  return false;  // Go on.
}

Clearances::Clearances(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : robot_(std::move(robot)),
      pieces_(obstacles.pieces()),
      obstacles_(obstacles.size()),
      first_of_(static_cast<std::size_t>(obstacles_)),
      solver_(request_) {
  // The robot has its boxes already, and other threads may be reading them.
  for (const auto& body : robot_->bodies.geometryObjects) links_.emplace_back(body.geometry, false);
  boxed_.reserve(pieces_.size());
  for (Obstacles::Piece& piece : pieces_) {
    if (piece.shape->getNodeType() == coal::GEOM_HALFSPACE) {
      unbounded_.push_back(&piece);
    } else {
      boxed_.emplace_back(piece.shape, piece.placement);
      boxed_.back().setUserData(&piece);
    }
  }
  std::vector<coal::CollisionObject*> objects;
  for (auto& object : boxed_) objects.push_back(&object);
  tree_.registerObjects(objects);
  tree_.setup();
  candidates_.found.reserve(pieces_.size());
  nearest_.reserve(links_.size() * static_cast<std::size_t>(obstacles_));
}

const std::vector<Nearest>& Clearances::within(double horizon, const Kinematics& kinematics) {
  for (const Nearest& pair : nearest_) first_of_[static_cast<std::size_t>(pair.obstacle)] = 0;
  nearest_.clear();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const int link = static_cast<int>(i);
    const coal::Transform3s placement = pinocchio::toCoalTransform3s(kinematics.body(link));
    const std::size_t begin = nearest_.size();
    links_[i].setTransform(placement);
    links_[i].computeAABB();
    links_[i].getAABB().expand(horizon);
    candidates_.found.assign(unbounded_.begin(), unbounded_.end());
    tree_.collide(&links_[i], &candidates_);
    for (const Obstacles::Piece* piece : candidates_.found) measure(link, placement, *piece, horizon);
    for (std::size_t k = begin; k < nearest_.size(); ++k) {
      first_of_[static_cast<std::size_t>(nearest_[k].obstacle)] = 0;
    }
  }
  return nearest_;
}

const std::vector<Nearest>& Clearances::within_or_nearest(double horizon, const Kinematics& kinematics) {
  if (pieces_.empty() || !within(horizon, kinematics).empty()) return nearest_;
  for (double reach = std::max(horizon, FIRST_REACH); within(reach, kinematics).empty();) {
    if (std::isinf(reach)) throw std::runtime_error("a distance that is not a number");
    reach = reach < LAST_REACH ? 2.0 * reach : std::numeric_limits<double>::infinity();
  }
  const auto shorter = [](const Nearest& a, const Nearest& b) { return a.distance < b.distance; };
  const double shortest = std::min_element(nearest_.begin(), nearest_.end(), shorter)->distance;
  const auto longer = [&](const Nearest& pair) { return pair.distance > shortest; };
  nearest_.erase(std::remove_if(nearest_.begin(), nearest_.end(), longer), nearest_.end());
  return nearest_;
}

// Measures a link against a piece and keeps the result where it is the nearest piece of its obstacle so far.
void Clearances::measure(int link, const coal::Transform3s& placement, const Obstacles::Piece& piece, double horizon) {
  const auto* shape = robot_->bodies.geometryObjects[static_cast<std::size_t>(link)].geometry.get();
  coal::DistanceResult result;
  solver_.set(request_);
  const auto distance = distance_functions().distance_matrix[shape->getNodeType()][piece.shape->getNodeType()];
  distance(shape, placement, piece.shape.get(), piece.placement, &solver_, request_, result);
  if (!(result.min_distance <= horizon)) return;
  std::size_t& first = first_of_[static_cast<std::size_t>(piece.obstacle)];
  const Nearest nearest{link, piece.obstacle, result.min_distance, result.nearest_points[0], result.normal};
  if (first == 0) {
    nearest_.push_back(nearest);
    first = nearest_.size();
  } else if (nearest.distance < nearest_[first - 1].distance) {
    nearest_[first - 1] = nearest;
  }
}

}  // namespace humanoid_rail
