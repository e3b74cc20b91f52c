// The pseudo-inverse and the null-space projector of eq. 4.6 and 4.7, without forming them.
#pragma once

#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/SVD>

#include "../types.hpp"

namespace humanoid_rail {

// The damping lambda: 0 except next to a singularity, where the smallest singular value is below `threshold` (Nakamura
// and Hanafusa 1986).
[[nodiscard]] double damping(double smallest_singular_value, double threshold);

// J# = J^T (J J^T + lambda^2 I)^-1 and I - J# J of one J (m, n).
class PseudoInverse {
 public:
  // Singular values below `threshold` are damped.
  void decompose(const Matrix& J, double threshold);
  // Sets velocity to -J# Ke + (I - J# J) secondary, eq. 4.6 and 4.7. J is that of decompose.
  void redundant_velocity(const Matrix& J, const Vector& Ke, const Vector& secondary, Vector& velocity);
  // The unit vector (m) along which the hands can hardly move; none away from singularities.
  [[nodiscard]] std::optional<Vector> lost_direction() const;

 private:
  void resize(Eigen::Index rows, Eigen::Index columns);

  bool regular_ = true;
  double threshold_ = 0.0;
  Eigen::LLT<Matrix> cholesky_;
  Eigen::JacobiSVD<Matrix> svd_;
  Matrix square_, inverse_;
  Vector rhs_;
};

}  // namespace humanoid_rail
