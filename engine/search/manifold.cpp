#include "manifold.hpp"

#include <algorithm>

namespace humanoid_rail {

namespace {

// The length of a step, in units of the speed limits, s: its chord is some tenths of a millimetre off at most.
constexpr double WALK_STEP = 0.03;
// A step that projection makes longer than this many has left for another part of the manifold.
constexpr double LONGEST_WALK_STEP = 2.0;
// A step has to come nearer by this share of it.
constexpr double NEARER = 0.1;
// A walk makes at most this many times the steps that a straight one would.
constexpr double LONGEST_DETOUR = 3.0;
// Random shortcuts are tried this often ...
constexpr int WALKED_SHORTCUTS = 100;
// ... but no longer than this often in vain.
constexpr int MAX_IDLE_WALKS = 25;
// A shortcut has to be shorter by this share.
constexpr double WORTH_A_WALK = 1e-3;

using Points = std::vector<Vector>;

double walked_length(const Vector& from, const Points& points) {
  double sum = 0.0;
  const Vector* before = &from;
  for (const Vector& point : points) {
    sum += (point - *before).norm();
    before = &point;
  }
  return sum;
}

}  // namespace

Manifold::Manifold(const std::shared_ptr<const Robot>& robot, std::shared_ptr<const TaskStack> constraints,
                   const Vector& units)
    : solver_(robot, Obstacles()), constraints_(std::move(constraints)), units_(units) {}

std::optional<Vector> Manifold::projected(const Vector& point) {
  const Posture found = solver_.solve(point.cwiseProduct(units_), *constraints_, -INFINITE);
  if (!found.reached) return std::nullopt;
  return found.q.cwiseQuotient(units_);
}

std::vector<Vector> Manifold::walk(const Vector& from, const Vector& to, double longest, bool& arrived,
                                   const EdgeTest& is_free) {
  Points points;
  Vector here = from;
  double left = (to - here).norm(), gone = 0.0;
  const double most = LONGEST_DETOUR * left;
  arrived = false;
  while (gone < longest && gone <= most) {
    const bool is_last = left <= WALK_STEP;
    const auto there = projected(is_last ? to : Vector(here + WALK_STEP / left * (to - here)));
    if (!there) break;
    const double step = (*there - here).norm(), still = (to - *there).norm();
    if (step > LONGEST_WALK_STEP * WALK_STEP || (!is_last && still > left - NEARER * WALK_STEP)) break;
    // A target on the manifold is where its projection is; the last step to another leads as near as it can.
    arrived = is_last && still <= 1e-6;
    const Vector next = arrived ? to : *there;
    if (!is_free(here, next)) {
      arrived = false;
      break;
    }
    points.push_back(next);
    if (is_last) break;
    gone += step;
    here = next;
    left = still;
  }
  return points;
}

Rows Manifold::shortened(const Rows& path, Random& random, const EdgeTest& is_free,
                         const std::function<bool()>& is_over) {
  Points points;
  for (Eigen::Index i = 0; i < path.rows(); ++i) points.emplace_back(path.row(i).transpose());
  for (int tried = 0, idle = 0; tried < WALKED_SHORTCUTS && idle < MAX_IDLE_WALKS && points.size() > 2 && !is_over();
       ++tried) {
    const auto any = [&] { return static_cast<std::ptrdiff_t>(random.share() * static_cast<double>(points.size())); };
    // The whole path first.
    const auto [a, b] =
        tried == 0 ? std::pair<std::ptrdiff_t, std::ptrdiff_t>(0, points.size() - 1) : std::minmax({any(), any()});
    ++idle;
    if (b - a < 2) continue;
    const auto first = points.begin() + a, last = points.begin() + b;
    bool arrived = false;
    const Points shorter = walk(*first, *last, INFINITE, arrived, is_free);
    const double before = walked_length(*first, Points(first + 1, last + 1));
    if (!arrived || walked_length(*first, shorter) > (1.0 - WORTH_A_WALK) * before) continue;
    Points joined(points.begin(), first + 1);
    joined.insert(joined.end(), shorter.begin(), shorter.end());
    joined.insert(joined.end(), last + 1, points.end());
    points = std::move(joined);
    idle = 0;
  }
  Rows shorter(static_cast<Eigen::Index>(points.size()), path.cols());
  for (Eigen::Index i = 0; i < shorter.rows(); ++i) shorter.row(i) = points[static_cast<std::size_t>(i)].transpose();
  return shorter;
}

}  // namespace humanoid_rail
