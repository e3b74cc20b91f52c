#include "sampler.hpp"

#include <chrono>
#include <limits>
#include <stdexcept>

#include "../interruption.hpp"
#include "shortcuts.hpp"

namespace humanoid_rail {

namespace {

// An edge that cannot be proven is replaced by a path that may check this many edges.
constexpr long REPAIR_CHECKS = 60;
// Such a path goes no farther beyond the edge's ends than this share of its length, ...
constexpr double REPAIR_MARGIN = 0.5;
// ... by edges of this share of it.
constexpr double REPAIR_STEP = 0.5;
// So many steps on constraints count as the check of one edge.
constexpr int STEPS_A_CHECK = 8;
// The clock is looked at once in so many edges.
constexpr long CLOCK = 32;

}  // namespace

// Counts the edges that are checked, and ends the work where they are too many or it takes too long.
class Sampler::Count {
 public:
  explicit Count(const SearchEffort& effort)
      : effort_(effort), until_(std::chrono::steady_clock::now() + seconds(std::min(effort.seconds, FOREVER))) {}

  void add() {
    if (++checks_ % CLOCK == 0) late_ = std::chrono::steady_clock::now() > until_;
  }
  [[nodiscard]] bool is_over() const { return late_ || checks_ >= effort_.max_checks; }
  [[nodiscard]] long checks() const { return checks_; }

 private:
  static constexpr double FOREVER = 1e8;  // s

  static std::chrono::nanoseconds seconds(double given) {
    return std::chrono::nanoseconds(static_cast<std::chrono::nanoseconds::rep>(1e9 * std::max(0.0, given)));
  }

