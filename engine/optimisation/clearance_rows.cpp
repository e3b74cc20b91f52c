#include "clearance_rows.hpp"

#include <algorithm>
#include <vector>

#include "../interruption.hpp"

namespace humanoid_rail {

ClearanceRows clearance_rows(SceneKinematics& scene, const Eigen::Ref<const Rows>& samples, double distance,
                             double horizon, const Eigen::Ref<const Vector>& reach) {
  const Robot& robot = scene.robot();
  std::vector<int> sample;
  std::vector<double> spares, gradients;
  Observation seen;
  Vector gradient(robot.n());
  ClearanceRows found;
  found.least = Vector::Constant(samples.rows(), INFINITE);
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    Interruption::poll();
    scene.observe(samples.row(i).transpose(), 0.0, horizon, horizon, seen);
    const auto add = [&](const Nearest& pair, double kept) {
      const double spare = pair.distance - kept;
      found.least[i] = std::min(found.least[i], spare);
      scene.distance_gradient(pair, gradient);
      if (spare > gradient.cwiseAbs().dot(reach)) return;
      sample.push_back(static_cast<int>(i));
      spares.push_back(spare);
      gradients.insert(gradients.end(), gradient.data(), gradient.data() + gradient.size());
    };
    for (const Nearest& pair : scene.pieces(seen)) add(pair, distance);
    for (const Nearest& pair : seen.links) add(pair, robot.kept_distance(pair.pair, distance));
  }
  const auto size = static_cast<Eigen::Index>(sample.size());
  found.sample = Eigen::Map<const Eigen::VectorXi>(sample.data(), size);
  found.spare = Eigen::Map<const Vector>(spares.data(), size);
  found.gradient = Eigen::Map<const Rows>(gradients.data(), size, robot.n());
  return found;
}

}  // namespace humanoid_rail
