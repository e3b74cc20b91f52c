#include "certifier.hpp"

#include <algorithm>
#include <cmath>

namespace humanoid_rail {

namespace {

// A pair is looked at again after this many times the displacement that it can spare.
constexpr double LOOK_AHEAD = 1.6;
// This many pieces of obstacles are measured without asking whether they are near.
constexpr int FEW_PIECES = 64;
// This many samples are looked at together: few enough to stay in the processor's cache.
constexpr Eigen::Index BLOCK = 128;

}  // namespace

// One motion, block by block and pair by pair: a pair is looked at again when it could have come near enough to matter.
class Certifier::Search {
 public:
  Search(Certifier& self, const SampledMotion& motion, long max_checks)
      : self_(self), motion_(motion), checks_left_(max_checks) {}

  Certificate run() {
    try {
      measure_motion();
      look_everywhere();
    } catch (const BudgetUsedUp&) {
      result_.stopped = motion_.time(first_);
    }
    for (const Followed* kind : {&links_, &own_}) result_.min_links = std::min(result_.min_links, kind->least);
    result_.min_obstacles = obstacles_.least;
    result_.others_bound = std::min({obstacles_.lowest(), links_.lowest()}) - margin_;
    result_.bound = std::min(result_.others_bound, own_.lowest() - margin_);
    result_.certified = !result_.contact && !result_.stopped && result_.bound > 0.0;
    return result_;
  }

 private:
  struct BudgetUsedUp {};
  // What is known of the pairs of a kind: the least distance that was found, and that none is less than the bound, m.
  struct Followed {
    double least = INFINITE, bound = INFINITE;

    [[nodiscard]] double lowest() const { return std::min(least, bound); }
  };
  // The robot at a share of the edge that is looked at.
  struct Moment {
    const Snapshot& at;
    double share;
  };

  void look_everywhere() {
    for (first_ = 0; first_ == 0 || first_ + 1 < motion_.size(); first_ += BLOCK) {
      last_ = std::min(first_ + BLOCK, motion_.size() - 1);
      measure_paths();
      seen_.assign(static_cast<std::size_t>(last_ - first_ + 1), false);
      glance();
      for (const Nearest& pair : self_.pairs_) search(pair);
    }
  }

  // Measures pairs of links here and there, and obstacles that are few: the sooner a small clearance is known, the less
  // of what is larger has to be looked at.
  void glance() {
    for (const Eigen::Index k : {last_, (first_ + last_) / 2}) {
      for (Nearest pair : self_.pairs_) {
        if (pair.piece < FEW_PIECES) measure(pair, at(k));
      }
    }
  }

  // Follows a pair through the block.
  void search(Nearest here) {
    const bool with_obstacle = here.is_with_obstacle();
    const double& least = kind_of(here).least;
    if (with_obstacle && stays_far(here, least)) return;
    measure(here, at(first_));
    if (here.distance < margin_) touch(here, at(first_));
    accept(here, here.distance);
    for (Eigen::Index k = first_; k < last_;) {
      const double spare = here.distance - wanted(least, motion_.time(k), false);
      Displacement moved{displacement(here, k, k + 1), 0.0};
      Nearest there = here;
      if (moved.length <= LOOK_AHEAD * spare) {
        // As far as the two can go and come back, if they are as far apart again there; ...
        const Eigen::Index hoped = farthest(here, k, LOOK_AHEAD * spare);
        measure(there, at(hoped));
        const double between = (here.distance + there.distance - displacement(here, k, hoped)) / 2.0;
        if (between >= wanted(least, motion_.time(k), false)) {
          accept(here, between);
          here = there;
          k = hoped;
          continue;
        }
        // ... or at least as far as they can spare.
        if (const Eigen::Index next = farthest(here, k, spare); next > k) {
          accept(here, here.distance - displacement(here, k, next));
          k = next;
          if (k < last_) measure(here, at(k));
          continue;
        }
      }
      measure(there, at(k + 1));
      const Matrix& curvature = with_obstacle ? link_curvature_ : pair_curvature_;
      moved.curvature = curvature(k - first_, with_obstacle ? here.link : here.pair);
      edge_ = k;
      step(here, {at(k), 0.0}, there, {at(k + 1), 1.0}, moved);
      here = there;
      ++k;
    }
  }

