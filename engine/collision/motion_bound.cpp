#include "motion_bound.hpp"

#include <algorithm>
#include <cmath>

#include <coal/shape/geometric_shapes.h>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/multibody/data.hpp>

namespace humanoid_rail {

namespace {

// Axes whose sine is below this are parallel up to rounding.
constexpr double PARALLEL = 1e-9;

// How far the points that decide about distances are from the origin of the joint: of a capsule its axis, because a
// distance from a capsule is one from its axis less the radius.
double extent_of(const pinocchio::GeometryObject& body) {
  if (const auto* capsule = dynamic_cast<const coal::Capsule*>(body.geometry.get())) {
    const Eigen::Vector3d half = capsule->halfLength * body.placement.rotation().col(2);
    const Eigen::Vector3d& middle = body.placement.translation();
    return std::max((middle + half).norm(), (middle - half).norm());
  }
  const Eigen::Vector3d middle = body.placement.act(Eigen::Vector3d(body.geometry->aabb_center));
  return middle.norm() + body.geometry->aabb_radius;
}

}  // namespace

MotionBound::MotionBound(const Robot& robot) {
  const auto& model = robot.model;
  pinocchio::Data data(model);
  pinocchio::computeJointJacobians(model, data, pinocchio::neutral(model));
  // The axis about which each body turned last: where two are parallel in one configuration they are in all.
  std::vector<Eigen::Vector3d> axes(static_cast<std::size_t>(model.njoints), Eigen::Vector3d::Zero());
  joints_.push_back({});
  for (pinocchio::JointIndex j = 1; j < static_cast<pinocchio::JointIndex>(model.njoints); ++j) {
    const auto parent = model.parents[j];
    const auto v = model.joints[j].idx_v();
    const Eigen::Vector3d axis = data.J.col(v).tail<3>();
    const bool slides = axis.isZero(PARALLEL);
    const bool parallel = !slides && axis.cross(axes[parent]).norm() < PARALLEL && !axes[parent].isZero(0.0);
    joints_.push_back({parent, v, slides, model.jointPlacements[j].translation().norm(),
                       parallel ? std::copysign(1.0, axis.dot(axes[parent])) : 0.0});
    axes[j] = slides ? axes[parent] : axis;
  }
  for (int link = 0; link < robot.links(); ++link) {
    joint_of_.push_back(robot.joint_of(link));
    const auto& body = robot.bodies.geometryObjects[static_cast<std::size_t>(link)];
    extent_.push_back(extent_of(body));
    thickest_ = std::max(thickest_, body.geometry->aabb_radius);
  }
  motions_.resize(joints_.size());
  list_carried();
}

// Lists what the body of each joint carries.
void MotionBound::list_carried() {
  for (std::size_t from = 0; from < joints_.size(); ++from) {
    std::vector<char> carried(joints_.size(), char{0});
    carried[from] = 1;
    auto& joints = joints_on_.emplace_back();
    for (auto j = from + 1; j < joints_.size(); ++j) {
      carried[j] = carried[joints_[j].parent];
      if (carried[j]) joints.push_back(j);
    }
    auto& links = links_on_.emplace_back();
    for (std::size_t link = 0; link < joint_of_.size(); ++link) {
      if (carried[joint_of_[link]]) links.push_back(link);
    }
  }
}

void MotionBound::displacements(const Vector& change, const Vector& slide, pinocchio::JointIndex from,
                                std::vector<Displacement>& links) {
  motions_[from] = {};
  for (const std::size_t j : joints_on_[from]) {
    const Joint& joint = joints_[j];
    const Motion& before = motions_[joint.parent];
    Motion& motion = motions_[j];
    const double rate = change[joint.v];
    const double bend = before.twist + before.turn * before.turn;
    if (joint.slides) {
      // x = x' + R (c + a q): x_dot = .. + w x R (c + a q) + R a q_dot, and the Coriolis term 2 w x R a q_dot.
      const double offset = joint.offset + slide[joint.v];
      motion = before;
      motion.length += before.turn * offset + std::abs(rate);
      motion.curvature += bend * offset + 2.0 * before.turn * std::abs(rate);
      continue;
    }
    motion.length = before.length + before.turn * joint.offset;
    motion.curvature = before.curvature + bend * joint.offset;
    // Turns about parallel axes add up with their signs; |w| is at most the sum of what is not parallel, and
    // |w_dot| = |sum of w_r x w_s| at most the sum of the products.
    const bool goes_on = joint.parallel != 0.0;
    motion.turn_before = goes_on ? before.turn_before : before.turn;
    motion.twist_before = goes_on ? before.twist_before : before.twist;
    motion.run = joint.parallel * before.run + rate;
    motion.turn = motion.turn_before + std::abs(motion.run);
    motion.twist = motion.twist_before + motion.turn_before * std::abs(motion.run);
  }
  for (const std::size_t link : links_on_[from]) {
    const Motion& motion = motions_[joint_of_[link]];
    links[link] = {motion.length + motion.turn * extent_[link],
                   motion.curvature + (motion.twist + motion.turn * motion.turn) * extent_[link]};
  }
}

double MotionBound::size(const Vector& slide) const {
  std::vector<double> reach(joints_.size(), 0.0);  // How far the origins of the joints get from the base.
  double turn = 1.0;
  for (std::size_t j = 1; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    reach[j] = reach[joint.parent] + joint.offset + (joint.slides ? slide[joint.v] : 0.0);
    if (!joint.slides) turn += slide[joint.v];
  }
  double largest = 0.0;
  for (std::size_t link = 0; link < extent_.size(); ++link) {
    largest = std::max(largest, reach[joint_of_[link]] + extent_[link]);
  }
  return turn * (largest + thickest_);
}

}  // namespace humanoid_rail
