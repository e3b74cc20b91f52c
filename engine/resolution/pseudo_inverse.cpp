#include "pseudo_inverse.hpp"

#include <cmath>

namespace humanoid_rail {

namespace {

// Singular values below this share of the largest belong to the null space.
constexpr double REDUNDANT = 1e-12;
// A direction is lost where damping leaves less than this share of the velocity that is asked for along it.
constexpr double LOST = 1e-3;
// The largest damping is the threshold over this: it bounds the norm of J# by one over the threshold.
constexpr double SQRT_2 = 1.41421356237309504880;

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

double damping(double smallest_singular_value, double threshold) {
  const double ratio = smallest_singular_value / threshold;
  return ratio < 1.0 ? threshold / SQRT_2 * std::sqrt(1.0 - ratio * ratio) : 0.0;
}

void PseudoInverse::resize(Eigen::Index rows, Eigen::Index columns) {
  if (square_.rows() == rows && svd_.cols() == columns) return;
  cholesky_.compute(Matrix::Identity(rows, rows));  // Makes room; assigned, it would be read before it is set.
  svd_ = Eigen::JacobiSVD<Matrix>(rows, columns, Eigen::ComputeThinU | Eigen::ComputeThinV);
  square_.resize(rows, rows);
  inverse_.resize(rows, rows);
  rhs_.resize(rows);
}

void PseudoInverse::decompose(const Matrix& J, double threshold) {
  resize(J.rows(), J.cols());
  threshold_ = threshold;
  square_.noalias() = J.lazyProduct(J.transpose());
  cholesky_.compute(square_);
  // The trace is not less than 1 / sigma^2 for the smallest singular value sigma.
  regular_ = cholesky_.info() == Eigen::Success &&
             trace_of_inverse(cholesky_.matrixLLT(), inverse_) * threshold * threshold <= 1.0;
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
  const double lambda = damping(sigma[sigma.size() - 1], threshold_);
  for (Eigen::Index i = 0; i < sigma.size(); ++i) {
    double along = sigma[i] / (sigma[i] * sigma[i] + lambda * lambda) * svd_.matrixU().col(i).dot(Ke);
    // The projector is never damped, so that the hands are left alone.
    if (sigma[i] > REDUNDANT * sigma[0]) along += svd_.matrixV().col(i).dot(secondary);
    velocity -= along * svd_.matrixV().col(i);
  }
}

std::optional<Vector> PseudoInverse::lost_direction() const {
  if (regular_) return std::nullopt;
  const auto& sigma = svd_.singularValues();
  const double smallest = sigma[sigma.size() - 1];
  const double squared = smallest * smallest;
  const double lambda = damping(smallest, threshold_);
  if (squared >= LOST * (squared + lambda * lambda)) return std::nullopt;
  return svd_.matrixU().col(sigma.size() - 1);
}

}  // namespace humanoid_rail
