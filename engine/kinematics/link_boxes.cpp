#include "link_boxes.hpp"

#include <algorithm>
#include <cmath>

namespace humanoid_rail {

namespace {

// Bounds are taken to be off by this much of what rounding may do, m and m/s.
constexpr double BOX_ROUNDING = 1e-9;

}  // namespace

LinkBoxes::LinkBoxes(std::shared_ptr<const Robot> robot)
    : robot_(std::move(robot)),
      balls_(static_cast<std::size_t>(robot_->links())),
      boxes_(balls_.size()),
      motions_(static_cast<std::size_t>(robot_->model.njoints), pinocchio::Motion::Zero()) {
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    const auto& shape = *robot_->bodies.geometryObjects[i].geometry;
    boxes_[i].half = 0.5 * (shape.aabb_local.max_ - shape.aabb_local.min_);
    balls_[i].radius = shape.aabb_radius;
  }
  const int pairs = static_cast<int>(robot_->self_collision_pairs.size());
  for (int pair = 0; pair < pairs; ++pair) turn_ = turn_ || robot_->takes_long(pair);
}

bool LinkBoxes::move_to(const Kinematics& kinematics) {
  if (q_.size() > 0 && q_ == kinematics.configuration()) return false;
  q_ = kinematics.configuration();
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const auto& body = kinematics.body(static_cast<int>(i));
    balls_[i].middle = body.act(Eigen::Vector3d(robot_->bodies.geometryObjects[i].geometry->aabb_center));
    if (turn_) boxes_[i].axes = body.rotation();
  }
  return true;
}

void LinkBoxes::set_velocity(const Kinematics& kinematics, const Vector& velocity) {
  full_velocity_.noalias() = robot_->coupling * velocity;
  kinematics.set_motions(full_velocity_, motions_);
}

// Two convex bodies are at least as far apart as their shadows on any straight line: here on the sides of both boxes,
// and on the line through their middles.
double LinkBoxes::distance(int link, int other) const {
  const Box &a = box(link), &b = box(other);
  const Eigen::Vector3d between = ball(other).middle - ball(link).middle;
  const double length = between.norm();
  const Eigen::Matrix3d turned = (a.axes.transpose() * b.axes).cwiseAbs();
  const Eigen::Vector3d in_a = (a.axes.transpose() * between).cwiseAbs();
  const Eigen::Vector3d in_b = (b.axes.transpose() * between).cwiseAbs();
  double apart = length - ball(link).radius - ball(other).radius;
  apart = std::max(apart, (in_a - a.half - turned * b.half).maxCoeff());
  apart = std::max(apart, (in_b - b.half - turned.transpose() * a.half).maxCoeff());
  if (length > 0.0) apart = std::max(apart, length - (in_a.dot(a.half) + in_b.dot(b.half)) / length);
  return apart - BOX_ROUNDING;
}

// With the shortest line d n from p_a to p_b, the distance changes by n . v(p_b), where v is the velocity of the other
// link relative to this one: v(p_b) = v(c_b) + w x (p_b - c_b), and p_b is in the ball around c_b. As d n = c_b - c_a +
// e with |e| <= r_a + r_b, the sine of the angle between n and the line through the middles is at most (r_a + r_b) /
// |c_b - c_a|; where the balls overlap n may have any direction. Seen from the other link the same holds for a.
double LinkBoxes::approach(int link, int other) const {
  const Ball &a = ball(link), &b = ball(other);
  const auto relative = motions_[robot_->joint_of(other)] - motions_[robot_->joint_of(link)];
  const Ball& smaller = a.radius < b.radius ? a : b;
  const Eigen::Vector3d velocity = relative.linear() + relative.angular().cross(smaller.middle);
  const double turning = relative.angular().norm() * smaller.radius;
  const Eigen::Vector3d between = b.middle - a.middle;
  const double length = between.norm(), radii = a.radius + b.radius, speed = velocity.norm();
  double straight = speed;
  if (radii < length) {
    const double sine = radii / length, cosine = std::sqrt(1.0 - sine * sine);
    const double along = -velocity.dot(between) / length;
    const double across = std::sqrt(std::max(0.0, speed * speed - along * along));
    if (along < speed * cosine) straight = cosine * along + sine * across;
  }
  return straight + turning + BOX_ROUNDING * (1.0 + speed + turning);
}

}  // namespace humanoid_rail
