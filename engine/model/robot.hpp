// A robot as frozen data: Pinocchio model, linear coupling, collision bodies and hands.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <Eigen/SparseCore>
#include <pinocchio/multibody/geometry.hpp>
#include <pinocchio/multibody/model.hpp>

#include "../types.hpp"

namespace humanoid_rail {

using Coupling = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// A point of the robot that is given targets.
struct Hand {
  pinocchio::FrameIndex frame = 0;
  std::vector<int> arm;  // Columns in q of the joints of its arm.
};

// What the actuated joints (n) can do.
struct Limits {
  Vector lower, upper;  // m or rad.
  Vector velocity;      // m/s or rad/s.
};

// A robot whose joints follow its n actuated ones linearly: q_full = S q + s0. Every joint has one degree of freedom.
struct Robot {
  // The model and the collision bodies come as Pinocchio's own text archives. Throws std::invalid_argument.
  Robot(const std::string& model, const std::string& bodies, const Matrix& coupling, const Vector& offset,
        std::vector<Hand> hands, std::vector<std::pair<int, int>> self_collision_pairs, Vector pair_distances,
        Limits limits);

  pinocchio::Model model;
  pinocchio::GeometryModel bodies;
  Coupling coupling;  // S: a row for each joint of the model.
  Vector offset;      // s0
  std::vector<Hand> hands;
  std::vector<std::pair<int, int>> self_collision_pairs;  // Collision bodies that may collide.
  Vector pair_distances;  // How far apart each of these is kept at the most, m; infinite where nothing is said of it.
  Limits limits;

  // The joint that carries a collision body.
  [[nodiscard]] pinocchio::JointIndex joint_of(int link) const {
    return bodies.geometryObjects[static_cast<std::size_t>(link)].parentJoint;
  }
  // The joints that move a hand, from the base outwards.
  [[nodiscard]] const std::vector<pinocchio::JointIndex>& chain_of(const Hand& hand) const {
    return chain_to(model.frames[hand.frame].parentJoint);
  }
  // The joints that move the body of a joint, from the base outwards, itself the last.
  [[nodiscard]] const std::vector<pinocchio::JointIndex>& chain_to(pinocchio::JointIndex joint) const {
    return chains_[joint];
  }
  // For each self-collision pair the outermost joint that moves both bodies alike; 0, the base, where there is none.
  [[nodiscard]] const std::vector<pinocchio::JointIndex>& common_joints() const { return common_joints_; }
  // How far apart a self-collision pair is kept where a distance in m is to be kept from everything, and of a distance
  // of its own this share.
  [[nodiscard]] double kept_distance(int pair, double distance, double own_share = 1.0) const {
    return std::min(distance, own_share * pair_distances[pair]);
  }
  // Whether measuring a self-collision pair takes long: its distance has no closed form.
  [[nodiscard]] bool takes_long(int pair) const { return takes_long_[static_cast<std::size_t>(pair)] != 0; }
  // Whether any actuated joint moves a collision body.
  [[nodiscard]] bool moves(int link) const { return moves_[static_cast<std::size_t>(link)] != 0; }
  // q_full = S q + s0 of the actuated joints' q (n).
  [[nodiscard]] Vector full_configuration(const Eigen::Ref<const Vector>& q) const { return offset + coupling * q; }
  [[nodiscard]] int n() const { return static_cast<int>(coupling.cols()); }
  [[nodiscard]] int rows() const { return 3 * static_cast<int>(hands.size()); }
  [[nodiscard]] int links() const { return static_cast<int>(bodies.ngeoms); }

 private:
  [[nodiscard]] bool is_round(int link) const;
  [[nodiscard]] bool is_moved(int link) const;
  [[nodiscard]] pinocchio::JointIndex common_joint(int link, int other) const;

  std::vector<std::vector<pinocchio::JointIndex>> chains_;
  std::vector<pinocchio::JointIndex> common_joints_;
  std::vector<char> takes_long_, moves_;
};

}  // namespace humanoid_rail
