#include "filter_scene.hpp"

#include <algorithm>
#include <cmath>

#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>
#include <pinocchio/multibody/joint/joint-generic.hpp>

namespace humanoid_rail {

namespace {

// Distances are asked for with this much less, so that no rounding blocks what just keeps its distance, m.
constexpr double FILTER_ROUNDING = 1e-5;
// Boxes that fill up the last lanes lie here, m.
constexpr float NOWHERE = 1e30F;

template <class From>
void store(const From& from, float* to) {
  for (Eigen::Index row = 0; row < from.rows(); ++row) {
    for (Eigen::Index column = 0; column < from.cols(); ++column) *to++ = static_cast<float>(from(row, column));
  }
}

// All points of a shape are within a radius of a straight piece, which is given by its middle and half of it.
struct Cover {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), half = Eigen::Vector3d::Zero();
  double radius = 0.0;
  bool exact = false;
};

const std::vector<coal::Vec3s>* vertices(const coal::CollisionGeometry& shape) {
  if (shape.getNodeType() != coal::GEOM_CONVEX) return nullptr;
  return static_cast<const coal::ConvexBase&>(shape).points.get();
}

// Along the longest side of the box around a shape.
Cover cover(const coal::CollisionGeometry& shape) {
  if (shape.getNodeType() == coal::GEOM_CAPSULE) {
    const auto& capsule = static_cast<const coal::Capsule&>(shape);
    return {Eigen::Vector3d::Zero(), capsule.halfLength * Eigen::Vector3d::UnitZ(), capsule.radius, true};
  }
  if (shape.getNodeType() == coal::GEOM_SPHERE) {
    return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), static_cast<const coal::Sphere&>(shape).radius, true};
  }
  const Eigen::Vector3d middle = shape.aabb_local.center();
  const Eigen::Vector3d half = 0.5 * (shape.aabb_local.max_ - shape.aabb_local.min_);
  Eigen::Index longest = 0;
  half.maxCoeff(&longest);
  Eigen::Vector3d across = half;
  across[longest] = 0.0;
  const auto* points = vertices(shape);
  if (points == nullptr) return {middle, half[longest] * Eigen::Vector3d::Unit(longest), across.norm(), false};
  double radius = 0.0, length = 0.0;
  const auto from_axis = [&](const Eigen::Vector3d& point) {
    Eigen::Vector3d away = point - middle;
    away[longest] = 0.0;
    return away.norm();
  };
  for (const auto& point : *points) radius = std::max(radius, from_axis(point));
  for (const auto& point : *points) {
    const double sideways = from_axis(point);
    const double covered = std::sqrt(std::max(0.0, radius * radius - sideways * sideways));
    length = std::max(length, std::abs(point[longest] - middle[longest]) - covered);
  }
  const auto& convex = static_cast<const coal::ShapeBase&>(shape);
  return {middle, length * Eigen::Vector3d::Unit(longest), radius + convex.getSweptSphereRadius(), false};
}

// A turn of the z axis to a direction.
Eigen::Matrix3d turn_to(const Eigen::Vector3d& direction) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction).toRotationMatrix();
}

}  // namespace

FilterScene::FilterScene(const Robot& robot, const std::vector<Obstacles::Piece>& pieces, double distance,
                         double own_share) {
  add_joints(robot);
  add_bodies(robot);
  add_pieces(pieces, distance);
  add_pairs(robot, distance, own_share);
  data_.n = robot.n();
  data_.joints = static_cast<int>(joints_.size());
  data_.bodies = static_cast<int>(bodies_.size());
  data_.pieces = static_cast<int>(pieces_.size());
  data_.pairs = static_cast<int>(pairs_.size());
  data_.distance = static_cast<float>(distance - FILTER_ROUNDING);
  data_.joint = joints_.data();
  data_.term = terms_.data();
  data_.body = bodies_.data();
  data_.moves = moves_.data();
  data_.piece = pieces_.data();
  for (int side = 0; side < 6; ++side) data_.boxes[side] = boxes_[side].data();
  data_.pair = pairs_.data();
}

std::size_t FilterScene::inexact_pairs() const {
  const auto is_inexact = [](const auto& shape) { return !shape.exact; };
  const auto bodies = static_cast<std::size_t>(std::count_if(bodies_.begin(), bodies_.end(), is_inexact));
  const auto pieces = static_cast<std::size_t>(std::count_if(pieces_.begin(), pieces_.end(), is_inexact));
  return bodies * pieces_.size() + (bodies_.size() - bodies) * pieces + pairs_.size();
}

