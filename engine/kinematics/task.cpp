#include "task.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>

namespace humanoid_rail {

namespace {

// An axis is opposite to its direction if the cosine of their angle is less than this above -1.
constexpr double OPPOSITE = 1e-12;

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
  const Eigen::Vector3d apart = at.hand(second_) - at.hand(first_);
  e = (in_first_ ? Eigen::Vector3d(at.hand_rotation(first_).transpose() * apart) : apart) - difference_;
}

void RelativeTask::jacobian(const Kinematics& at, double, Eigen::Ref<Matrix> J) const {
  J = at.jacobian().middleRows<3>(3 * second_) - at.jacobian().middleRows<3>(3 * first_);
  if (!in_first_) return;
  // R^T (x_dot - w x x), and -w x x = [x]x w.
  add_arm(at.hand(second_) - at.hand(first_), at.angular_jacobian(first_), -1.0, J);
  const Eigen::Matrix3d back = at.hand_rotation(first_).transpose();
  for (Eigen::Index i = 0; i < J.cols(); ++i) J.col(i) = (back * Eigen::Vector3d(J.col(i))).eval();
}

void DistanceTask::error(const Kinematics& at, double, Eigen::Ref<Vector> e) const {
  e[0] = (at.hand(second_) - at.hand(first_)).norm() - distance_;
}

void DistanceTask::jacobian(const Kinematics& at, double, Eigen::Ref<Matrix> J) const {
  const Eigen::Vector3d along = (at.hand(second_) - at.hand(first_)).stableNormalized();
  J = along.transpose() * (at.jacobian().middleRows<3>(3 * second_) - at.jacobian().middleRows<3>(3 * first_));
}

void LineTask::error(const Kinematics& at, double, Eigen::Ref<Vector> e) const {
  e = across_.transpose() * (at.hand(hand_) + at.hand_rotation(hand_) * offset_ - point_);
}

void LineTask::jacobian(const Kinematics& at, double, Eigen::Ref<Matrix> J) const {
  Matrix whole = at.jacobian().middleRows<3>(3 * hand_);
  if (!offset_.isZero(0.0)) add_arm(at.hand_rotation(hand_) * offset_, at.angular_jacobian(hand_), 1.0, whole);
  J = across_.transpose() * whole;
}

void AxisTask::error(const Kinematics& at, double, Eigen::Ref<Vector> e) const {
  const Eigen::Vector3d axis = at.hand_rotation(hand_) * axis_;
  e = 2.0 * lever_ / std::max(1.0 + direction_.dot(axis), OPPOSITE) * (across_.transpose() * axis);
}

void AxisTask::jacobian(const Kinematics& at, double, Eigen::Ref<Matrix> J) const {
  const Eigen::Vector3d axis = at.hand_rotation(hand_) * axis_;
  const double sum = std::max(1.0 + direction_.dot(axis), OPPOSITE);
  Matrix turned = Matrix::Zero(3, J.cols());
  add_arm(axis, at.angular_jacobian(hand_), 1.0, turned);
  const Eigen::Matrix<double, 2, 3> rows =
      2.0 * lever_ / sum * (across_.transpose() - across_.transpose() * axis * direction_.transpose() / sum);
  J = rows * turned;
}

Eigen::Quaterniond OrientationTask::left(const Kinematics& at) const {
  Eigen::Matrix3d turned = at.hand_rotation(hand_);
  if (reference_ >= 0) turned = (at.hand_rotation(reference_).transpose() * turned).eval();
  Eigen::Quaterniond turn(turned * rotation_.transpose());
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  return turn;
}

void OrientationTask::error(const Kinematics& at, double, Eigen::Ref<Vector> e) const {
  e = 2.0 * lever_ * left(at).vec();
}

// With the angular velocity w of the turn, 2 v_dot = w_0 w - v x w.
void OrientationTask::jacobian(const Kinematics& at, double, Eigen::Ref<Matrix> J) const {
  const Eigen::Quaterniond turn = left(at);
  Matrix angular = at.angular_jacobian(hand_);
  Eigen::Matrix3d back = Eigen::Matrix3d::Identity();
  if (reference_ >= 0) {
    angular -= at.angular_jacobian(reference_);
    back = at.hand_rotation(reference_).transpose();
  }
  for (Eigen::Index i = 0; i < J.cols(); ++i) {
    const Eigen::Vector3d w = back * angular.col(i);
    J.col(i) = lever_ * (turn.w() * w - turn.vec().cross(w));
  }
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

WithinBoxTask::WithinBoxTask(std::shared_ptr<const Task> task, Matrix axes, Vector tolerance)
    : task_(std::move(task)), axes_(std::move(axes)), tolerance_(std::move(tolerance)) {
  if (axes_.rows() != task_->rows() || axes_.cols() != tolerance_.size()) {
    throw std::invalid_argument("a tolerance needs an axis with a component for each row of its task");
  }
}

Vector WithinBoxTask::along(const Kinematics& at, double t) const {
  Vector whole(task_->rows());
  task_->error(at, t, whole);
  return axes_.transpose() * whole;
}

void WithinBoxTask::error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const {
  const Vector d = along(at, t);
  e = d - d.cwiseMin(tolerance_).cwiseMax(-tolerance_);
}

void WithinBoxTask::jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const {
  const Vector d = along(at, t);
  Matrix whole(task_->rows(), J.cols());
  task_->jacobian(at, t, whole);
  J = axes_.transpose() * whole;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    if (std::abs(d[i]) < tolerance_[i]) J.row(i).setZero();
  }
}

void WithinBallTask::error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const {
  task_->error(at, t, e);
  const double norm = e.norm();
  e *= norm > tolerance_ ? 1.0 - tolerance_ / norm : 0.0;
}

void WithinBallTask::jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const {
  Vector d(task_->rows());
  task_->error(at, t, d);
  const double norm = d.norm();
  if (norm <= tolerance_) {
    J.setZero();
    return;
  }
  Matrix whole(task_->rows(), J.cols());
  task_->jacobian(at, t, whole);
  d /= norm;
  J = (1.0 - tolerance_ / norm) * whole + tolerance_ / norm * d * (d.transpose() * whole);
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