  SearchEffort effort_;
  std::chrono::steady_clock::time_point until_;
  long checks_ = 0;
  bool late_ = false;
};

Sampler::Sampler(const std::shared_ptr<const Robot>& robot, const Obstacles& obstacles, double distance,
                 double own_share, const Vector& units, std::shared_ptr<const TaskStack> constraints)
    : filter_(robot, obstacles, distance, own_share),
      checker_(robot, obstacles, distance, own_share),
      units_(units),
      manifold_(constraints ? std::make_unique<Manifold>(robot, std::move(constraints), units) : nullptr) {}

// An edge that seems to be free; on constraints edges are steps, of which several count as one.
EdgeTest Sampler::filter(Count& count) {
  return [&, steps = 0](const Vector& a, const Vector& b) mutable {
    if (!manifold_ || steps++ % STEPS_A_CHECK == 0) count.add();
    return filter_.is_edge_free(configuration(a), configuration(b));
  };
}

// Scaling there and back may lead over a limit, by rounding.
Vector Sampler::configuration(const Vector& point) const {
  const Limits& limits = robot().limits;
  return point.cwiseProduct(units_).cwiseMin(limits.upper).cwiseMax(limits.lower);
}

Rows Sampler::valid_goals(const Rows& goals) {
  Rows valid(goals.rows(), goals.cols());
  Eigen::Index count = 0;
  for (const auto& goal : goals.rowwise()) {
    if (checker_.is_valid(goal.transpose())) valid.row(count++) = goal;
  }
  return valid.topRows(count);
}

Rows Sampler::configurations(const Rows& points) const {
  Rows q(points.rows(), points.cols());
  for (Eigen::Index i = 0; i < q.rows(); ++i) q.row(i) = configuration(points.row(i).transpose()).transpose();
  return q;
}

Sampled Sampler::connect(const Vector& start, const Rows& goals, const SearchBox& box, double longest,
                         std::uint64_t seed, const SearchEffort& effort) {
  Count count(effort);
  Random random(seed);
  const EdgeTest is_free = filter(count);
  const Steer steer =
      !manifold_ ? straight(is_free) : [&](const Vector& from, const Vector& to, double most, bool& arrived) {
        return manifold_->walk(from, to, most, arrived, is_free);
      };
  const Rows valid = valid_goals(goals);
  if (valid.rows() == 0) return {};
  const SearchBox scaled{box.lower.cwiseQuotient(units_), box.upper.cwiseQuotient(units_)};
  Growth growth = rrt_connect(start.cwiseQuotient(units_), valid * units_.cwiseInverse().asDiagonal(), scaled, longest,
                              random, steer, [&] { return count.is_over(); });
  Sampled found;
  if (growth.path) {
    found.path = configurations(*growth.path);
    found.path->topRows(1) = start.transpose();
    found.path->bottomRows(1) = valid.row(growth.goal);
  }
  found.explored = configurations(growth.from_start);
  found.checks = count.checks();
  return found;
}

Sampled Sampler::shorten(const Rows& path, double shorter_than, std::uint64_t seed, const SearchEffort& effort) {
  Count count(effort);
  Random random(seed);
  const Rows points = shortened(path * units_.cwiseInverse().asDiagonal(), random, count);
  Sampled found;
  found.checks = count.checks();
  const auto edges = points.bottomRows(points.rows() - 1) - points.topRows(points.rows() - 1);
  if (edges.cwiseAbs().rowwise().maxCoeff().sum() >= shorter_than) return found;
  Rows shorter = configurations(points);
  shorter.topRows(1) = path.topRows(1);
  shorter.bottomRows(1) = path.bottomRows(1);
  found.path = proven(shorter, random, count);
  found.checks = count.checks();
  return found;
}

Rows Sampler::shortened(const Rows& points, Random& random, Count& count) {
  const EdgeTest is_free = filter(count);
  const auto is_over = [&] { return count.is_over(); };
  return manifold_ ? manifold_->shortened(points, random, is_free, is_over)
                   : humanoid_rail::shortened(points, random, is_free, is_over);
}

Sampled Sampler::walk(const Vector& from, const Vector& to) {
  if (!manifold_) throw std::invalid_argument("there are no constraints to walk on");
  Count count({std::numeric_limits<long>::max(), INFINITE});
  Random random(0);
  bool arrived = false;
  const auto points =
      manifold_->walk(from.cwiseQuotient(units_), to.cwiseQuotient(units_), INFINITE, arrived, filter(count));
  Sampled found;
  if (arrived) {
    Rows path(static_cast<Eigen::Index>(points.size()) + 1, from.size());
    for (Eigen::Index i = 1; i < path.rows(); ++i) {
      path.row(i) = configuration(points[static_cast<std::size_t>(i - 1)]).transpose();
    }
    path.topRows(1) = from.transpose();
    path.bottomRows(1) = to.transpose();
    found.path = proven(path, random, count);
  }
  found.checks = count.checks();
  return found;
}

// Proves the edges of a path; those that cannot be proven are replaced.
std::optional<Rows> Sampler::proven(const Rows& path, Random& random, Count& count) {
  std::vector<Vector> points{path.row(0).transpose()};
  for (Eigen::Index i = 1; i < path.rows(); ++i) {
    const Vector a = points.back(), b = path.row(i).transpose();
    count.add();
    if (checker_.is_edge_valid(a, b)) {
      points.push_back(b);
      continue;
    }
    const auto detour = manifold_ ? std::nullopt : around(a, b, random, count);
    if (!detour) return std::nullopt;
    for (Eigen::Index k = 1; k < detour->rows(); ++k) points.emplace_back(detour->row(k).transpose());
  }
  Rows found(static_cast<Eigen::Index>(points.size()), path.cols());
  for (Eigen::Index i = 0; i < found.rows(); ++i) found.row(i) = points[static_cast<std::size_t>(i)].transpose();
  return found;
}

// Looks for a path of proven edges between the ends of an edge that cannot be proven.
std::optional<Rows> Sampler::around(const Vector& a, const Vector& b, Random& random, Count& count) {
  const Vector from = a.cwiseQuotient(units_), to = b.cwiseQuotient(units_);
  const double length = (to - from).norm();
  const Limits& limits = robot().limits;
  const Vector margin =
      (limits.velocity.array() > 0.0).select(Vector::Constant(from.size(), REPAIR_MARGIN * length), 0);
  const SearchBox box{(from.cwiseMin(to) - margin).cwiseMax(limits.lower.cwiseQuotient(units_)),
                      (from.cwiseMax(to) + margin).cwiseMin(limits.upper.cwiseQuotient(units_))};
  const long last = count.checks() + REPAIR_CHECKS;
  const auto is_valid = [&](const Vector& one, const Vector& two) {
    count.add();
    return checker_.is_edge_valid(configuration(one), configuration(two));
  };
  Growth growth = rrt_connect(from, to.transpose(), box, REPAIR_STEP * length, random, straight(is_valid),
                              [&] { return count.checks() >= last; });
  if (!growth.path) return std::nullopt;
  Rows q = configurations(*growth.path);
  q.topRows(1) = a.transpose();
  q.bottomRows(1) = b.transpose();
  return q;
}

}  // namespace humanoid_rail
