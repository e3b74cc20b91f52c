// A motion through samples: linear in q between them, or the cubic spline through positions and velocities.
#pragma once

#include "../types.hpp"

namespace humanoid_rail {

// Refers to its samples, which have to outlive it.
class SampledMotion {
 public:
  using Times = Eigen::Ref<const Vector>;
  using Samples = Eigen::Ref<const Rows>;

  // Times (N), strictly increasing, configurations (N, n) and velocities (N, n), or (0, n) for a motion that is linear.
  SampledMotion(const Times& t, const Samples& q, const Samples& velocity) : t_(t), q_(q), velocity_(velocity) {}

  [[nodiscard]] Eigen::Index size() const { return t_.size(); }
  [[nodiscard]] bool is_spline() const { return velocity_.rows() > 0; }
  [[nodiscard]] double time(Eigen::Index k) const { return t_[k]; }
  [[nodiscard]] Vector configuration(Eigen::Index k) const { return q_.row(k).transpose(); }

  // Time and configuration at a share from 0 to 1 of the edge from sample k to the next.
  [[nodiscard]] double time(Eigen::Index k, double share) const { return t_[k] + share * (t_[k + 1] - t_[k]); }
  [[nodiscard]] Vector configuration(Eigen::Index k, double share) const;
  // How far from 0 each coordinate (n) gets at most.
  [[nodiscard]] Vector farthest() const;
  // How far each coordinate (n) gets at most from the straight line between two shares of the edge from sample k.
  [[nodiscard]] Vector bend(Eigen::Index k, double from, double to) const;

 private:
  // The coefficients (n) of share^2 and share^3.
  [[nodiscard]] Vector quadratic(Eigen::Index k) const;
  [[nodiscard]] Vector cubic(Eigen::Index k) const;
  [[nodiscard]] double duration(Eigen::Index k) const { return t_[k + 1] - t_[k]; }

  Times t_;
  Samples q_;
  Samples velocity_;
};

}  // namespace humanoid_rail
