// Whether a step of a rollout is free of contact and keeps the safety distance.
#pragma once

#include "../collision/swept_distance.hpp"
#include "qp.hpp"

namespace humanoid_rail {

// A robot among obstacles at the end of a step.
struct Place {
  Observation seen;
  Snapshot snapshot;
};

enum class Step {
  safe,
  free,  // Free of contact, but a pair has come nearer than the safety distance.
  blocked
};

class StepJudge {
 public:
  StepJudge(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double safety_distance);

  // Whether the edge from a to b is free of contact, and at its end no pair is below the safety distance or, where it
  // was below already, nearer.
  [[nodiscard]] Step judge(const Place& a, const Place& b);

 private:
  // What is compared: pairs within a horizon, in the order of their numbers, and how far their bodies get.
  struct Kind {
    const std::vector<Nearest>& before;
    const std::vector<Nearest>& after;
    double horizon;
    const std::vector<Displacement>& moved;
    double drift;  // How far obstacles get meanwhile, m.
  };

  // Returns whether nothing touches; sets whether the safety distance is kept.
  [[nodiscard]] bool keeps_apart(const Kind& kind, const Place& a, const Place& b, bool& is_safe) const;
  // The same of pairs that were not measured. They are where bounds do not tell.
  [[nodiscard]] bool keeps_unmeasured_apart(const Place& a, const Place& b, bool& is_safe);
  [[nodiscard]] bool keeps_pair_apart(int pair, double bound_a, double bound_b, const Place& a, const Place& b,
                                      bool& is_safe);
  // The distance that a pair is to keep, m.
  [[nodiscard]] double kept(const Nearest& pair) const;
  // Whether it is proven of a pair, which was measured at both ends, that it does not touch.
  [[nodiscard]] bool is_proven_apart(const Nearest& here, const Place& a, const Nearest& there, const Place& b,
                                     const Displacement& moved) const;
  [[nodiscard]] Nearest proven(Nearest pair, const Place& at) const;
  [[nodiscard]] double margin_of(const Place& a, const Place& b) const;

  SweptDistance swept_;
  double safety_distance_;
  double fastest_ = 0.0;  // Of the obstacles, m/s.
  EdgeBounds bounds_;
};

}  // namespace humanoid_rail