void FilterScene::add_joints(const Robot& robot) {
  const auto& model = robot.model;
  std::vector<char> carries(static_cast<std::size_t>(model.njoints), char{0});
  for (int link = 0; link < robot.links(); ++link) {
    for (const auto joint : robot.chain_to(robot.joint_of(link))) carries[joint] = 1;
  }
  joint_of_.assign(static_cast<std::size_t>(model.njoints), -1);
  turns_.assign(static_cast<std::size_t>(model.njoints), Eigen::Matrix3d::Identity());
  joints_.push_back({});
  joint_of_[0] = 0;
  for (pinocchio::JointIndex j = 1; j < static_cast<pinocchio::JointIndex>(model.njoints); ++j) {
    if (!carries[j]) continue;
    auto state = model.joints[j].createData();
    model.joints[j].calc(state, Vector::Zero(model.nq));
    const Eigen::Matrix<double, 6, 1> axis = state.S().matrix();
    FilterJoint joint;
    joint.slides = axis.tail<3>().isZero();
    turns_[j] = turn_to(joint.slides ? axis.head<3>() : axis.tail<3>());
    const auto parent = model.parents[j];
    const Eigen::Matrix3d into = turns_[parent].transpose();
    joint.parent = joint_of_[parent];
    store(Eigen::Matrix3d(into * model.jointPlacements[j].rotation() * turns_[j]), joint.rotation);
    store(Eigen::Vector3d(into * model.jointPlacements[j].translation()), joint.translation);
    const auto v = model.joints[j].idx_v();
    joint.offset = static_cast<float>(robot.offset[v]);
    joint.first_term = static_cast<int>(terms_.size());
    for (Coupling::InnerIterator S(robot.coupling, v); S; ++S) {
      terms_.push_back({static_cast<int>(S.col()), static_cast<float>(S.value())});
    }
    joint.end_term = static_cast<int>(terms_.size());
    joint_of_[j] = static_cast<int>(joints_.size());
    joints_.push_back(joint);
  }
}

void FilterScene::add_bodies(const Robot& robot) {
  for (int link = 0; link < robot.links(); ++link) {
    const auto& geometry = robot.bodies.geometryObjects[static_cast<std::size_t>(link)];
    const Cover around = cover(*geometry.geometry);
    const Eigen::Matrix3d into = turns_[geometry.parentJoint].transpose();
    const auto placed = [&](const Eigen::Vector3d& point) -> Eigen::Vector3d {
      return into * geometry.placement.act(point);
    };
    FilterBody body;
    body.joint = joint_of_[geometry.parentJoint];
    store(placed(around.middle - around.half), body.from);
    store(placed(around.middle + around.half), body.to);
    body.half_length = static_cast<float>(around.half.norm());
    body.radius = static_cast<float>(around.radius);
    body.exact = around.exact;
    bodies_.push_back(body);
    moves_.push_back(robot.moves(link) ? 1 : 0);
    const coal::AABB& box = geometry.geometry->aabb_local;
    thickness_.push_back((box.max_ - box.min_).minCoeff());
  }
}

void FilterScene::add_pieces(const std::vector<Obstacles::Piece>& pieces, double distance) {
  for (const auto& given : pieces) {
    FilterPiece piece;
    const Eigen::Matrix3d& rotation = given.placement.getRotation();
    Eigen::Vector3d middle = Eigen::Vector3d::Zero(), reach;
    if (given.shape->getNodeType() == coal::GEOM_HALFSPACE) {
      const auto& plane = static_cast<const coal::Halfspace&>(*given.shape);
      const Eigen::Vector3d normal = rotation * plane.n;
      piece.shape = FilterShape::PLANE;
      piece.exact = true;
      store(normal, piece.axis);
      piece.radius = static_cast<float>(plane.d + normal.dot(given.placement.getTranslation()));
      reach.setConstant(NOWHERE);
    } else if (const Cover around = cover(*given.shape); around.exact) {
      middle = given.placement.transform(around.middle);
      const Eigen::Vector3d half = rotation * around.half;
      piece.exact = true;
      store(middle, piece.middle);
      store(half, piece.axis);
      piece.radius = static_cast<float>(around.radius);
      reach = half.cwiseAbs().array() + around.radius;
    } else {
      const coal::AABB& box = given.shape->aabb_local;
      const Eigen::Vector3d half = 0.5 * (box.max_ - box.min_);
      middle = given.placement.transform(Eigen::Vector3d(box.center()));
      piece.shape = FilterShape::BOX;
      piece.exact = given.shape->getNodeType() == coal::GEOM_BOX;
      store(middle, piece.middle);
      store(rotation, piece.rotation);
      store(half, piece.half);
      reach = rotation.cwiseAbs() * half;
    }
    pieces_.push_back(piece);
    for (int axis = 0; axis < 3; ++axis) {
      boxes_[axis].push_back(static_cast<float>(middle[axis] - reach[axis] - distance));
      boxes_[3 + axis].push_back(static_cast<float>(middle[axis] + reach[axis] + distance));
    }
  }
  while (boxes_[0].size() % LANES != 0) {
    for (int side = 0; side < 6; ++side) boxes_[side].push_back(side < 3 ? NOWHERE : -NOWHERE);
  }
}

void FilterScene::add_pairs(const Robot& robot, double distance, double own_share) {
  for (std::size_t i = 0; i < robot.self_collision_pairs.size(); ++i) {
    const auto& [link, other] = robot.self_collision_pairs[i];
    const double kept = robot.kept_distance(static_cast<int>(i), distance, own_share);
    pairs_.push_back({link, other, static_cast<float>(kept - FILTER_ROUNDING)});
  }
}

}  // namespace humanoid_rail
