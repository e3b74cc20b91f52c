#include "obstacles.hpp"

#include <algorithm>
#include <cmath>

#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

namespace humanoid_rail {

double Obstacles::Piece::size() const {
  if (shape->getNodeType() == coal::GEOM_HALFSPACE) return std::abs(static_cast<const coal::Halfspace&>(*shape).d);
  return shape->aabb_center.norm() + shape->aabb_radius;
}

void Obstacles::add(std::shared_ptr<coal::CollisionGeometry> shape, const coal::Transform3s& placement,
                    const Eigen::Vector3d& velocity) {
  add_piece(std::move(shape), placement, velocity);
  ++size_;
}

void Obstacles::add_convex(const std::vector<Matrix>& pieces, const coal::Transform3s& placement,
                           const Eigen::Vector3d& velocity) {
  for (const Matrix& vertices : pieces) {
    auto points = std::make_shared<std::vector<coal::Vec3s>>();
    for (Eigen::Index i = 0; i < vertices.rows(); ++i) points->emplace_back(vertices.row(i));
    const auto count = static_cast<unsigned int>(points->size());
    std::shared_ptr<coal::CollisionGeometry> hull(coal::ConvexBase::convexHull(points, count, true, "Qt"));
    add_piece(std::move(hull), placement, velocity);
  }
  ++size_;
}

void Obstacles::add_spheres(const Matrix& centers, const Vector& radii, const coal::Transform3s& placement,
                            const Eigen::Vector3d& velocity) {
  for (Eigen::Index i = 0; i < centers.rows(); ++i) {
    const Eigen::Vector3d center = centers.row(i);
    add_piece(std::make_shared<coal::Sphere>(radii[i]), placement, velocity, {Eigen::Matrix3d::Identity(), center});
  }
  ++size_;
}

// Bounding boxes are computed here, once: later several threads may read the same shapes.
void Obstacles::add_piece(std::shared_ptr<coal::CollisionGeometry> shape, const coal::Transform3s& placement,
                          const Eigen::Vector3d& velocity, const coal::Transform3s& within) {
  shape->computeLocalAABB();
  pieces_.push_back({std::move(shape), placement * within, velocity, size_, within});
}

void Obstacles::place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity) {
  const auto [first, end] = pieces_of(obstacle);
  for (std::size_t i = first; i < end; ++i) {
    pieces_[i].placement = placement * pieces_[i].within;
    pieces_[i].velocity = velocity;
  }
}

std::pair<std::size_t, std::size_t> Obstacles::pieces_of(int obstacle) const {
  const auto before = [](const Piece& piece, int number) { return piece.obstacle < number; };
  const auto first = std::lower_bound(pieces_.begin(), pieces_.end(), obstacle, before);
  const auto end = std::lower_bound(first, pieces_.end(), obstacle + 1, before);
  return {static_cast<std::size_t>(first - pieces_.begin()), static_cast<std::size_t>(end - pieces_.begin())};
}

bool Obstacles::move() const {
  return std::any_of(pieces_.begin(), pieces_.end(), [](const Piece& piece) { return piece.moves(); });
}

}  // namespace humanoid_rail
