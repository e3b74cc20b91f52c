// Proves a motion free of contact, or finds the first one. Beside humanoid_rail/certificate.py.
#pragma once

#include <optional>

#include "sweep.hpp"

namespace humanoid_rail {

struct Contact {
  double t;  // s
  int link;
  int other;  // The obstacle, or the other link.
  bool with_obstacle;
  Eigen::Vector3d point;  // m
};

struct Certificate {
  bool certified = false;
  // Smallest clearances found, at the samples and wherever else was looked, m; infinite where there is nothing to touch.
  double min_obstacles = INFINITE, min_links = INFINITE;
  double bound = INFINITE;  // No clearance is smaller at any time, m.
  std::optional<Contact> contact;  // The first one.
};

// Looks at a motion that is linear in q between samples. Not to be shared between threads.
class Certifier {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  Certifier(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);
  Certifier(const Certifier&) = delete;  // The sweep refers to the pieces here.
  Certifier& operator=(const Certifier&) = delete;

  // Times (N), ever later, and configurations (N, n).
  Certificate certify(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q);
  const Robot& robot() const { return *robot_; }

 private:
  class Search;

  std::shared_ptr<const Robot> robot_;
  std::vector<Obstacles::Piece> pieces_;
  Kinematics kinematics_;
  Sweep sweep_;
  DistanceMeter meter_;
  std::vector<Snapshot> snapshots_;
};

}  // namespace humanoid_rail
