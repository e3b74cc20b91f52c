#include "robot.hpp"

#include <stdexcept>

#include <pinocchio/serialization/geometry.hpp>
#include <pinocchio/serialization/model.hpp>

namespace humanoid_rail {

Robot::Robot(const std::string& model_archive, const std::string& bodies_archive, const Matrix& S, const Vector& s0,
             std::vector<Hand> points, std::vector<std::pair<int, int>> pairs, Vector distances, Limits joint_limits)
    : coupling(S.sparseView()),
      offset(s0),
      hands(std::move(points)),
      self_collision_pairs(std::move(pairs)),
      pair_distances(std::move(distances)),
      limits(std::move(joint_limits)) {
  model.loadFromString(model_archive);
  bodies.loadFromString(bodies_archive);
  if (S.rows() != model.nv || s0.size() != model.nq || model.nq != model.nv || model.nv != model.njoints - 1) {
    throw std::invalid_argument("the coupling needs a row for each joint, and each joint one degree of freedom");
  }
  for (const Hand& hand : hands) {
    if (hand.frame >= model.frames.size()) throw std::invalid_argument("a hand needs a frame of the model");
    if (hand.arm.size() < 3) throw std::invalid_argument("an arm needs three joints or more");
    for (int column : hand.arm) {
      if (column < 0 || column >= S.cols()) throw std::invalid_argument("an arm needs columns of q");
    }
  }
  for (const auto& [link, other] : self_collision_pairs) {
    if (std::min(link, other) < 0 || std::max(link, other) >= links()) {
      throw std::invalid_argument("a pair needs two collision bodies");
    }
  }
  if (pair_distances.size() != static_cast<Eigen::Index>(self_collision_pairs.size()) ||
      !(pair_distances.array() >= 0.0).all()) {
    throw std::invalid_argument("each pair needs a distance of 0 or more");
  }
  for (const Vector* limit : {&limits.lower, &limits.upper, &limits.velocity}) {
    if (limit->size() != S.cols()) throw std::invalid_argument("limits need a number for each actuated joint");
  }
  for (auto& body : bodies.geometryObjects) body.geometry->computeLocalAABB();
  for (const auto& supports : model.supports) chains_.emplace_back(supports.begin() + 1, supports.end());
  for (int link = 0; link < links(); ++link) moves_.push_back(is_moved(link) ? 1 : 0);
  for (const auto& [link, other] : self_collision_pairs) {
    common_joints_.push_back(common_joint(link, other));
    takes_long_.push_back(!(is_round(link) && is_round(other)));
  }
}

bool Robot::is_moved(int link) const {
  const auto& chain = chain_to(joint_of(link));
  return std::any_of(chain.begin(), chain.end(), [this](pinocchio::JointIndex joint) {
    return coupling.row(model.joints[joint].idx_v()).nonZeros() > 0;
  });
}

bool Robot::is_round(int link) const {
  const auto kind = bodies.geometryObjects[static_cast<std::size_t>(link)].geometry->getNodeType();
  return kind == coal::GEOM_CAPSULE || kind == coal::GEOM_SPHERE;
}

pinocchio::JointIndex Robot::common_joint(int link, int other) const {
  const auto& a = chain_to(joint_of(link));
  const auto& b = chain_to(joint_of(other));
  pinocchio::JointIndex common = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()) && a[i] == b[i]; ++i) common = a[i];
  return common;
}

}  // namespace humanoid_rail
