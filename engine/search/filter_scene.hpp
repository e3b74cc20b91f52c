// A robot among obstacles as the filter of edges needs it.
#pragma once

#include <memory>
#include <vector>

#include "../model/robot.hpp"
#include "../scene/obstacles.hpp"
#include "filter_data.hpp"

namespace humanoid_rail {

// Owns what a FilterData refers to. Capsules, spheres, half-spaces and boxes that are obstacles are what they are;
// other shapes are covered by such.
class FilterScene {
 public:
  // The distances are those of an EdgeChecker.
  FilterScene(const Robot& robot, const std::vector<Obstacles::Piece>& pieces, double distance, double own_share);
  FilterScene(const FilterScene&) = delete;
  FilterScene& operator=(const FilterScene&) = delete;

  [[nodiscard]] const FilterData& data() const { return data_; }
  // How thin a body is, m: it moves no farther from one sample to the next.
  [[nodiscard]] double thickness(int link) const { return thickness_[static_cast<std::size_t>(link)]; }
  // How many pairs a kernel may be unable to tell of.
  [[nodiscard]] std::size_t inexact_pairs() const;

 private:
  void add_joints(const Robot& robot);
  void add_bodies(const Robot& robot);
  void add_pieces(const std::vector<Obstacles::Piece>& pieces, double distance);
  void add_pairs(const Robot& robot, double distance, double own_share);

  FilterData data_;
  std::vector<int> joint_of_;           // For each joint of the model, its number here; -1 where it carries nothing.
  std::vector<Eigen::Matrix3d> turns_;  // For each joint of the model, from the frame here to its own.
  std::vector<FilterJoint> joints_;
  std::vector<FilterTerm> terms_;
  std::vector<FilterBody> bodies_;
  std::vector<char> moves_;
  std::vector<double> thickness_;
  std::vector<FilterPiece> pieces_;
  std::vector<float> boxes_[6];
  std::vector<FilterPair> pairs_;
};

}  // namespace humanoid_rail
