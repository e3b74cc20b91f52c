// The manipulability of the arms, eq. 3.4, and its gradient.
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "kinematics.hpp"

namespace humanoid_rail {

namespace {

// Below this det(J J^T), relative to that of an arm which is as good in every direction, an arm goes the slow way.
constexpr double REGULAR = 1e-4;
// A singular value this much smaller than the largest is 0 up to rounding.
constexpr double ZERO = 1e-14;

}  // namespace

// mu is the product over the arms of sqrt(det(J J^T)), and d mu = mu sum <(J J^T)^-1 J, dJ>. Returns whether the arms
// are far enough from singularities for that to be precise.
bool Kinematics::weigh_regular_arms() {
  double mu_squared = 1.0;
  for (Arm& arm : arms_) {
    const Eigen::Matrix3d JJt = arm.jacobian.lazyProduct(arm.jacobian.transpose());
    Eigen::Matrix3d inverse;
    double determinant;
    bool invertible;
    JJt.computeInverseAndDetWithCheck(inverse, determinant, invertible, 0.0);
    if (!invertible || determinant < REGULAR * std::pow(JJt.trace() / 3.0, 3)) return false;
    arm.weights = inverse.lazyProduct(arm.jacobian);
    mu_squared *= determinant;
  }
  manipulability_ = std::sqrt(mu_squared);
  for (Arm& arm : arms_) arm.weights *= manipulability_;
  return true;
}

// The same from J = sum_i sigma_i u_i v_i^T of each arm, without a division:
// d mu = sum_i (prod_{j != i} sigma_j) u_i^T dJ v_i, taken as 0 where mu is.
void Kinematics::weigh_any_arms() {
  double smallest = INFINITY, largest = 0.0;
  manipulability_ = 1.0;
  for (Arm& arm : arms_) {
    const auto& sigma = arm.svd.compute(arm.jacobian).singularValues();
    smallest = std::min(smallest, sigma[2]);
    largest = std::max(largest, sigma[0]);
    manipulability_ *= sigma.prod();
  }
  const bool singular = smallest <= ZERO * largest;
  for (std::size_t a = 0; a < arms_.size(); ++a) {
    Arm& arm = arms_[a];
    arm.weights.setZero();
    if (singular) continue;
    double others = 1.0;
    for (std::size_t b = 0; b < arms_.size(); ++b) {
      if (b != a) others *= arms_[b].svd.singularValues().prod();
    }
    const auto& sigma = arm.svd.singularValues();
    for (int i = 0; i < 3; ++i) {
      const double product = others * sigma[(i + 1) % 3] * sigma[(i + 2) % 3];
      for (Eigen::Index c = 0; c < arm.weights.cols(); ++c) {
        arm.weights.col(c) += product * arm.svd.matrixV()(c, i) * arm.svd.matrixU().col(i);
      }
    }
  }
}

// The derivative of the column of joint c by joint k of the same chain is w_k x J_c where k comes before c or is c, and
// w_c x J_k where k comes after c (w: axes, 0 for prismatic joints). So with weights W_c
//   d mu / d q_k = w_k . sum_{c >= k} J_c x W_c + J_k . sum_{c < k} W_c x w_c.
void Kinematics::add_manipulability_gradient(double factor, Vector& gradient) const {
  const auto& model = robot_->model;
  for (std::size_t h = 0; h < arms_.size(); ++h) {
    const Hand& hand = robot_->hands[h];
    const Arm& arm = arms_[h];
    const auto& chain = robot_->chain_of(hand);
    const auto weight = [&](Eigen::Index v) {
      Eigen::Vector3d W = Eigen::Vector3d::Zero();
      for (Coupling::InnerIterator S(robot_->coupling, v); S; ++S) {
        for (std::size_t c = 0; c < hand.arm.size(); ++c) {
          if (hand.arm[c] == S.col()) W += S.value() * arm.weights.col(static_cast<Eigen::Index>(c));
        }
      }
      return W;
    };
    Eigen::Vector3d after = Eigen::Vector3d::Zero(), before = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const auto v = model.joints[chain[i]].idx_v();
      const Eigen::Vector3d J = arm.chain.col(static_cast<Eigen::Index>(i));
      gradient[v] += factor * J.dot(before);
      before += weight(v).cross(Eigen::Vector3d(data_.J.col(v).tail<3>()));
    }
    for (std::size_t i = chain.size(); i-- > 0;) {
      const auto v = model.joints[chain[i]].idx_v();
      const Eigen::Vector3d J = arm.chain.col(static_cast<Eigen::Index>(i));
      after += J.cross(weight(v));
      gradient[v] += factor * data_.J.col(v).tail<3>().dot(after);
    }
  }
}

}  // namespace humanoid_rail
