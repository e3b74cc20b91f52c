#include "clearance.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <coal/shape/geometric_shapes.h>
#include <pinocchio/collision/coal-pinocchio-conversions.hpp>

#include "../interruption.hpp"

namespace humanoid_rail {

namespace {

// How far to look for the nearest obstacle, first and, before everything, last, m.
constexpr double FIRST_REACH = 0.25;
constexpr double LAST_REACH = 1e3;
// The nearest obstacle is looked for within this many times the distance that it had before.
constexpr double MARGIN = 1.1;

}  // namespace

bool ObstacleClearances::Candidates::collide(coal::CollisionObject* piece, coal::CollisionObject*) {
  found.push_back(static_cast<const Body*>(piece->getUserData()));
  return false;  // Go on.
}

ObstacleClearances::ObstacleClearances(std::shared_ptr<const Robot> robot, const Obstacles& obstacles)
    : robot_(std::move(robot)), obstacles_(obstacles), seen_at_(static_cast<std::size_t>(obstacles.size())) {
  // Robot and obstacles have their boxes already, and other threads may be reading them.
  constexpr bool COMPUTE_BOX = false;
  for (const auto& body : robot_->bodies.geometryObjects) links_.emplace_back(body.geometry, COMPUTE_BOX);
  boxed_.reserve(pieces().size());
  bodies_.reserve(pieces().size());
  for (const Obstacles::Piece& piece : pieces()) {
    bodies_.push_back({&piece, static_cast<int>(bodies_.size()), piece.placement, nullptr});
    Body& body = bodies_.back();
    if (piece.shape->getNodeType() == coal::GEOM_HALFSPACE) {
      unbounded_.push_back(&body);
    } else {
      boxed_.emplace_back(piece.shape, piece.placement, COMPUTE_BOX);
      body.object = &boxed_.back();
      body.object->setUserData(&body);
    }
    if (piece.moves()) moving_.push_back(&body);
  }
  std::vector<coal::CollisionObject*> objects;
  for (auto& object : boxed_) objects.push_back(&object);
  bool link_moves = false;
  for (int link = 0; link < robot_->links(); ++link) link_moves = link_moves || robot_->moves(link);
  has_pairs_ = !links_.empty() && (!moving_.empty() || (!bodies_.empty() && link_moves));
  tree_.registerObjects(objects);
  tree_.setup();
  candidates_.found.reserve(pieces().size());
}

void ObstacleClearances::move_to(double t) {
  if (t == t_) return;
  t_ = t;
  for (Body* body : moving_) put(*body, t);
}

void ObstacleClearances::put(Body& body, double t) {
  body.placement = body.piece->at(t);
  if (body.object == nullptr) return;
  body.object->setTransform(body.placement);
  body.object->computeAABB();
  tree_.update(body.object);
}

void ObstacleClearances::place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity) {
  obstacles_.place(obstacle, placement, velocity);
  const auto [first, end] = obstacles_.pieces_of(obstacle);
  for (std::size_t i = first; i < end; ++i) {
    Body& body = bodies_[i];
    const bool is_listed = std::find(moving_.begin(), moving_.end(), &body) != moving_.end();
    if (body.piece->moves() && !is_listed) moving_.push_back(&body);
    has_pairs_ = has_pairs_ || (!links_.empty() && body.piece->moves());
    put(body, t_);
  }
}

void ObstacleClearances::within(double horizon, const Kinematics& kinematics, NearObstacles& found) {
  found.obstacles.clear();
  found.pieces.clear();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const int link = static_cast<int>(i);
    const bool moves = robot_->moves(link);
    if (!moves && moving_.empty()) continue;
    const coal::Transform3s placement = pinocchio::toCoalTransform3s(kinematics.body(link));
    links_[i].setTransform(placement);
    links_[i].computeAABB();
    links_[i].getAABB().expand(horizon);
    candidates_.found.assign(unbounded_.begin(), unbounded_.end());
    tree_.collide(&links_[i], &candidates_);
    for (const Body* body : candidates_.found) {
      if (!moves && !body->piece->moves()) continue;
      Interruption::poll();
      measure(link, placement, *body, horizon, found);
    }
  }
}

