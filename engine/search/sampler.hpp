// Paths between configurations by sampling: found and shortened with the filter of edges, and then proven.
#pragma once

#include <memory>

#include "../collision/edge_checker.hpp"
#include "edge_filter.hpp"
#include "manifold.hpp"
#include "rrt_connect.hpp"

namespace humanoid_rail {

// What a call may spend.
struct SearchEffort {
  long max_checks = 0;        // Of edges, by filter and by proof together.
  double seconds = INFINITE;  // Then it is over.
};

// Of a call.
struct Sampled {
  std::optional<Rows> path;  // (K, n)
  Rows explored;             // Configurations (K, n) to which there seem to be paths from the start.
  long checks = 0;           // Edges that were checked.
};

// A robot among obstacles where they are at t = 0. Holds its workspace. Not to be shared between threads.
class Sampler {
 public:
  // The distances are those of an EdgeChecker. `units` (n) are those in which coordinates are measured. Where there are
  // constraints, paths are polylines between configurations in which these hold.
  Sampler(const std::shared_ptr<const Robot>& robot, const Obstacles& obstacles, double distance, double own_share,
          const Vector& units, std::shared_ptr<const TaskStack> constraints = nullptr);

  // Looks for a path from a configuration (n) to one of some goals (K, n) within a box. It is not proven. Goals that do
  // not keep their distance are left out.
  [[nodiscard]] Sampled connect(const Vector& start, const Rows& goals, const SearchBox& box, double longest,
                                std::uint64_t seed, const SearchEffort& effort);
  // Shortens a path (K, n) and proves it; none if it cannot be proven, or if at a speed of 1 for each coordinate it
  // takes no less than `shorter_than`.
  [[nodiscard]] Sampled shorten(const Rows& path, double shorter_than, std::uint64_t seed, const SearchEffort& effort);
  // Returns the way (K, n) that steps on the constraints take straight from a configuration (n) to another, proven;
  // none if there is none.
  [[nodiscard]] Sampled walk(const Vector& from, const Vector& to);
  [[nodiscard]] const Robot& robot() const { return filter_.robot(); }

 private:
  class Count;
  [[nodiscard]] EdgeTest filter(Count& count);
  [[nodiscard]] Rows shortened(const Rows& points, Random& random, Count& count);
  [[nodiscard]] Vector configuration(const Vector& point) const;
  [[nodiscard]] Rows valid_goals(const Rows& goals);
  [[nodiscard]] Rows configurations(const Rows& points) const;
  [[nodiscard]] std::optional<Rows> proven(const Rows& path, Random& random, Count& count);
  [[nodiscard]] std::optional<Rows> around(const Vector& a, const Vector& b, Random& random, Count& count);

  EdgeFilter filter_;
  EdgeChecker checker_;
  Vector units_;
  std::unique_ptr<Manifold> manifold_;  // None without constraints.
};

}  // namespace humanoid_rail
