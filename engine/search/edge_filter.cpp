#include "edge_filter.hpp"

#include <algorithm>
#include <cmath>

#include "../interruption.hpp"

namespace humanoid_rail {

namespace {

// No body has to be sampled more closely than at this, m.
constexpr double SHORTEST_SPACING = 0.01;
// No edge is sampled at more than this many times LANES configurations.
constexpr int MAX_BATCHES = 64;

FilterKernel fastest_kernel() {
#ifdef HUMANOID_RAIL_AVX2
  if (__builtin_cpu_supports("avx2")) return filter_by_avx2;
#endif
  return filter_portably;
}

// How far from 0 the joints get, as far as that is limited.
Vector farthest(const Robot& robot) {
  Vector q = robot.limits.lower.cwiseAbs().cwiseMax(robot.limits.upper.cwiseAbs());
  for (double& value : q) value = std::isfinite(value) ? value : 0.0;
  return robot.offset.cwiseAbs() + Coupling(robot.coupling.cwiseAbs()) * q;
}

}  // namespace

EdgeFilter::EdgeFilter(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance,
                       double own_share, bool portable)
    : distance_(distance),
      own_share_(own_share),
      swept_(robot, obstacles.pieces(), false),
      scene_(*robot, obstacles.pieces(), distance, own_share),
      kernel_(portable ? filter_portably : fastest_kernel()),
      samples_per_(swept_.levers(farthest(*robot)).links),
      q_(static_cast<std::size_t>(robot->n() * LANES)) {
  const FilterData& data = scene_.data();
  workspace_.resize(static_cast<std::size_t>(filter_workspace(data.joints, data.bodies)));
  undecided_.resize(scene_.inexact_pairs());
  for (int link = 0; link < robot->links(); ++link) {
    samples_per_.row(link) /= std::max(SHORTEST_SPACING, scene_.thickness(link));
  }
}

// How many times LANES samples an edge needs.
int EdgeFilter::batches(const Vector& change) const {
  if (samples_per_.rows() == 0) return 1;
  const double samples = (samples_per_ * change.cwiseAbs()).maxCoeff();
  return std::clamp(static_cast<int>(std::ceil(std::min(samples, 1e6) / LANES)), 1, MAX_BATCHES);
}

bool EdgeFilter::is_edge_free(const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b) {
  Interruption::poll();
  const Vector change = b - a;
  const int count = batches(change);
  // Each batch is spread over the whole edge, so that what blocks it is met early; the first one has its end.
  for (int batch = count; batch > 0; --batch) {
    for (int lane = 0; lane < LANES; ++lane) {
      shares_[lane] = static_cast<double>(lane * count + batch) / (LANES * count);
      placed_[lane] = false;
      for (int i = 0; i < change.size(); ++i) {
        q_[static_cast<std::size_t>(i * LANES + lane)] = static_cast<float>(a[i] + shares_[lane] * change[i]);
      }
    }
    int found = 0;
    if (kernel_(scene_.data(), q_.data(), workspace_.data(), undecided_.data(), &found) != 0) return false;
    for (int i = 0; i < found; ++i) {
      if (!is_free(undecided_[static_cast<std::size_t>(i)], a, change)) return false;
    }
  }
  return true;
}

// Whether a pair keeps its distance in the lanes in which the kernel could not tell.
bool EdgeFilter::is_free(const Undecided& pair, const Eigen::Ref<const Vector>& a, const Vector& change) {
  Nearest& nearest = known(pair);
  const double kept =
      nearest.is_with_obstacle() ? distance_ : robot().kept_distance(nearest.pair, distance_, own_share_);
  for (int lane = 0; lane < LANES; ++lane) {
    if ((pair.lanes >> lane & 1U) == 0) continue;
    if (!placed_[lane]) swept_.snapshot(0.0, a + shares_[lane] * change, at_[lane]);
    placed_[lane] = true;
    if (nearest.distance < INFINITE && swept_.separation(nearest, at_[lane]) >= kept) continue;
    if (swept_.measure(nearest, at_[lane]) >= kept) continue;
    nearest.distance = INFINITE;  // There need not be a direction in which they are apart.
    return false;
  }
  return true;
}

Nearest& EdgeFilter::known(const Undecided& pair) {
  const long pieces = scene_.data().pieces;
  const long bodies = scene_.data().bodies;
  const bool with_obstacle = pair.piece >= 0;
  const long key = with_obstacle ? pair.body * pieces + pair.piece : bodies * pieces + pair.pair;
  const auto [place, is_new] = measured_.try_emplace(key);
  Nearest& nearest = place->second;
  if (!is_new) return nearest;
  nearest.link = pair.body;
  nearest.piece = pair.piece;
  nearest.pair = with_obstacle ? static_cast<int>(key) : pair.pair;
  nearest.other = with_obstacle ? swept_.pieces()[static_cast<std::size_t>(pair.piece)].obstacle
                                : robot().self_collision_pairs[static_cast<std::size_t>(pair.pair)].second;
  return nearest;
}

}  // namespace humanoid_rail
