#include "robot.hpp"

#include <stdexcept>

#include <pinocchio/serialization/geometry.hpp>
#include <pinocchio/serialization/model.hpp>

namespace humanoid_rail {

Robot::Robot(const std::string& model_archive, const std::string& bodies_archive, const Matrix& S, const Vector& s0,
             std::vector<Hand> points)
    : coupling(S.sparseView()), offset(s0), hands(std::move(points)) {
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
  for (auto& body : bodies.geometryObjects) body.geometry->computeLocalAABB();
  for (const auto& supports : model.supports) chains_.emplace_back(supports.begin() + 1, supports.end());
}

}  // namespace humanoid_rail
