#include "certificate.hpp"

#include <algorithm>
#include <cmath>

#include <pinocchio/collision/coal-pinocchio-conversions.hpp>

namespace humanoid_rail {

namespace {

// How far the bound may lie below the smallest clearance found, m.
constexpr double RESOLUTION = 1e-3;
// What coal's distances are precise to, m: two that come nearer touch.
constexpr double CONTACT = 1e-6;
// How far to look ahead, in units of the distance that a pair can spare.
constexpr double HOPE = 1.6;
// Pieces of obstacles that are measured without asking whether they are near.
constexpr int FEW = 64;
// Samples that are looked at together: so few that they stay in the processor's cache.
constexpr Eigen::Index BLOCK = 128;

}  // namespace

// One motion, block by block and pair by pair: a pair is looked at again when it could have come near enough to matter.
class Certifier::Search {
 public:
  Search(Certifier& self, const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q)
      : self_(self), t_(t), q_(q) {}

  Certificate run() {
    const Eigen::Index samples = t_.size();
    for (first_ = 0; first_ == 0 || first_ + 1 < samples; first_ += BLOCK) {
      last_ = std::min(first_ + BLOCK, samples - 1);
      measure_travel();
      seen_.assign(static_cast<std::size_t>(last_ - first_ + 1), false);
      glance();
      for_all_pairs([&](const Nearest& pair) { search(pair); });
    }
    result_.bound = std::min({result_.bound, result_.min_obstacles, result_.min_links}) - CONTACT;
    result_.certified = !result_.contact && result_.bound > 0.0;
    return result_;
  }

 private:
  template <class Visit>
  void for_all_pairs(Visit visit) const {
    const Robot& robot = *self_.robot_;
    Nearest pair{};
    for (int link = 0; link < robot.links(); ++link) {
      for (std::size_t i = 0; i < self_.pieces_.size(); ++i) {
        pair.pair = link * static_cast<int>(self_.pieces_.size()) + static_cast<int>(i);
        pair.link = link;
        pair.piece = static_cast<int>(i);
        pair.other = self_.pieces_[i].obstacle;
        visit(pair);
      }
    }
    for (std::size_t i = 0; i < robot.self_collision_pairs.size(); ++i) {
      pair.pair = static_cast<int>(i);
      std::tie(pair.link, pair.other) = robot.self_collision_pairs[i];
      pair.piece = -1;
      visit(pair);
    }
  }

  // Measures pairs of links here and there, and obstacles that are few: the sooner a small clearance is known, the less
  // of what is larger has to be looked at.
  void glance() {
    for (const Eigen::Index k : {last_, (first_ + last_) / 2}) {
      for_all_pairs([&](Nearest pair) {
        if (pair.piece < FEW) measure(pair, at(k));
      });
    }
  }

  // Follows a pair through the block.
  void search(Nearest here) {
    const bool with_obstacle = here.piece >= 0;
    double& least = with_obstacle ? result_.min_obstacles : result_.min_links;
    if (with_obstacle && stays_far(here, least)) return;
    measure(here, at(first_));
    if (here.distance < CONTACT) touch(here, at(first_));
    accept(here.distance);
    for (Eigen::Index k = first_; k < last_;) {
      const double spare = here.distance - wanted(least, t_[k], false);
      Reach reach{travel(here, k, k + 1), 0.0};
      Nearest there = here;
      if (reach.travel <= HOPE * spare) {
        // As far as the two can go and come back, if they are as far apart again there; ...
        const Eigen::Index hoped = farthest(here, k, HOPE * spare);
        measure(there, at(hoped));
        const double between = (here.distance + there.distance - travel(here, k, hoped)) / 2.0;
        if (between >= wanted(least, t_[k], false)) {
          accept(between);
          here = there;
          k = hoped;
          continue;
        }
        // ... or at least as far as they can spare.
        if (const Eigen::Index next = farthest(here, k, spare); next > k) {
          accept(here.distance - travel(here, k, next));
          k = next;
          if (k < last_) measure(here, at(k));
          continue;
        }
      }
      measure(there, at(k + 1));
      const Matrix& curvature = with_obstacle ? link_curvature_ : pair_curvature_;
      reach.curvature = curvature(k - first_, with_obstacle ? here.link : here.pair);
      step(here, at(k), there, at(k + 1), reach);
      here = there;
      ++k;
    }
  }

