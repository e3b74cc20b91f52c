#include "task.hpp"

#include <stdexcept>

#include <Eigen/Geometry>

namespace humanoid_rail {

namespace {

// Subtracts [arm]x J_w from J: what a point on an arm of a hand adds to the hand's own motion.
void add_arm(const Eigen::Vector3d& arm, const Matrix& angular, double factor, Eigen::Ref<Matrix> J) {
  for (Eigen::Index i = 0; i < J.cols(); ++i) {
    J.col(i) -= factor * arm.cross(Eigen::Vector3d(angular.col(i)));
  }
}

}  // namespace

void PointTask::error(const Kinematics& at, double, Eigen::Ref<Vector> e) const {
  e = at.hand(hand_) - target_;
  if (!offset_.isZero(0.0)) e += at.hand_rotation(hand_) * offset_;
}

void PointTask::jacobian(const Kinematics& at, double, Eigen::Ref<Matrix> J) const {
  J = at.jacobian().middleRows<3>(3 * hand_);
  if (!offset_.isZero(0.0)) add_arm(at.hand_rotation(hand_) * offset_, at.angular_jacobian(hand_), 1.0, J);
}

void DirectionTask::error(const Kinematics& at, double, Eigen::Ref<Vector> e) const {
  e = lever_ * (at.hand_rotation(hand_) * pointing_ - direction_);
}

void DirectionTask::jacobian(const Kinematics& at, double, Eigen::Ref<Matrix> J) const {
  J.setZero();
  add_arm(at.hand_rotation(hand_) * pointing_, at.angular_jacobian(hand_), lever_, J);
}

void RelativeTask::error(const Kinematics& at, double, Eigen::Ref<Vector> e) const {
  e = at.hand(second_) - at.hand(first_) - difference_;
}

void RelativeTask::jacobian(const Kinematics& at, double, Eigen::Ref<Matrix> J) const {
  J = at.jacobian().middleRows<3>(3 * second_) - at.jacobian().middleRows<3>(3 * first_);
}

void ConfigurationTask::error(const Kinematics& at, double, Eigen::Ref<Vector> e) const {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    e[row] = at.configuration()[joints_[i]] - target_[row];
  }
}

void ConfigurationTask::jacobian(const Kinematics&, double, Eigen::Ref<Matrix> J) const {
  J.setZero();
  for (std::size_t i = 0; i < joints_.size(); ++i) J(static_cast<Eigen::Index>(i), joints_[i]) = 1.0;
}

std::pair<Vector, Matrix> FunctionTask::checked(const Kinematics& at, double t) const {
  auto found = function_(at.configuration(), t);
  const auto& [e, J] = found;
  if (e.size() != rows_ || J.rows() != rows_ || J.cols() != at.configuration().size() || !e.allFinite() ||
      !J.allFinite()) {
    throw std::invalid_argument("a task needs a finite error and a finite Jacobian, a row for each of its rows");
  }
  return found;
}

void FunctionTask::error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const { e = checked(at, t).first; }

void FunctionTask::jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const { J = checked(at, t).second; }

void FunctionTask::evaluate(const Kinematics& at, double t, Eigen::Ref<Vector> e, Eigen::Ref<Matrix> J) const {
  const auto [error, jacobian] = checked(at, t);
  e = error;
  J = jacobian;
}

TaskStack::TaskStack(std::vector<std::shared_ptr<const Task>> tasks) : tasks_(std::move(tasks)) {
  for (const auto& task : tasks_) rows_ += task->rows();
  if (rows_ == 0) throw std::invalid_argument("there has to be a task");
}

void TaskStack::error(const Kinematics& at, double t, Vector& e) const {
  e.resize(rows_);
  Eigen::Index row = 0;
  for (const auto& task : tasks_) {
    task->error(at, t, e.segment(row, task->rows()));
    row += task->rows();
  }
}

void TaskStack::evaluate(const Kinematics& at, double t, Vector& e, Matrix& J) const {
  e.resize(rows_);
  J.resize(rows_, at.robot().n());
  Eigen::Index row = 0;
  for (const auto& task : tasks_) {
    task->evaluate(at, t, e.segment(row, task->rows()), J.middleRows(row, task->rows()));
    row += task->rows();
  }
}

}  // namespace humanoid_rail
