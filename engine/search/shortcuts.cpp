#include "shortcuts.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace humanoid_rail {

namespace {

// Random shortcuts are tried this often ...
constexpr int SHORTCUTS = 100;
// ... but no longer than this often in vain.
constexpr int MAX_IDLE = 30;
// Two points that are joined by a shortcut are at most this share of the path apart.
constexpr double SHARE = 0.5;
// A point this near to a corner, as a share of the path, is taken to be the corner.
constexpr double SNAP = 0.005;
// Corners are drawn in at most this often, ...
constexpr int ROPE_PASSES = 4;
// ... by this share of the way to the straight line between their neighbours, or by halves of it ...
constexpr double DRAWN = 0.8;
// ... at most this often.
constexpr int MAX_HALVINGS = 3;
// A pass that takes away a smaller share of the length is the last.
constexpr double WORTH_A_PASS = 0.005;

using Points = std::vector<Vector>;

double length(const Points& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

// A place on a path: a share of the edge that begins at a point.
struct Place {
  std::size_t edge = 0;
  double share = 0.0;
};

Place place_at(const Points& path, double along, double snap) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const double edge = (path[i + 1] - path[i]).norm();
    if (along < edge || i + 2 == path.size()) {
      if (along <= snap) return {i, 0.0};
      if (along >= edge - snap) return {i + 1, 0.0};
      return {i, along / edge};
    }
    along -= edge;
  }
  return {};
}

Vector point_at(const Points& path, const Place& place) {
  if (place.share == 0.0) return path[place.edge];
  return path[place.edge] + place.share * (path[place.edge + 1] - path[place.edge]);
}

// Joins two random points of a path by a straight edge. False if that is not free.
bool cut_short(Points& path, Random& random, const EdgeTest& is_free) {
  const double whole = length(path), snap = SNAP * whole;
  const double one = random.between(0.0, whole);
  const double two = std::clamp(one + random.between(-SHARE, SHARE) * whole, 0.0, whole);
  const Place from = place_at(path, std::min(one, two), snap), to = place_at(path, std::max(one, two), snap);
  // On one edge there is nothing to gain.
  if (to.edge < from.edge + 1 || (to.edge == from.edge + 1 && (to.share == 0.0 || from.share == 1.0))) return false;
  const Vector a = point_at(path, from), b = point_at(path, to);
  if (!is_free(a, b)) return false;
  Points shorter(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(from.edge) + 1);
  if (from.share > 0.0) shorter.push_back(a);
  if (to.share > 0.0) shorter.push_back(b);
  shorter.insert(shorter.end(), path.begin() + static_cast<std::ptrdiff_t>(to.edge) + (to.share > 0.0 ? 1 : 0),
                 path.end());
  path = std::move(shorter);
  return true;
}

// Leaves out every point that its neighbours do not need.
void leave_out(Points& path, const EdgeTest& is_free) {
  for (std::size_t i = 1; i + 1 < path.size();) {
    if (is_free(path[i - 1], path[i + 1])) {
      path.erase(path.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

// Draws every corner in towards the straight line between its neighbours.
void tighten(Points& path, const EdgeTest& is_free) {
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const Vector &before = path[i - 1], &after = path[i + 1];
    const Vector across = after - before;
    const double share = std::clamp((path[i] - before).dot(across) / across.squaredNorm(), 0.0, 1.0);
    const Vector towards = before + share * across - path[i];
    double drawn = DRAWN;
    for (int halving = 0; halving < MAX_HALVINGS; ++halving, drawn *= 0.5) {
      const Vector there = path[i] + drawn * towards;
      if (!is_free(before, there) || !is_free(there, after)) continue;
      path[i] = there;
      break;
    }
  }
}

}  // namespace

Rows shortened(const Rows& given, Random& random, const EdgeTest& is_free, const std::function<bool()>& is_over) {
  Points path;
  for (Eigen::Index i = 0; i < given.rows(); ++i) path.emplace_back(given.row(i).transpose());
  leave_out(path, is_free);
  for (int tried = 0, idle = 0; tried < SHORTCUTS && idle < MAX_IDLE && path.size() > 2 && !is_over(); ++tried) {
    idle = cut_short(path, random, is_free) ? 0 : idle + 1;
  }
  leave_out(path, is_free);
  double before = INFINITE, now = length(path);
  for (int pass = 0; pass < ROPE_PASSES && now < (1.0 - WORTH_A_PASS) * before && path.size() > 2 && !is_over();
       ++pass) {
    tighten(path, is_free);
    leave_out(path, is_free);
    before = now;
    now = length(path);
  }
  Rows shorter(static_cast<Eigen::Index>(path.size()), given.cols());
  for (Eigen::Index i = 0; i < shorter.rows(); ++i) shorter.row(i) = path[static_cast<std::size_t>(i)].transpose();
  return shorter;
}

}  // namespace humanoid_rail
