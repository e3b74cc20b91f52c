// Tasks: what is to be reached, as errors that are to become 0. Errors are what is there minus what is wanted.
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "kinematics.hpp"

namespace humanoid_rail {

class Task {
 public:
  virtual ~Task() = default;
  [[nodiscard]] virtual Eigen::Index rows() const = 0;
  // Sets e (m); the hands have to be where they are, which Kinematics::move_hands_to sees to.
  virtual void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const = 0;
  // Sets de/dq (m, n), after Kinematics::move_to.
  virtual void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const = 0;
  // Sets both.
  virtual void evaluate(const Kinematics& at, double t, Eigen::Ref<Vector> e, Eigen::Ref<Matrix> J) const {
    error(at, t, e);
    jacobian(at, t, J);
  }
};

// A point of a hand that has to be at a place: e = p + R offset - target.
class PointTask : public Task {
 public:
  PointTask(int hand, const Eigen::Vector3d& offset, const Eigen::Vector3d& target)
      : hand_(hand), offset_(offset), target_(target) {}
  [[nodiscard]] Eigen::Index rows() const override { return 3; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  int hand_;
  Eigen::Vector3d offset_, target_;
};

// A hand that has to point in a direction: e = lever (R pointing - direction).
class DirectionTask : public Task {
 public:
  DirectionTask(int hand, const Eigen::Vector3d& pointing, const Eigen::Vector3d& direction, double lever)
      : hand_(hand), pointing_(pointing), direction_(direction), lever_(lever) {}
  [[nodiscard]] Eigen::Index rows() const override { return 3; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  int hand_;
  Eigen::Vector3d pointing_, direction_;
  double lever_;
};

// Two hands that have to be in a relation: e = p_second - p_first - difference, or R_first^T (p_second - p_first) -
// difference where the difference is in the first hand's frame.
class RelativeTask : public Task {
 public:
  RelativeTask(int first, int second, const Eigen::Vector3d& difference, bool in_first)
      : first_(first), second_(second), difference_(difference), in_first_(in_first) {}
  [[nodiscard]] Eigen::Index rows() const override { return 3; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  int first_, second_;
  Eigen::Vector3d difference_;
  bool in_first_;
};

// Two hands that have to be at a distance: e = |p_second - p_first| - distance.
class DistanceTask : public Task {
 public:
  DistanceTask(int first, int second, double distance) : first_(first), second_(second), distance_(distance) {}
  [[nodiscard]] Eigen::Index rows() const override { return 1; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  int first_, second_;
  double distance_;
};

// A point of a hand that has to be on a line: e = B^T (p + R offset - point), with a basis B (3, 2) of what is across.
class LineTask : public Task {
 public:
  using Across = Eigen::Matrix<double, 3, 2>;

  LineTask(int hand, const Eigen::Vector3d& offset, const Eigen::Vector3d& point, const Across& across)
      : hand_(hand), offset_(offset), point_(point), across_(across) {}
  [[nodiscard]] Eigen::Index rows() const override { return 2; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  int hand_;
  Eigen::Vector3d offset_, point_;
  Across across_;
};

// An axis of a hand that has to lie along a direction d: e = 2 lever B^T R axis / (1 + d . R axis), with a basis B (3,
// 2) of what is across d. Its norm is 2 lever tan(angle / 2).
class AxisTask : public Task {
 public:
  using Across = LineTask::Across;

  AxisTask(int hand, const Eigen::Vector3d& axis, const Eigen::Vector3d& direction, const Across& across, double lever)
      : hand_(hand), axis_(axis), direction_(direction), across_(across), lever_(lever) {}
  [[nodiscard]] Eigen::Index rows() const override { return 2; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  int hand_;
  Eigen::Vector3d axis_, direction_;
  Across across_;
  double lever_;
};

// A hand that has to be turned in one way in the base frame or, if that is no -1, in the frame of another hand: e = 2
// lever v, with the quaternion (w >= 0, v) of the turn that is left. Its norm is 2 lever sin(angle / 2).
class OrientationTask : public Task {
 public:
  OrientationTask(int hand, const Eigen::Matrix3d& rotation, int reference, double lever)
      : hand_(hand), rotation_(rotation), reference_(reference), lever_(lever) {}
  [[nodiscard]] Eigen::Index rows() const override { return 3; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  [[nodiscard]] Eigen::Quaterniond left(const Kinematics& at) const;

  int hand_;
  Eigen::Matrix3d rotation_;
  int reference_;
  double lever_;
};

// Joints that have to be at positions: e = q_i - target_i.
class ConfigurationTask : public Task {
 public:
  ConfigurationTask(std::vector<int> joints, Vector target) : joints_(std::move(joints)), target_(std::move(target)) {}
  [[nodiscard]] Eigen::Index rows() const override { return target_.size(); }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  std::vector<int> joints_;
  Vector target_;
};

// A task that is done within a tolerance along each of some axes: e = d - clamp(d, -tolerance, tolerance), with d =
// axes^T times the error of the task.
class WithinBoxTask : public Task {
 public:
  WithinBoxTask(std::shared_ptr<const Task> task, Matrix axes, Vector tolerance);
  [[nodiscard]] Eigen::Index rows() const override { return tolerance_.size(); }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  [[nodiscard]] Vector along(const Kinematics& at, double t) const;

  std::shared_ptr<const Task> task_;
  Matrix axes_;
  Vector tolerance_;
};

// A task that is done where the norm of its error d is within a tolerance: e = d max(0, 1 - tolerance / |d|).
class WithinBallTask : public Task {
 public:
  WithinBallTask(std::shared_ptr<const Task> task, double tolerance) : task_(std::move(task)), tolerance_(tolerance) {}
  [[nodiscard]] Eigen::Index rows() const override { return task_->rows(); }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  std::shared_ptr<const Task> task_;
  double tolerance_;
};

// A task that somebody else computes, from a configuration (n) and a time in s.
class FunctionTask : public Task {
 public:
  using Function = std::function<std::pair<Vector, Matrix>(const Vector& q, double t)>;

  FunctionTask(Eigen::Index rows, Function function) : rows_(rows), function_(std::move(function)) {}
  [[nodiscard]] Eigen::Index rows() const override { return rows_; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;
  void evaluate(const Kinematics& at, double t, Eigen::Ref<Vector> e, Eigen::Ref<Matrix> J) const override;

 private:
  [[nodiscard]] std::pair<Vector, Matrix> checked(const Kinematics& at, double t) const;

  Eigen::Index rows_;
  Function function_;
};

// Tasks one below the other.
class TaskStack {
 public:
  explicit TaskStack(std::vector<std::shared_ptr<const Task>> tasks);

  [[nodiscard]] Eigen::Index rows() const { return rows_; }
  void error(const Kinematics& at, double t, Vector& e) const;
  void evaluate(const Kinematics& at, double t, Vector& e, Matrix& J) const;

 private:
  std::vector<std::shared_ptr<const Task>> tasks_;
  Eigen::Index rows_ = 0;
};

}  // namespace humanoid_rail
