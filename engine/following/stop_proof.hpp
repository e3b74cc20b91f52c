// Whether a robot that brakes along a straight line is at rest before anything can touch it;
// humanoid_rail/following/follower.py explains it.
#pragma once

#include <array>
#include <optional>

#include "../collision/swept_distance.hpp"

namespace humanoid_rail {

// Proves stops among obstacles that are moved. Not to be shared between threads.
class StopProof {
 public:
  // The safety distance is in m, the speeds that no point of an obstacle exceeds (one for each) in m/s; where an
  // obstacle is may be known as late as `latency`, s.
  StopProof(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance, Vector speeds,
            double latency);

  // Puts an obstacle elsewhere.
  void place(int obstacle, const coal::Transform3s& placement);
  // Returns a pair of which it is not proven that it keeps apart on the edge from where the scene was observed to a
  // configuration (n), which takes so long, s; nothing if it is proven of all. The scene is observed again where its
  // horizon is too short.
  [[nodiscard]] std::optional<Nearest> unproven(SceneKinematics& scene, const Observation& seen, const Vector& to,
                                                double duration);
  // How far a point of an obstacle may be from where it was known to be a time ago, m.
  [[nodiscard]] double drift(int obstacle, double time) const { return speeds_[obstacle] * (latency_ + time); }
  // What is taken for contact of a pair at rest, m.
  [[nodiscard]] double apart() const { return apart_; }

 private:
  // Halves an edge at most so often.
  static constexpr std::size_t MAX_HALVINGS = 16;

  void set_apart();
  [[nodiscard]] bool keeps(Nearest pair, const Displacement& moved, double drift);
  [[nodiscard]] bool keeps_between(const Nearest& here, const Snapshot& a, const Nearest& there, const Snapshot& b,
                                   const Displacement& moved, double wanted, std::size_t halvings);

  SweptDistance swept_;
  Obstacles obstacles_;
  double distance_;
  Vector speeds_;
  double fastest_;
  double latency_;
  double apart_ = 0.0;
  Observation far_;
  Snapshot from_, to_;
  std::array<Snapshot, MAX_HALVINGS> middles_;
  Vector middle_q_;
  EdgeBounds bounds_;
  std::vector<double> link_distances_;  // Of each pair of links; not less, where it was not measured, m.
};

}  // namespace humanoid_rail
