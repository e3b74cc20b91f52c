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

// Two hands that have to be in a relation: e = p_second - p_first - difference.
class RelativeTask : public Task {
 public:
  RelativeTask(int first, int second, const Eigen::Vector3d& difference)
      : first_(first), second_(second), difference_(difference) {}
  [[nodiscard]] Eigen::Index rows() const override { return 3; }
  void error(const Kinematics& at, double t, Eigen::Ref<Vector> e) const override;
  void jacobian(const Kinematics& at, double t, Eigen::Ref<Matrix> J) const override;

 private:
  int first_, second_;
  Eigen::Vector3d difference_;
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
