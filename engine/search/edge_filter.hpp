// Whether a robot seems to keep its distance from everything on the edge between two configurations. An edge is
// sampled, several configurations at once: far cheaper than a proof (edge_checker.hpp), and none.
#pragma once

#include <unordered_map>
#include <vector>

#include "../collision/swept_distance.hpp"
#include "filter_scene.hpp"

namespace humanoid_rail {

// A robot among obstacles where they are at t = 0. Holds its workspace. Not to be shared between threads.
class EdgeFilter {
 public:
  // The distances are those of an EdgeChecker. What any processor can do is enough if `portable` is true; the same
  // edges seem free.
  EdgeFilter(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance, double own_share,
             bool portable = false);

  // Whether every pair seems to keep its distance at all samples of the edge between two configurations (n); the first
  // one is no sample.
  [[nodiscard]] bool is_edge_free(const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b);
  [[nodiscard]] const Robot& robot() const { return swept_.robot(); }

 private:
  [[nodiscard]] int batches(const Vector& change) const;
  [[nodiscard]] bool is_free(const Undecided& pair, const Eigen::Ref<const Vector>& a, const Vector& change);
  [[nodiscard]] Nearest& known(const Undecided& pair);

  double distance_, own_share_;
  SweptDistance swept_;
  FilterScene scene_;
  FilterKernel kernel_;
  Matrix samples_per_;  // How many samples of each link a coordinate asks for when it changes by 1 (links, n).
  std::vector<float> q_, workspace_;
  std::vector<Undecided> undecided_;
  double shares_[LANES] = {};  // Where the samples are on the edge.
  Snapshot at_[LANES];
  bool placed_[LANES] = {};
  // Of pairs that the kernel could not tell of, as they were last measured: mostly they are still apart in the same
  // direction.
  std::unordered_map<long, Nearest> measured_;
};

}  // namespace humanoid_rail
