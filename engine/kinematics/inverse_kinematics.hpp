// Configurations in which tasks are done, clear of everything and within the limits.
//
// Of the errors r = (e(q), d - psi_i(q)), the second for every pair that is nearer than the distance d it has to keep,
// the sum of squares is brought to 0 by the method of Levenberg and Marquardt with a damping that shrinks with what is
// left of it (Sugihara 2011). Steps are the shortest in joint coordinates in units of the speed limits, so that what is
// found is near where the search began. A joint whose step leads beyond a limit is held there.
#pragma once

#include <utility>

#include "scene_kinematics.hpp"
#include "task.hpp"

namespace humanoid_rail {

// A configuration that was found, and how good it is.
struct Posture {
  Vector q;                     // (n), within the limits.
  double error = INFINITE;      // Norm of the tasks' errors, m.
  double clearance = INFINITE;  // The smallest of all pairs nearer than asked for, m; infinite where there are none.
  bool apart = true;            // Whether all pairs keep their distance.
  bool reached = false;         // Whether the tasks are done and all pairs keep their distance.
};

// A robot among obstacles where they are at t = 0. Holds its workspace. Not to be shared between threads.
class InverseKinematics {
 public:
  InverseKinematics(std::shared_ptr<const Robot> robot, const Obstacles& obstacles);

  // Looks, from a configuration (n), for one near it in which the tasks are done and all pairs are at least `distance`
  // apart; if that is minus infinity they are left alone.
  [[nodiscard]] Posture solve(const Eigen::Ref<const Vector>& start, const TaskStack& tasks, double distance);
  // Returns a goal (n) nearer to a start (n), or the same one, by looking again and again from between the two.
  [[nodiscard]] Vector pulled(const Eigen::Ref<const Vector>& goal, const Eigen::Ref<const Vector>& start,
                              const TaskStack& tasks, double distance);
  // The errors of the tasks at a configuration (n), and their Jacobian.
  [[nodiscard]] std::pair<Vector, Matrix> evaluate(const Eigen::Ref<const Vector>& q, const TaskStack& tasks);
  // The errors alone.
  [[nodiscard]] const Vector& errors(const Eigen::Ref<const Vector>& q, const TaskStack& tasks);
  [[nodiscard]] const Robot& robot() const { return scene_.robot(); }

 private:
  [[nodiscard]] double length(const Vector& step) const;
  void keep_apart(const Nearest& pair, double distance, double spare, Posture& here, double& left);
  void keep_all_apart(double distance, Posture& here, double& left);
  void step(double damping, Vector& q);

  SceneKinematics scene_;
  Observation seen_;
  Matrix jacobian_;
  Matrix square_;  // The normal equations: square x = right.
  Vector right_, error_, gradient_, x_, next_;
  Vector scale_;  // Of joints: their speed limits, 1 where there is none, 0 for those that do not move.
};

}  // namespace humanoid_rail
