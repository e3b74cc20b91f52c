// What is true of a robot at one configuration: eq. 2.1, 2.2 and 3.4.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/SVD>
#include <pinocchio/multibody/data.hpp>

#include "../model/robot.hpp"

namespace humanoid_rail {

// A robot at a configuration. Holds its workspace. Not to be shared between threads.
class Kinematics {
 public:
  explicit Kinematics(std::shared_ptr<const Robot> robot);

  // Moves the robot to a configuration (n), unless it is there. What the other functions return holds until the next
  // move.
  void move_to(const Eigen::Ref<const Vector>& q);
  // The same, for hands() alone.
  void move_hands_to(const Eigen::Ref<const Vector>& q);
  // The same, for joints() alone.
  void move_joints_to(const Eigen::Ref<const Vector>& q);

  [[nodiscard]] const Robot& robot() const { return *robot_; }
  [[nodiscard]] const std::shared_ptr<const Robot>& robot_pointer() const { return robot_; }
  // Where the robot was moved to (n).
  [[nodiscard]] const Vector& configuration() const { return q_; }
  // f(q) of eq. 2.1 (3h), m.
  [[nodiscard]] const Vector& hands() const { return hands_; }
  // Where one hand is, m.
  [[nodiscard]] Eigen::Vector3d hand(int h) const { return hands_.segment<3>(3 * h); }
  // From a hand's frame to the base frame.
  [[nodiscard]] const Eigen::Matrix3d& hand_rotation(int h) const {
    return data_.oMf[robot_->hands[static_cast<std::size_t>(h)].frame].rotation();
  }
  // J of eq. 2.2 (3h, n).
  [[nodiscard]] const Matrix& jacobian() const { return jacobian_; }
  // The same for the angular velocity of one hand (3, n).
  [[nodiscard]] Matrix angular_jacobian(int h) const;
  // mu of eq. 3.4.
  [[nodiscard]] double manipulability() const { return manipulability_; }
  // Where a collision body is.
  [[nodiscard]] const pinocchio::SE3& body(int link) const { return bodies_.oMg[static_cast<std::size_t>(link)]; }
  // Where the joints are.
  [[nodiscard]] const auto& joints() const { return data_.oMi; }

  // Adds factor d mu/dq to a gradient with respect to all joints (nv); docs/method.md derives it.
  void add_manipulability_gradient(double factor, Vector& gradient) const;
  // Adds to a gradient (nv) what wrenches, one for each joint's body, at the base's origin, do on the joints: J^T
  // applied to all at once. On return each wrench includes those farther out.
  void add_wrenches(std::vector<pinocchio::Force>& wrenches, Vector& gradient) const;
  // Adds to a gradient (n) factor J^T wrench for a wrench, at the base's origin, on a joint's body. Joints up to and
  // including `from` are left out, 0 leaves out none.
  void add_wrench(const pinocchio::Force& wrench, pinocchio::JointIndex joint, pinocchio::JointIndex from,
                  double factor, Eigen::Ref<Vector> gradient) const;

  // Sets the motion of each joint's body, at the base's origin, for a velocity of all joints (nv).
  void set_motions(const Vector& velocity, std::vector<pinocchio::Motion>& motions) const;

 private:
  using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  struct Arm {
    Columns jacobian;  // Its block in J_arms of eq. 3.4.
    Columns weights;   // d mu is the sum over the arms of <weights, d jacobian>.
    Columns chain;     // The hand's Jacobian with respect to the joints of its chain.
    Eigen::JacobiSVD<Columns> svd;
  };

  void place_joints(const Eigen::Ref<const Vector>& q);
  void place_hands();
  void evaluate_jacobian();
  bool weigh_regular_arms();
  void weigh_any_arms();

  std::shared_ptr<const Robot> robot_;
  pinocchio::Data data_;
  pinocchio::GeometryData bodies_;
  bool is_complete_ = false;  // Whether everything is known where the robot is.
  Vector q_, full_;
  Vector hands_;
  Matrix jacobian_;
  double manipulability_ = 0.0;
  std::vector<Arm> arms_;
};

}  // namespace humanoid_rail