  // Bounds a pair on the edge between two moments at which it was measured.
  void step(const Nearest& here, const Moment& a, const Nearest& there, const Moment& b, const Displacement& moved) {
    const double enough = wanted(kind_of(here).least, a.at.t, true);
    const double bound = self_.swept_.lower_bound(here, a.at, there, b.at, moved, enough);
    if (bound >= enough) return accept(here, bound);
    if (moved.length <= margin_) {
      touch(there, b.at);
      return accept(here, bound);
    }
    const double share = 0.5 * (a.share + b.share);
    const Snapshot middle = self_.swept_.snapshot(motion_.time(edge_, share), motion_.configuration(edge_, share));
    Nearest between = here;
    measure(between, middle);
    step(here, a, between, {middle, share}, part_of(moved, here, a, {middle, share}));
    step(between, {middle, share}, there, b, part_of(moved, here, {middle, share}, b));
  }

  // How far the two of a pair get relative to each other on half of an edge on which they get so far.
  Displacement part_of(const Displacement& whole, const Nearest& pair, const Moment& a, const Moment& b) {
    // Half the edge, at half the rates.
    if (!motion_.is_spline()) return {0.5 * whole.length, 0.25 * whole.curvature};
    self_.swept_.edge_bounds(a.at.q, b.at.q, bounds_);
    add_stray(motion_.bend(edge_, a.share, b.share), bounds_);
    Displacement part = bounds_.of(pair);
    part.length += self_.swept_.speed(pair) * (b.at.t - a.at.t);
    return part;
  }

  // Adds what the motion does beside a straight edge to bounds of that: no point of a link gets farther from where it
  // would be than each coordinate times the coordinate's lever.
  void add_stray(const Vector& bend, EdgeBounds& straight) const {
    const auto add = [&bend](const Matrix& levers, std::vector<Displacement>& moved) {
      const Vector stray = levers * bend;
      for (std::size_t i = 0; i < moved.size(); ++i) {
        // There and back; and as much as an eighth of it takes off the gap between planes.
        moved[i].length += 2.0 * stray[static_cast<Eigen::Index>(i)];
        moved[i].curvature += 8.0 * stray[static_cast<Eigen::Index>(i)];
      }
    };
    add(levers_.links, straight.links);
    add(levers_.pairs, straight.pairs);
  }

  // What a bound has to reach: the smallest clearance so far, or where a step is looked at closely a little less. Until
  // there is contact every pair has to be proven apart.
  double wanted(double least, double t, bool closely) const {
    double wanted = least;
    const double resolution = motion_.is_spline() ? SPLINE_RESOLUTION : RESOLUTION;
    if (closely) wanted -= least > 0.0 ? std::min(resolution, least / 2.0) : resolution;
    return !result_.contact || t < result_.contact->t ? std::max(wanted, 0.5 * margin_) : wanted;
  }

  void accept(const Nearest& pair, double bound) {
    double& known = kind_of(pair).bound;
    known = std::min(known, bound);
  }

  // Pairs with a distance of their own are followed apart: as they may always be near, what is near them says little of
  // the others.
  Followed& kind_of(const Nearest& pair) {
    if (pair.is_with_obstacle()) return obstacles_;
    return std::isinf(self_.robot().pair_distances[pair.pair]) ? links_ : own_;
  }

  void touch(const Nearest& pair, const Snapshot& at) {
    if (result_.contact && result_.contact->t <= at.t) return;
    result_.contact = Contact{at.t, pair.link, pair.other, pair.is_with_obstacle(), pair.point};
  }

  // Whether balls around link and piece are so far apart that they need no closer look in this block.
  bool stays_far(const Nearest& pair, double least) {
    const auto& piece = self_.swept_.pieces()[static_cast<std::size_t>(pair.piece)];
    if (piece.shape->getNodeType() == coal::GEOM_HALFSPACE || std::isinf(least)) return false;
    const auto& body = *self_.robot().bodies.geometryObjects[static_cast<std::size_t>(pair.link)].geometry;
    const Snapshot& start = at(first_);
    const Eigen::Vector3d middle = self_.swept_.body(start, pair.link).act(Eigen::Vector3d(body.aabb_center));
    const Eigen::Vector3d other = piece.at(start.t).transform(piece.shape->aabb_center);
    const double distance = (middle - other).norm() - body.aabb_radius - piece.shape->aabb_radius;
    const double bound = distance - displacement(pair, first_, last_);
    if (bound < wanted(least, start.t, false)) return false;
    accept(pair, bound);
    return true;
  }