  // The straight way between two moments at which a pair was measured.
  void step(const Nearest& here, const Snapshot& a, const Nearest& there, const Snapshot& b, const Reach& reach) {
    const double least = here.piece >= 0 ? result_.min_obstacles : result_.min_links;
    const double bound = self_.sweep_.least(here, a, there, b, reach, wanted(least, a.t, true));
    if (bound >= wanted(least, a.t, true)) return accept(bound);
    if (reach.travel <= CONTACT) {
      touch(there, b);
      return accept(bound);
    }
    Snapshot middle;
    look(0.5 * (a.t + b.t), 0.5 * (a.q + b.q), middle);
    Nearest between = here;
    measure(between, middle);
    // Half the way, at half the rates.
    const Reach half{0.5 * reach.travel, 0.25 * reach.curvature};
    step(here, a, between, middle, half);
    step(between, middle, there, b, half);
  }

  // What a bound has to reach: the smallest clearance so far, or where a step is looked at closely a little less. Until
  // there is contact every pair has to be proven apart.
  double wanted(double least, double t, bool closely) const {
    double wanted = least;
    if (closely) wanted -= least > 0.0 ? std::min(RESOLUTION, least / 2.0) : RESOLUTION;
    return !result_.contact || t < result_.contact->t ? std::max(wanted, 0.5 * CONTACT) : wanted;
  }

  void accept(double bound) { result_.bound = std::min(result_.bound, bound); }

  void touch(const Nearest& pair, const Snapshot& at) {
    if (result_.contact && result_.contact->t <= at.t) return;
    result_.contact = Contact{at.t, pair.link, pair.other, pair.piece >= 0, pair.point};
  }

  // Whether balls around link and piece are so far apart that they need no closer look in this block.
  bool stays_far(const Nearest& pair, double least) {
    const auto& piece = self_.pieces_[static_cast<std::size_t>(pair.piece)];
    if (piece.shape->getNodeType() == coal::GEOM_HALFSPACE || std::isinf(least)) return false;
    const auto& body = *self_.robot_->bodies.geometryObjects[static_cast<std::size_t>(pair.link)].geometry;
    const Snapshot& start = at(first_);
    const Eigen::Vector3d middle = self_.sweep_.body(start, pair.link).act(Eigen::Vector3d(body.aabb_center));
    const Eigen::Vector3d other = piece.at(start.t).transform(piece.shape->aabb_center);
    const double distance = (middle - other).norm() - body.aabb_radius - piece.shape->aabb_radius;
    const double bound = distance - travel(pair, first_, last_);
    if (bound < wanted(least, start.t, false)) return false;
    accept(bound);
    return true;
  }

  void measure(Nearest& pair, const Snapshot& at) {
    const auto& bodies = self_.robot_->bodies.geometryObjects;
    const auto link = static_cast<std::size_t>(pair.link);
    const auto placement = pinocchio::toCoalTransform3s(self_.sweep_.body(at, pair.link));
    if (pair.piece >= 0) {
      const auto& piece = self_.pieces_[static_cast<std::size_t>(pair.piece)];
      self_.meter_.measure(*bodies[link].geometry, placement, *piece.shape, piece.at(at.t), pair);
      result_.min_obstacles = std::min(result_.min_obstacles, pair.distance);
    } else {
      const auto other = static_cast<std::size_t>(pair.other);
      self_.meter_.measure(*bodies[link].geometry, placement, *bodies[other].geometry,
                           pinocchio::toCoalTransform3s(self_.sweep_.body(at, pair.other)), pair);
      result_.min_links = std::min(result_.min_links, pair.distance);
    }
  }

