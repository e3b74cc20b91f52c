// What is true of a robot at one configuration: eq. 2.1, 2.2 and 3.4. Beside humanoid_rail/kinematics.py.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/SVD>
#include <pinocchio/multibody/data.hpp>

#include "robot.hpp"

namespace humanoid_rail {

// A robot at a configuration, with the workspace that takes. Not to be shared between threads.
class Kinematics {
 public:
  explicit Kinematics(std::shared_ptr<const Robot> robot);

  // Moves the robot to a configuration (n). What the other functions return holds until the next move.
  void move_to(const Eigen::Ref<const Vector>& q);
  // The same, for hands() alone.
  void move_hands_to(const Eigen::Ref<const Vector>& q);
  // The same, for joints() alone.
  void move_joints_to(const Eigen::Ref<const Vector>& q);

  const Robot& robot() const { return *robot_; }
  const std::shared_ptr<const Robot>& robot_pointer() const { return robot_; }
  // f(q) of eq. 2.1 (3h), m.
  const Vector& hands() const { return hands_; }
  // J of eq. 2.2 (3h, n).
  const Matrix& jacobian() const { return jacobian_; }
  // mu of eq. 3.4.
  double manipulability() const { return manipulability_; }
  // Where a collision body is.
  const pinocchio::SE3& body(int link) const { return bodies_.oMg[static_cast<std::size_t>(link)]; }
  // Where the joints are.
  const auto& joints() const { return data_.oMi; }

  // Adds factor d mu/dq to a gradient with respect to all joints (nv); see manipulability_gradient in kinematics.py.
  void add_manipulability_gradient(double factor, Vector& gradient) const;
  // Adds to a gradient (nv) what wrenches, one for each joint's body, at the base's origin, do on the joints: J^T
  // applied to all at once. On return each wrench includes those farther out.
  void add_wrenches(std::vector<pinocchio::Force>& wrenches, Vector& gradient) const;
  // Adds to a gradient (n) factor J^T wrench for a wrench, at the base's origin, on a joint's body. Joints up to and
  // including `from` are left out, 0 leaves out none.
  void add_wrench(const pinocchio::Force& wrench, pinocchio::JointIndex joint, pinocchio::JointIndex from,
                  double factor, Eigen::Ref<Vector> gradient) const;

 private:
  using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  struct Arm {
    Columns jacobian;  // Its block in J_arms of eq. 3.4.
    Columns weights;   // d mu is the sum over the arms of <weights, d jacobian>.
    Columns chain;     // The hand's Jacobian with respect to the joints of its chain.
    Eigen::JacobiSVD<Columns> svd;
  };

  void place_hands();
  bool weigh_regular_arms();
  void weigh_any_arms();

  std::shared_ptr<const Robot> robot_;
  pinocchio::Data data_;
  pinocchio::GeometryData bodies_;
  Vector full_;
  Vector hands_;
  Matrix jacobian_;
  double manipulability_ = 0.0;
  std::vector<Arm> arms_;
};

}  // namespace humanoid_rail