  void measure(Nearest& pair, const Snapshot& at) {
    if (--checks_left_ < 0) throw BudgetUsedUp{};
    double& least = kind_of(pair).least;
    least = std::min(least, self_.swept_.measure(pair, at));
  }

  // How far the two of a pair get relative to each other between two samples, m.
  double displacement(const Nearest& pair, Eigen::Index from, Eigen::Index to) const {
    const bool with_obstacle = pair.is_with_obstacle();
    const Matrix& path = with_obstacle ? link_path_ : pair_path_;
    const Eigen::Index column = with_obstacle ? pair.link : pair.pair;
    const double moved = self_.swept_.speed(pair) * (motion_.time(to) - motion_.time(from));
    return path(to - first_, column) - path(from - first_, column) + moved;
  }

  // The last sample of the block until which a pair gets no farther than it can spare.
  Eigen::Index farthest(const Nearest& pair, Eigen::Index from, double spare) const {
    Eigen::Index low = from, high = last_;
    if (displacement(pair, from, last_) <= spare) return last_;
    while (high - low > 1) {
      const Eigen::Index middle = (low + high) / 2;
      (displacement(pair, from, middle) <= spare ? low : high) = middle;
    }
    return low;
  }

  // Sets what is true of the whole motion.
  void measure_motion() {
    const Robot& robot = self_.robot();
    const Vector slide = robot.coupling.cwiseAbs() * motion_.farthest() + robot.offset.cwiseAbs();
    const double latest = std::max(std::abs(motion_.time(0)), std::abs(motion_.time(motion_.size() - 1)));
    margin_ = margin(self_.swept_.size(slide, latest));
    if (motion_.is_spline()) levers_ = self_.swept_.levers(slide);
  }

  void measure_paths() {
    const Robot& robot = self_.robot();
    const Eigen::Index count = last_ - first_ + 1;
    link_path_.setZero(count, robot.links());
    pair_path_.setZero(count, static_cast<Eigen::Index>(robot.self_collision_pairs.size()));
    link_curvature_.setZero(link_path_.rows(), link_path_.cols());
    pair_curvature_.setZero(pair_path_.rows(), pair_path_.cols());
    for (Eigen::Index i = 1; i < count; ++i) {
      const Eigen::Index k = first_ + i - 1;
      self_.swept_.edge_bounds(motion_.configuration(k), motion_.configuration(k + 1), bounds_);
      if (motion_.is_spline()) add_stray(motion_.bend(k, 0.0, 1.0), bounds_);
      const auto add = [i](const std::vector<Displacement>& moved, Matrix& path, Matrix& curvature) {
        for (std::size_t c = 0; c < moved.size(); ++c) {
          const auto column = static_cast<Eigen::Index>(c);
          path(i, column) = path(i - 1, column) + moved[c].length;
          curvature(i - 1, column) = moved[c].curvature;
        }
      };
      add(bounds_.links, link_path_, link_curvature_);
      add(bounds_.pairs, pair_path_, pair_curvature_);
    }
  }

  // The robot at a sample of the block.
  const Snapshot& at(Eigen::Index k) {
    const auto i = static_cast<std::size_t>(k - first_);
    if (!seen_[i]) self_.swept_.snapshot(motion_.time(k), motion_.configuration(k), self_.snapshots_[i]);
    seen_[i] = true;
    return self_.snapshots_[i];
  }

  Certifier& self_;
  const SampledMotion& motion_;
  long checks_left_;
  Certificate result_;
  Followed obstacles_, links_, own_;
  double margin_ = CONTACT;  // m
  Levers levers_;
  Eigen::Index first_ = 0, last_ = 0;       // The block.
  Matrix link_path_, pair_path_;            // From the first sample of the block to each: a row for each sample.
  Matrix link_curvature_, pair_curvature_;  // From each sample to the next.
  Eigen::Index edge_ = 0;                   // From this sample to the next.
  EdgeBounds bounds_;
  std::vector<char> seen_;  // Of the samples of the block, in self_.snapshots_.
};

Certifier::Certifier(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : swept_(robot, obstacles.pieces()), pairs_(all_pairs(*robot, obstacles.pieces())), snapshots_(BLOCK + 1) {}

Certificate Certifier::certify(const SampledMotion& motion, long max_checks) {
  return Search(*this, motion, max_checks).run();
}

}  // namespace humanoid_rail
