#include "evaluation.hpp"

#include <algorithm>

namespace humanoid_rail {

namespace {

void add_hands(const Kinematics& kinematics, State& state) {
  const Robot& robot = kinematics.robot();
  state.hands = kinematics.hands();
  state.jacobian = kinematics.jacobian();
  state.rotations.resize(robot.rows(), 3);
  state.angular_jacobian.resize(robot.rows(), robot.n());
  for (int h = 0; h < static_cast<int>(robot.hands.size()); ++h) {
    state.rotations.middleRows<3>(3 * h) = kinematics.hand_rotation(h);
    state.angular_jacobian.middleRows<3>(3 * h) = kinematics.angular_jacobian(h);
  }
  Vector gradient = Vector::Zero(robot.model.nv);
  kinematics.add_manipulability_gradient(1.0, gradient);
  state.manipulability = kinematics.manipulability();
  state.manipulability_gradient = robot.coupling.transpose() * gradient;
}

// Distances of links (L) from obstacles (O), infinite where a pair is not listed.
Rows table(const std::vector<Nearest>& pairs, const SceneKinematics& scene) {
  Rows clearance = Rows::Constant(scene.robot().links(), scene.obstacles().size(), INFINITE);
  for (const Nearest& pair : pairs) clearance(pair.link, pair.other) = pair.distance;
  return clearance;
}

}  // namespace

State state(SceneKinematics& scene, const Eigen::Ref<const Vector>& q, double t) {
  Observation seen;
  scene.observe(q, t, INFINITE, INFINITE, seen);
  const Robot& robot = scene.robot();
  State result;
  add_hands(scene.kinematics(), result);
  Vector gradient(robot.n());
  const auto gradient_of = [&](const Nearest& pair) {
    scene.distance_gradient(pair, gradient);
    return gradient.transpose();
  };
  const int obstacles = scene.obstacles().size();
  result.clearance = table(seen.near.obstacles, scene);
  result.clearance_gradient = Rows::Zero(robot.links() * obstacles, robot.n());
  for (const Nearest& pair : seen.near.obstacles) {
    result.clearance_gradient.row(pair.link * obstacles + pair.other) = gradient_of(pair);
  }
  const auto pieces = static_cast<Eigen::Index>(scene.obstacles().pieces().size());
  result.piece_distance = Rows::Constant(robot.links(), pieces, INFINITE);
  result.piece_rate = Rows::Zero(robot.links(), pieces);
  result.piece_gradient = Rows::Zero(robot.links() * pieces, robot.n());
  for (const Nearest& pair : scene.pieces(seen)) {
    result.piece_distance(pair.link, pair.piece) = pair.distance;
    result.piece_rate(pair.link, pair.piece) = pair.rate;
    result.piece_gradient.row(pair.pair) = gradient_of(pair);
  }
  result.link_distance.resize(static_cast<Eigen::Index>(seen.links.size()));
  result.link_gradient.resize(result.link_distance.size(), robot.n());
  for (const Nearest& pair : seen.links) {
    result.link_distance[pair.pair] = pair.distance;
    result.link_gradient.row(pair.pair) = gradient_of(pair);
  }
  return result;
}

Measurement measure(SceneKinematics& scene, const Eigen::Ref<const Vector>& q, double t, double horizon) {
  Observation links, seen;
  scene.observe(q, t, -INFINITE, INFINITE, links);
  scene.observe_nearest(q, t, horizon, seen);
  const Kinematics& kinematics = scene.kinematics();
  Measurement result{kinematics.hands(), kinematics.manipulability(), table(seen.near.obstacles, scene), {}};
  result.link_distance.resize(static_cast<Eigen::Index>(links.links.size()));
  for (const Nearest& pair : links.links) result.link_distance[pair.pair] = pair.distance;
  return result;
}

Course along(SceneKinematics& scene, const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& motion,
             double horizon) {
  const Kinematics& kinematics = scene.kinematics();
  Course result{Rows(motion.rows(), kinematics.robot().rows()), Vector(motion.rows()),
                Rows(motion.rows(), scene.obstacles().size())};
  Observation seen;
  Vector q(motion.cols());
  for (Eigen::Index i = 0; i < motion.rows(); ++i) {
    q = motion.row(i);
    scene.observe_nearest(q, t[i], horizon, seen);
    result.hands.row(i) = kinematics.hands();
    result.manipulability[i] = kinematics.manipulability();
    // Row by row: filling all of a long motion's at once would keep an interruption waiting.
    result.clearance.row(i).setConstant(INFINITE);
    for (const Nearest& pair : seen.near.obstacles) {
      result.clearance(i, pair.other) = std::min(result.clearance(i, pair.other), pair.distance);
    }
  }
  return result;
}

}  // namespace humanoid_rail
