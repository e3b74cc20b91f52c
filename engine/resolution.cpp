#include "resolution.hpp"

#include <cmath>

namespace humanoid_rail {

namespace {

// tr((L L^T)^-1), the sum of the squares of the elements of L^-1, which is left in inverse.
double trace_of_inverse(const Matrix& L, Matrix& inverse) {
  double trace = 0.0;
  for (Eigen::Index j = 0; j < L.rows(); ++j) {
    for (Eigen::Index i = j; i < L.rows(); ++i) {
      double x = i == j ? 1.0 : 0.0;
      for (Eigen::Index k = j; k < i; ++k) x -= L(i, k) * inverse(k, j);
      inverse(i, j) = x / L(i, i);
      trace += inverse(i, j) * inverse(i, j);
    }
  }
  return trace;
}

}  // namespace

double damping(double smallest_singular_value) {
  const double ratio = smallest_singular_value / SINGULAR_VALUE;
  return ratio < 1.0 ? MAX_DAMPING * std::sqrt(1.0 - ratio * ratio) : 0.0;
}

PseudoInverse::PseudoInverse(Eigen::Index rows, Eigen::Index columns)
    : cholesky_(rows),
      svd_(rows, columns, Eigen::ComputeThinU | Eigen::ComputeThinV),
      square_(rows, rows),
      inverse_(rows, rows),
      rhs_(rows) {}

void PseudoInverse::decompose(const Matrix& J) {
  square_.noalias() = J.lazyProduct(J.transpose());
  cholesky_.compute(square_);
  // The trace is not less than 1 / sigma^2 for the smallest singular value sigma.
  regular_ = cholesky_.info() == Eigen::Success &&
             trace_of_inverse(cholesky_.matrixLLT(), inverse_) * SINGULAR_VALUE * SINGULAR_VALUE <= 1.0;
  if (!regular_) svd_.compute(J);
}

void PseudoInverse::redundant_velocity(const Matrix& J, const Vector& Ke, const Vector& secondary, Vector& velocity) {
  velocity = secondary;
  if (regular_) {
    // Both terms need (J J^T)^-1: q_dot = q_dot_0 - J^T (J J^T)^-1 (K e + J q_dot_0).
    rhs_ = Ke;
    rhs_.noalias() += J.lazyProduct(secondary);
    cholesky_.solveInPlace(rhs_);
    velocity.noalias() -= J.transpose().lazyProduct(rhs_);
    return;
  }
  const auto& sigma = svd_.singularValues();
  const double lambda = damping(sigma[sigma.size() - 1]);
  for (Eigen::Index i = 0; i < sigma.size(); ++i) {
    double along = sigma[i] / (sigma[i] * sigma[i] + lambda * lambda) * svd_.matrixU().col(i).dot(Ke);
    // The projector is never damped, so that the hands are left alone.
    if (sigma[i] > 1e-12 * sigma[0]) along += svd_.matrixV().col(i).dot(secondary);
    velocity -= along * svd_.matrixV().col(i);
  }
}

std::optional<Vector> PseudoInverse::lost_direction() const {
  if (regular_) return std::nullopt;
  const auto& sigma = svd_.singularValues();
  const double smallest = sigma[sigma.size() - 1];
  const double squared = smallest * smallest;
  const double lambda = damping(smallest);
  if (squared >= 1e-3 * (squared + lambda * lambda)) return std::nullopt;
  return svd_.matrixU().col(sigma.size() - 1);
}

GradientProjection::GradientProjection(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : kinematics(robot),
      clearances(robot, obstacles),
      pseudoinverse_(robot->rows(), robot->n()),
      error_(robot->rows()),
      Ke_(robot->rows()),
      gradient_(robot->model.nv),
      secondary_(robot->n()),
      velocity_(robot->n()),
      wrenches_(static_cast<std::size_t>(robot->model.njoints)) {}

const Vector& GradientProjection::velocity(const Eigen::Ref<const Vector>& q, double t,
                                           const Eigen::Ref<const Vector>& targets, const Gains& gains) {
  // Without the penalty nobody asks what is near.
  look(q, t, gains.c_kappa != 0.0 ? gains.epsilon : -INFINITE);
  return resolve(targets, gains);
}

void GradientProjection::look(const Eigen::Ref<const Vector>& q, double t, double horizon) {
  kinematics.move_to(q);
  clearances.move_to(t);
  near_ = nullptr;
  if (clearances.obstacles() > 0 && horizon > -INFINITE) {
    near_ = &clearances.within(horizon, kinematics);
  }
}

const Vector& GradientProjection::resolve(const Eigen::Ref<const Vector>& targets, const Gains& gains) {
  const Robot& robot = kinematics.robot();

  // q_dot_0 = c_mu (d mu/dq)^T - c_kappa sum_i (d kappa(psi_i)/dq)^T, eq. 4.8, with kappa = (psi - epsilon)^2 within
  // epsilon, first with respect to all joints and then, by S^T, to the actuated ones.
  gradient_.setZero();
  if (gains.c_mu != 0.0) kinematics.add_manipulability_gradient(gains.c_mu, gradient_);
  if (gains.c_kappa != 0.0 && near_) {
    for (auto& wrench : wrenches_) wrench.setZero();
    for (const Nearest& pair : *near_) {
      if (pair.distance >= gains.epsilon) continue;
      const double slope = 2.0 * (pair.distance - gains.epsilon);
      wrenches_[robot.joint_of(pair.link)] += pair.wrench() * (gains.c_kappa * slope);
    }
    kinematics.add_wrenches(wrenches_, gradient_);
  }
  secondary_.noalias() = robot.coupling.transpose() * gradient_;

  error_ = kinematics.hands() - targets;
  Ke_ = gains.gain.cwiseProduct(error_);
  pseudoinverse_.decompose(kinematics.jacobian());
  pseudoinverse_.redundant_velocity(kinematics.jacobian(), Ke_, secondary_, velocity_);
  return velocity_;
}

bool GradientProjection::is_held_by_singularity(double tolerance) const {
  const auto lost = pseudoinverse_.lost_direction();
  return lost && std::abs(lost->dot(error_)) > tolerance;
}

}  // namespace humanoid_rail
