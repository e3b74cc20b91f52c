#include "sampled_motion.hpp"

namespace humanoid_rail {

Vector SampledMotion::quadratic(Eigen::Index k) const {
  return (3.0 * (q_.row(k + 1) - q_.row(k)) - duration(k) * (2.0 * velocity_.row(k) + velocity_.row(k + 1)))
      .transpose();
}

Vector SampledMotion::cubic(Eigen::Index k) const {
  return (duration(k) * (velocity_.row(k) + velocity_.row(k + 1)) - 2.0 * (q_.row(k + 1) - q_.row(k))).transpose();
}

Vector SampledMotion::configuration(Eigen::Index k, double share) const {
  if (share == 0.0 || share == 1.0) return configuration(share == 0.0 ? k : k + 1);
  if (!is_spline()) return ((1.0 - share) * q_.row(k) + share * q_.row(k + 1)).transpose();
  const Vector slope = duration(k) * velocity_.row(k).transpose();
  return configuration(k) + share * (slope + share * (quadratic(k) + share * cubic(k)));
}

Vector SampledMotion::farthest() const {
  Vector farthest = q_.cwiseAbs().colwise().maxCoeff().transpose();
  if (!is_spline()) return farthest;
  for (Eigen::Index k = 0; k + 1 < size(); ++k) {
    const Vector ends = q_.row(k).cwiseAbs().cwiseMax(q_.row(k + 1).cwiseAbs()).transpose();
    farthest = farthest.cwiseMax(ends + bend(k, 0.0, 1.0));
  }
  return farthest;
}

// A function is at most max |q''| length^2 / 8 from its chord, and q'' of a cubic is largest at an end.
Vector SampledMotion::bend(Eigen::Index k, double from, double to) const {
  if (!is_spline()) return Vector::Zero(q_.cols());
  const Vector square = 2.0 * quadratic(k), cube = 6.0 * cubic(k);
  const double length = to - from;
  return (square + from * cube).cwiseAbs().cwiseMax((square + to * cube).cwiseAbs()) * (length * length / 8.0);
}

}  // namespace humanoid_rail
