// Redundancy resolution at the velocity level: eq. 4.6 to 4.9. Beside humanoid_rail/resolution.py.
#pragma once

#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/SVD>

#include "clearance.hpp"

namespace humanoid_rail {

// Smallest singular value of J below which the pseudo-inverse is damped; above it eq. 4.9 is exact.
constexpr double SINGULAR_VALUE = 0.1;
// The largest damping, at a singularity.
constexpr double MAX_DAMPING = SINGULAR_VALUE / 1.41421356237309504880;

// Parameters of eq. 4.9, as in resolution.py.
struct Gains {
  Vector gain;  // Diagonal of K (3h), 1/s.
  double c_mu;
  double c_kappa;
  double epsilon;  // m
};

// The damping lambda: 0 except next to a singularity (Nakamura and Hanafusa 1986).
double damping(double smallest_singular_value);

// J# = J^T (J J^T + lambda^2 I)^-1 and I - J# J of one J, without forming them.
class PseudoInverse {
 public:
  PseudoInverse(Eigen::Index rows, Eigen::Index columns);

  void decompose(const Matrix& J);
  // Sets velocity to -J# Ke + (I - J# J) secondary, eq. 4.6 and 4.7. Here J and Ke are those of decompose.
  void redundant_velocity(const Matrix& J, const Vector& Ke, const Vector& secondary, Vector& velocity);
  // The unit vector (3h) along which the hands can all but not move; none away from singularities.
  std::optional<Vector> lost_direction() const;

 private:
  bool regular_ = true;
  Eigen::LLT<Matrix> cholesky_;
  Eigen::JacobiSVD<Matrix> svd_;
  Matrix square_;
  Matrix inverse_;
  Vector rhs_;
};

// q_dot of eq. 4.9 for a robot among obstacles, with the workspace that takes. Not to be shared between threads.
// Evaluations allocate nothing, except what Eigen's SVD does at singularities and coal's GJK for boxes and meshes.
class GradientProjection {
 public:
  GradientProjection(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);

  // Returns q_dot (n), m/s and rad/s, at a configuration (n) and a time in s, for targets x_f (3h) in m.
  const Vector& velocity(const Eigen::Ref<const Vector>& q, double t, const Eigen::Ref<const Vector>& targets,
                         const Gains& gains);
  // The two halves of that: moves robot and obstacles and finds what is within a horizon, ...
  void look(const Eigen::Ref<const Vector>& q, double t, double horizon);
  // ... which has to be the activation distance or more, and resolves the redundancy there.
  const Vector& resolve(const Eigen::Ref<const Vector>& targets, const Gains& gains);
  // e of eq. 4.1 (3h) where velocity() was asked for last, m.
  const Vector& error() const { return error_; }
  // Whether more than a tolerance of it, m, lies in a direction that J has lost there.
  bool is_held_by_singularity(double tolerance) const;

  Kinematics kinematics;
  Clearances clearances;

 private:
  const std::vector<Nearest>* near_ = nullptr;
  PseudoInverse pseudoinverse_;
  Vector error_;
  Vector Ke_;
  Vector gradient_;
  Vector secondary_;
  Vector velocity_;
  std::vector<pinocchio::Force> wrenches_;
};

}  // namespace humanoid_rail
