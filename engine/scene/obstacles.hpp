// The obstacles of a scene, each made of one convex piece or more, at rest or moving at a constant velocity.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <coal/collision_object.h>

#include "../types.hpp"

namespace humanoid_rail {

class Obstacles {
 public:
  struct Piece {
    std::shared_ptr<coal::CollisionGeometry> shape;
    coal::Transform3s placement;                         // At t = 0.
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
    int obstacle = 0;
    coal::Transform3s within;  // Where it is in its obstacle: what is placed is the obstacle, and so is its placement.

    [[nodiscard]] coal::Transform3s at(double t) const {
      return {placement.getRotation(), placement.getTranslation() + t * velocity};
    }
    // Its points are no farther from its origin, m. For a half-space, which has no farthest point and never turns, this
    // is the distance of its plane.
    [[nodiscard]] double size() const;
    [[nodiscard]] bool moves() const { return !velocity.isZero(0.0); }
  };

  // Adds an obstacle of one piece.
  void add(std::shared_ptr<coal::CollisionGeometry> shape, const coal::Transform3s& placement,
           const Eigen::Vector3d& velocity);
  // Adds an obstacle of convex pieces, each the hull of points (k, 3).
  void add_convex(const std::vector<Matrix>& pieces, const coal::Transform3s& placement,
                  const Eigen::Vector3d& velocity);

  // Adds an obstacle of spheres, with their centres (k, 3) in its frame and their radii (k), m.
  void add_spheres(const Matrix& centers, const Vector& radii, const coal::Transform3s& placement,
                   const Eigen::Vector3d& velocity);

  // Puts an obstacle elsewhere, with another velocity.
  void place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity);

  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }
  // The first piece of an obstacle, and the one after its last.
  [[nodiscard]] std::pair<std::size_t, std::size_t> pieces_of(int obstacle) const;
  [[nodiscard]] int size() const { return size_; }
  // Whether an obstacle has more than one piece.
  [[nodiscard]] bool is_compound() const { return pieces_.size() != static_cast<std::size_t>(size_); }
  // Whether any of them moves.
  [[nodiscard]] bool move() const;

 private:
  void add_piece(std::shared_ptr<coal::CollisionGeometry> shape, const coal::Transform3s& placement,
                 const Eigen::Vector3d& velocity, const coal::Transform3s& within = coal::Transform3s());

  std::vector<Piece> pieces_;
  int size_ = 0;
};

}  // namespace humanoid_rail
