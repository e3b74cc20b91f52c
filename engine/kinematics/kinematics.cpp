#include "kinematics.hpp"

#include <Eigen/Geometry>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/geometry.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>

#include "../interruption.hpp"

namespace humanoid_rail {

Kinematics::Kinematics(std::shared_ptr<const Robot> robot)
    : robot_(std::move(robot)),
      data_(robot_->model),
      bodies_(robot_->bodies),
      q_(robot_->n()),
      full_(robot_->model.nq),
      hands_(robot_->rows()),
      jacobian_(robot_->rows(), robot_->n()) {
  for (const Hand& hand : robot_->hands) {
    const auto joints = static_cast<Eigen::Index>(hand.arm.size());
    const auto in_chain = static_cast<Eigen::Index>(robot_->chain_of(hand).size());
    Arm arm{Columns(3, joints), Columns(3, joints), Columns(3, in_chain), {}};
    arm.svd = Eigen::JacobiSVD<Columns>(3, joints, Eigen::ComputeThinU | Eigen::ComputeThinV);
    arms_.push_back(std::move(arm));
  }
}

void Kinematics::place_joints(const Eigen::Ref<const Vector>& q) {
  Interruption::poll();
  is_complete_ = false;
  q_ = q;
  full_ = robot_->offset;
  full_.noalias() += robot_->coupling * q_;
}

void Kinematics::move_hands_to(const Eigen::Ref<const Vector>& q) {
  move_joints_to(q);
  place_hands();
}

void Kinematics::move_joints_to(const Eigen::Ref<const Vector>& q) {
  place_joints(q);
  pinocchio::forwardKinematics(robot_->model, data_, full_);
}

void Kinematics::move_to(const Eigen::Ref<const Vector>& q) {
  if (is_complete_ && q_ == q) return;
  place_joints(q);
  pinocchio::computeJointJacobians(robot_->model, data_, full_);
  place_hands();
  pinocchio::updateGeometryPlacements(robot_->model, data_, robot_->bodies, bodies_);
  evaluate_jacobian();
  if (!weigh_regular_arms()) weigh_any_arms();
  is_complete_ = true;
}

void Kinematics::evaluate_jacobian() {
  jacobian_.setZero();
  for (std::size_t h = 0; h < arms_.size(); ++h) {
    const Hand& hand = robot_->hands[h];
    const auto row = 3 * static_cast<Eigen::Index>(h);
    const Eigen::Vector3d p = hands_.segment<3>(row);
    Arm& arm = arms_[h];
    Eigen::Index i = 0;
    for (const auto joint : robot_->chain_of(hand)) {
      const auto v = robot_->model.joints[joint].idx_v();
      const auto column = data_.J.col(v);
      arm.chain.col(i) = column.head<3>() + column.tail<3>().cross(p);
      for (Coupling::InnerIterator S(robot_->coupling, v); S; ++S) {
        jacobian_.col(S.col()).segment<3>(row) += S.value() * arm.chain.col(i);
      }
      ++i;
    }
    for (std::size_t c = 0; c < hand.arm.size(); ++c) {
      arm.jacobian.col(static_cast<Eigen::Index>(c)) = jacobian_.col(hand.arm[c]).segment<3>(row);
    }
  }
}

Matrix Kinematics::angular_jacobian(int h) const {
  Matrix angular = Matrix::Zero(3, robot_->n());
  for (const auto joint : robot_->chain_of(robot_->hands[static_cast<std::size_t>(h)])) {
    const auto v = robot_->model.joints[joint].idx_v();
    for (Coupling::InnerIterator S(robot_->coupling, v); S; ++S) {
      angular.col(S.col()) += S.value() * data_.J.col(v).tail<3>();
    }
  }
  return angular;
}

void Kinematics::place_hands() {
  for (std::size_t h = 0; h < arms_.size(); ++h) {
    const auto& placement = pinocchio::updateFramePlacement(robot_->model, data_, robot_->hands[h].frame);
    hands_.segment<3>(3 * static_cast<Eigen::Index>(h)) = placement.translation();
  }
}

void Kinematics::add_wrenches(std::vector<pinocchio::Force>& wrenches, Vector& gradient) const {
  const auto& model = robot_->model;
  for (auto joint = static_cast<pinocchio::JointIndex>(model.njoints) - 1; joint > 0; --joint) {
    const auto v = model.joints[joint].idx_v();
    gradient[v] += data_.J.col(v).dot(wrenches[joint].toVector());
    wrenches[model.parents[joint]] += wrenches[joint];
  }
}

void Kinematics::add_wrench(const pinocchio::Force& wrench, pinocchio::JointIndex joint, pinocchio::JointIndex from,
                            double factor, Eigen::Ref<Vector> gradient) const {
  const auto& model = robot_->model;
  for (; joint > from; joint = model.parents[joint]) {
    const auto v = model.joints[joint].idx_v();
    const double torque = factor * data_.J.col(v).dot(wrench.toVector());
    for (Coupling::InnerIterator S(robot_->coupling, v); S; ++S) gradient[S.col()] += S.value() * torque;
  }
}

void Kinematics::set_motions(const Vector& velocity, std::vector<pinocchio::Motion>& motions) const {
  const auto& model = robot_->model;
  for (pinocchio::JointIndex joint = 1; joint < static_cast<pinocchio::JointIndex>(model.njoints); ++joint) {
    const auto v = model.joints[joint].idx_v();
    motions[joint] = motions[model.parents[joint]];
    motions[joint].toVector() += velocity[v] * data_.J.col(v);
  }
}

}  // namespace humanoid_rail