  // How far the two of a pair get relative to each other between two samples, m.
  double travel(const Nearest& pair, Eigen::Index from, Eigen::Index to) const {
    const Matrix& way = pair.piece >= 0 ? link_travel_ : pair_travel_;
    const Eigen::Index column = pair.piece >= 0 ? pair.link : pair.pair;
    const double speed = pair.piece >= 0 ? self_.pieces_[static_cast<std::size_t>(pair.piece)].velocity.norm() : 0.0;
    return way(to - first_, column) - way(from - first_, column) + speed * (t_[to] - t_[from]);
  }

  // The last sample of the block until which a pair travels no farther than it can spare.
  Eigen::Index farthest(const Nearest& pair, Eigen::Index from, double spare) const {
    Eigen::Index low = from, high = last_;
    if (travel(pair, from, last_) <= spare) return last_;
    while (high - low > 1) {
      const Eigen::Index middle = (low + high) / 2;
      (travel(pair, from, middle) <= spare ? low : high) = middle;
    }
    return low;
  }

  void measure_travel() {
    const Robot& robot = *self_.robot_;
    const Eigen::Index count = last_ - first_ + 1;
    link_travel_.setZero(count, robot.links());
    pair_travel_.setZero(count, static_cast<Eigen::Index>(robot.self_collision_pairs.size()));
    link_curvature_.setZero(link_travel_.rows(), link_travel_.cols());
    pair_curvature_.setZero(pair_travel_.rows(), pair_travel_.cols());
    Vector before = robot.offset + robot.coupling * q_.row(first_).transpose(), after(before.size());
    for (Eigen::Index i = 1; i < count; ++i) {
      after = robot.offset;
      after.noalias() += robot.coupling * q_.row(first_ + i).transpose();
      self_.sweep_.measure(before, after, ways_);
      const auto add = [i](const std::vector<Reach>& reaches, Matrix& travel, Matrix& curvature) {
        for (std::size_t c = 0; c < reaches.size(); ++c) {
          const auto column = static_cast<Eigen::Index>(c);
          travel(i, column) = travel(i - 1, column) + reaches[c].travel;
          curvature(i - 1, column) = reaches[c].curvature;
        }
      };
      add(ways_.links, link_travel_, link_curvature_);
      add(ways_.pairs, pair_travel_, pair_curvature_);
      before.swap(after);
    }
  }

  // The robot at a sample of the block.
  const Snapshot& at(Eigen::Index k) {
    const auto i = static_cast<std::size_t>(k - first_);
    if (!seen_[i]) look(t_[k], q_.row(k).transpose(), self_.snapshots_[i]);
    seen_[i] = true;
    return self_.snapshots_[i];
  }

  void look(double t, const Eigen::Ref<const Vector>& q, Snapshot& snapshot) {
    self_.kinematics_.move_joints_to(q);
    self_.sweep_.take(t, q, self_.kinematics_, snapshot);
  }

  Certifier& self_;
  const Eigen::Ref<const Vector>& t_;
  const Eigen::Ref<const Rows>& q_;
  Certificate result_;
  Eigen::Index first_ = 0, last_ = 0;  // The block.
  Matrix link_travel_, pair_travel_;  // From the first sample of the block to each: a row for each sample.
  Matrix link_curvature_, pair_curvature_;  // From each sample to the next.
  Ways ways_;
  std::vector<char> seen_;  // Of the samples of the block, in self_.snapshots_.
};

Certifier::Certifier(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : robot_(robot), pieces_(obstacles.pieces()), kinematics_(robot), sweep_(robot, pieces_), snapshots_(BLOCK + 1) {
  for (Obstacles::Piece& piece : pieces_) piece.shape->computeLocalAABB();
}

Certificate Certifier::certify(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q) {
  return Search(*this, t, q).run();
}

}  // namespace humanoid_rail
