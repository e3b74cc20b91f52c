// Proves a motion free of contact, including between samples, or finds the first contact.
#pragma once

#include <optional>

#include "margin.hpp"
#include "sampled_motion.hpp"
#include "swept_distance.hpp"

namespace humanoid_rail {

// How far a bound may lie below the smallest clearance found, m.
constexpr double RESOLUTION = 1e-3;
// The same of splines, m: of motions with other timings of one path the bounds tell which keeps clear of more.
constexpr double SPLINE_RESOLUTION = 1e-4;
// A proof measures distances at most this often, unless it is told otherwise.
constexpr long MAX_CHECKS = 2'000'000;

struct Contact {
  double t = 0.0;  // s
  int link = -1;
  int other = -1;  // The obstacle, or the other link.
  bool with_obstacle = false;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // m
};

struct Certificate {
  bool certified = false;
  // Smallest clearances found, at the samples and wherever else was looked, m; infinite where there is nothing to
  // touch.
  double min_obstacles = INFINITE, min_links = INFINITE;
  double bound = INFINITE;         // No clearance is smaller at any time, m.
  double others_bound = INFINITE;  // The same without pairs of links with a distance of their own, m.
  std::optional<Contact> contact;  // The first one.
  std::optional<double> stopped;   // Where the budget of checks was used up nothing is proven from this time on, s.
};

// Looks at a motion between its samples too. Not to be shared between threads.
class Certifier {
 public:
  Certifier(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);

  // Measures distances at most so many times.
  [[nodiscard]] Certificate certify(const SampledMotion& motion, long max_checks = MAX_CHECKS);
  [[nodiscard]] const Robot& robot() const { return swept_.robot(); }

 private:
  class Search;

  SweptDistance swept_;
  std::vector<Nearest> pairs_;
  std::vector<Snapshot> snapshots_;
};

}  // namespace humanoid_rail
