// Proves a motion free of contact, including between samples, or finds the first contact.
#pragma once

#include <optional>

#include "swept_distance.hpp"

namespace humanoid_rail {

// How far a bound may lie below the smallest clearance found, m.
constexpr double RESOLUTION = 1e-3;
// Coal's distances are precise to this: two bodies that come nearer touch, m.
constexpr double CONTACT = 1e-6;

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
  std::optional<Contact> contact;  // The first one.
};

// Looks at a motion that is linear in q between samples. Not to be shared between threads.
class Certifier {
 public:
  Certifier(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);

  // Times (N), strictly increasing, and configurations (N, n).
  [[nodiscard]] Certificate certify(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q);
  [[nodiscard]] const Robot& robot() const { return swept_.robot(); }

 private:
  class Search;

  SweptDistance swept_;
  std::vector<Nearest> pairs_;
  std::vector<Snapshot> snapshots_;
};

}  // namespace humanoid_rail
