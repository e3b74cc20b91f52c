#include "library_calls.hpp"

#include <chrono>
#include <stdexcept>

#include <coal/distance.h>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/geometry.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/collision/coal-pinocchio-conversions.hpp>

namespace humanoid_rail {

namespace {

template <class Work>
double seconds(const Matrix& configurations, int repeats, Work work) {
  double checksum = 0.0;
  const auto start = std::chrono::steady_clock::now();
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (Eigen::Index i = 0; i < configurations.rows(); ++i) checksum += work(i);
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  // What is never used may never be computed.
  if (!(checksum == checksum)) throw std::runtime_error("a result that is not a number");
  return taken.count() / static_cast<double>(repeats * configurations.rows());
}

}  // namespace

double library_call_seconds(const Robot& robot, const Obstacles& obstacles, const Matrix& configurations, int repeats) {
  pinocchio::Data data(robot.model);
  pinocchio::GeometryData bodies(robot.bodies);
  const coal::DistanceRequest request;
  const Matrix full = (robot.coupling * configurations.transpose()).colwise() + robot.offset;
  return seconds(configurations, repeats, [&](Eigen::Index i) {
    pinocchio::computeJointJacobians(robot.model, data, full.col(i));
    double checksum = data.J(0, 0);
    for (const Hand& hand : robot.hands) {
      checksum += pinocchio::updateFramePlacement(robot.model, data, hand.frame).translation()[0];
    }
    pinocchio::updateGeometryPlacements(robot.model, data, robot.bodies, bodies);
    for (std::size_t link = 0; link < bodies.oMg.size(); ++link) {
      const auto placement = pinocchio::toCoalTransform3s(bodies.oMg[link]);
      const auto* shape = robot.bodies.geometryObjects[link].geometry.get();
      for (const Obstacles::Piece& piece : obstacles.pieces()) {
        coal::DistanceResult result;
        checksum += coal::distance(shape, placement, piece.shape.get(), piece.placement, request, result);
      }
    }
    return checksum;
  });
}

double velocity_seconds(SafeVelocity& method, const Matrix& configurations, const TaskStack& tasks, const Gains& gains,
                        int repeats) {
  const Matrix columns = configurations.transpose();
  return seconds(configurations, repeats,
                 [&](Eigen::Index i) { return method.projection_velocity(columns.col(i), 0.0, tasks, gains)[0]; });
}

double safe_velocity_seconds(SafeVelocity& method, const Matrix& configurations, const TaskStack& tasks,
                             const Gains& gains, const Safety& safety, double dt, int repeats) {
  const Matrix columns = configurations.transpose();
  return seconds(configurations, repeats,
                 [&](Eigen::Index i) { return method.velocity(columns.col(i), 0.0, tasks, gains, safety, dt)[0]; });
}

}  // namespace humanoid_rail