void ObstacleClearances::within_or_nearest(double horizon, const Kinematics& kinematics, NearObstacles& found) {
  within(horizon, kinematics, found);
  if (!has_pairs_ || !found.obstacles.empty()) return;
  // Where it was nearest before is a good guess.
  double reach = std::max({2.0 * horizon, FIRST_REACH, MARGIN * shortest_before_});
  for (within(reach, kinematics, found); found.obstacles.empty(); within(reach, kinematics, found)) {
    if (std::isinf(reach)) throw std::runtime_error("a distance that is not a number");
    reach = reach < LAST_REACH ? 2.0 * reach : INFINITE;
  }
  const auto shorter = [](const Nearest& a, const Nearest& b) { return a.distance < b.distance; };
  const auto& near = found.obstacles;
  const double shortest = std::min_element(near.begin(), near.end(), shorter)->distance;
  shortest_before_ = shortest;
  const auto longer = [&](const Nearest& pair) { return pair.distance > shortest; };
  for (auto* pairs : {&found.obstacles, &found.pieces}) {
    pairs->erase(std::remove_if(pairs->begin(), pairs->end(), longer), pairs->end());
  }
}

// Measures a link against a piece and keeps the result where it is the nearest piece of its obstacle so far.
void ObstacleClearances::measure(int link, const coal::Transform3s& placement, const Body& body, double horizon,
                                 NearObstacles& found) {
  const Obstacles::Piece& piece = *body.piece;
  Nearest nearest;
  const auto& shape = *robot_->bodies.geometryObjects[static_cast<std::size_t>(link)].geometry;
  meter_.measure(shape, placement, *piece.shape, body.placement, nearest);
  if (!(nearest.distance <= horizon)) return;
  nearest.pair = link * static_cast<int>(pieces().size()) + body.index;
  nearest.link = link;
  nearest.other = piece.obstacle;
  nearest.piece = body.index;
  nearest.rate = nearest.normal.dot(piece.velocity);
  if (obstacles_.is_compound()) found.pieces.push_back(nearest);
  std::size_t& at = seen_at_[static_cast<std::size_t>(piece.obstacle)];
  const bool is_seen =
      at < found.obstacles.size() && found.obstacles[at].link == link && found.obstacles[at].other == piece.obstacle;
  if (!is_seen) {
    at = found.obstacles.size();
    found.obstacles.push_back(nearest);
  } else if (nearest.distance < found.obstacles[at].distance) {
    found.obstacles[at] = nearest;
  }
}

LinkClearances::LinkClearances(std::shared_ptr<const Robot> robot)
    : robot_(robot), boxes_(robot), placements_(static_cast<std::size_t>(robot->links())) {}

void LinkClearances::move_to(const Kinematics& kinematics) {
  if (!boxes_.move_to(kinematics)) return;
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    placements_[i] = pinocchio::toCoalTransform3s(kinematics.body(static_cast<int>(i)));
  }
}

const LinkBoxes& LinkClearances::moving_boxes(const Kinematics& kinematics, const Vector& velocity) {
  move_to(kinematics);
  boxes_.set_velocity(kinematics, velocity);
  return boxes_;
}

void LinkClearances::within(double horizon, const Kinematics& kinematics, std::vector<Nearest>& found) {
  find(horizon, kinematics, found, nullptr);
}

void LinkClearances::glance(double horizon, const Kinematics& kinematics, std::vector<Nearest>& found,
                            std::vector<Unmeasured>& unmeasured) {
  unmeasured.clear();
  find(horizon, kinematics, found, &unmeasured);
}

void LinkClearances::find(double horizon, const Kinematics& kinematics, std::vector<Nearest>& found,
                          std::vector<Unmeasured>* unmeasured) {
  found.clear();
  move_to(kinematics);
  int pair = -1;
  for (const auto& [link, other] : robot_->self_collision_pairs) {
    ++pair;
    if (boxes_.are_apart(link, other, horizon)) continue;
    if (robot_->takes_long(pair)) {
      const double bound = boxes_.distance(link, other);
      if (bound > horizon) continue;
      if (unmeasured != nullptr) {
        unmeasured->push_back({pair, bound});
        continue;
      }
    }
    Nearest nearest;
    measure(link, other, nearest);
    if (!(nearest.distance <= horizon)) continue;
    nearest.pair = pair;
    found.push_back(nearest);
  }
}

Nearest LinkClearances::measure(int pair, const Kinematics& kinematics) {
  move_to(kinematics);
  const auto& [link, other] = robot_->self_collision_pairs[static_cast<std::size_t>(pair)];
  Nearest nearest;
  measure(link, other, nearest);
  nearest.pair = pair;
  return nearest;
}

void LinkClearances::measure(int link, int other, Nearest& nearest) {
  const auto a = static_cast<std::size_t>(link), b = static_cast<std::size_t>(other);
  const auto& bodies = robot_->bodies.geometryObjects;
  meter_.measure(*bodies[a].geometry, placements_[a], *bodies[b].geometry, placements_[b], nearest);
  nearest.link = link;
  nearest.other = other;
}

}  // namespace humanoid_rail
