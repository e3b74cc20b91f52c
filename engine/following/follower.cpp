#include "follower.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace humanoid_rail {

namespace {

// Of the way from the stop's velocity to the one that is wanted these shares are tried in turn.
constexpr double SHARES[] = {1.0, 0.5, 0.25, 0.125};
// A robot whose joints move no faster than this share of their limits stands still.
constexpr double STANDSTILL = 1e-4;
// Accelerations are precise to this share, positions to this, m and rad.
constexpr double LIMIT_PRECISION = 1e-9;
constexpr double POSITION_PRECISION = 1e-12;
// So are distances that obstacles were moved by, m.
constexpr double JUMP_PRECISION = 1e-9;

// How far a point within a radius of the origin gets at most from one placement to another, m.
double displacement(const coal::Transform3s& a, const coal::Transform3s& b, double radius) {
  // 2 sin(angle / 2). A trace of the rotations would lose half of the digits here.
  const double turn = (a.getRotation() - b.getRotation()).norm() / std::sqrt(2.0);
  return (b.getTranslation() - a.getTranslation()).norm() + turn * radius;
}

}  // namespace

Follower::Follower(std::shared_ptr<const Robot> robot, const Obstacles& obstacles, const Vector& start,
                   std::shared_ptr<const Goal> goal, const Safety& safety, FollowerSettings settings)
    : method_(robot, obstacles),
      proof_(robot, obstacles, safety.distance, settings.obstacle_speeds, settings.latency),
      goal_(std::move(goal)),
      safety_(safety),
      settings_(std::move(settings)) {
  const Limits& limits = robot->limits;
  const auto is_limit = [](const Vector& of) { return of.allFinite() && (of.array() > 0.0).all(); };
  if (!is_limit(limits.velocity) || !is_limit(settings_.acceleration)) {
    throw std::invalid_argument("a follower needs finite limits of speed and acceleration, greater than 0");
  }
  if ((start.array() < limits.lower.array()).any() || (start.array() > limits.upper.array()).any()) {
    throw std::invalid_argument("a follower starts within the position limits");
  }
  limit_gain_ = 1.0 / (settings_.dt * static_cast<double>(std::max(1L, cycles_to_rest(limits.velocity))));
  bodies_.resize(static_cast<std::size_t>(obstacles.size()));
  for (const Obstacles::Piece& piece : obstacles.pieces()) {
    Body& body = bodies_[static_cast<std::size_t>(piece.obstacle)];
    coal::Transform3s within = piece.within;
    body.placement = body.proven = piece.placement * within.inverse();
    body.velocity = piece.velocity;
    body.radius = std::max(body.radius, piece.within.getTranslation().norm() + piece.size());
  }
  state_.q = state_.stop = start;
  state_.velocity = Vector::Zero(start.size());
  braking_.velocity = state_.velocity;
}

std::optional<Nearest> Follower::contact() {
  Observation seen;
  method_.scene.observe(state_.q, 0.0, proof_.apart(), proof_.apart(), seen);
  for (const auto* pairs : {&seen.near.obstacles, &seen.links}) {
    for (const Nearest& pair : *pairs) {
      if (pair.distance < proof_.apart()) return pair;
    }
  }
  return std::nullopt;
}

void Follower::place(int obstacle, const coal::Transform3s& placement, const Eigen::Vector3d& velocity) {
  Body& body = bodies_.at(static_cast<std::size_t>(obstacle));
  body.placement = placement;
  body.velocity = velocity;
  method_.scene.place(obstacle, placement, velocity);
  proof_.place(obstacle, placement);
}

const FollowerState& Follower::step(bool brakes) {
  state_.jumped = find_jump();
  if (state_.jumped >= 0 && !is_at_rest()) state_.proven = false;
  state_.blocking.reset();
  method_.observe(state_.q, 0.0, goal_->gains, safety_, seen_);
  state_.closest = closest();
  set_reachable();
  advance(choose(brakes));
  move_obstacles();
  ++state_.cycle;
  return state_;
}

// Returns an obstacle that is farther from where it was when the stop was proven than its speed allows; -1 for none.
int Follower::find_jump() const {
  if (proven_at_ < 0) return -1;
  const double elapsed = static_cast<double>(state_.cycle - proven_at_) * settings_.dt;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const int obstacle = static_cast<int>(i);
    const double allowed = proof_.drift(obstacle, elapsed) + JUMP_PRECISION;
    if (displacement(body.proven, body.placement, body.radius) > allowed) return obstacle;
  }
  return -1;
}

Nearest Follower::closest() const {
  Nearest found;
  for (const auto* pairs : {&seen_.near.obstacles, &seen_.links}) {
    for (const Nearest& pair : *pairs) {
      if (pair.distance < found.distance) found = pair;
    }
  }
  return found;
}

// |v' - v| <= a dt, and v' <= (q_max - q) / T with the longest time to rest T: whoever keeps to that can brake before
// the limit, together with all other joints. The stop's next velocity is always allowed.
void Follower::set_reachable() {
  const Limits& limits = robot().limits;
  reachable_.fallback = braking_.velocity;
  if (braking_.cycles > 0) {
    reachable_.fallback *= 1.0 - static_cast<double>(braking_.done + 1) / static_cast<double>(braking_.cycles);
  }
  reachable_.upper = state_.velocity + settings_.dt * settings_.acceleration;
  reachable_.lower = state_.velocity - settings_.dt * settings_.acceleration;
  reachable_.upper = reachable_.upper.cwiseMin(limit_gain_ * (limits.upper - state_.q)).cwiseMax(reachable_.fallback);
  reachable_.lower = reachable_.lower.cwiseMax(limit_gain_ * (limits.lower - state_.q)).cwiseMin(reachable_.fallback);
}

// Sets a velocity whose stop is proven. False if there is none but the stop's own.
bool Follower::choose(bool brakes) {
  if (!brakes) {
    wanted_ = method_.velocity(seen_, goal_->tasks, goal_->gains, safety_, settings_.dt, reachable_);
    wanted_ = wanted_.cwiseMin(reachable_.upper).cwiseMax(reachable_.lower);
    for (const double share : SHARES) {
      if (wanted_ == reachable_.fallback) break;
      candidate_ = reachable_.fallback + share * (wanted_ - reachable_.fallback);
      if (is_stop_proven(candidate_)) return true;
    }
  }
  if (state_.proven) return false;
  // The stop was proven for obstacles elsewhere.
  candidate_ = reachable_.fallback;
  return is_stop_proven(candidate_);
}

// With v held for a cycle and then falling to 0 in m - 1 equal parts more, the robot gets from q to q + v dt (m + 1)
// / 2.
bool Follower::is_stop_proven(const Vector& velocity) {
  const long cycles = cycles_to_rest(velocity);
  stop_ = state_.q;
  if (cycles == 0) return true;
  stop_ += 0.5 * settings_.dt * static_cast<double>(cycles + 1) * velocity;
  const Limits& limits = robot().limits;
  if ((stop_.array() > limits.upper.array() + POSITION_PRECISION).any() ||
      (stop_.array() < limits.lower.array() - POSITION_PRECISION).any()) {
    return false;
  }
  auto unproven = proof_.unproven(method_.scene, seen_, stop_, settings_.dt * static_cast<double>(cycles));
  if (unproven && !state_.blocking) state_.blocking = unproven;
  return !unproven;
}

long Follower::cycles_to_rest(const Vector& velocity) const {
  const double most = (velocity.cwiseAbs().cwiseQuotient(settings_.acceleration)).maxCoeff() / settings_.dt;
  return static_cast<long>(std::ceil(most - LIMIT_PRECISION));
}

void Follower::begin_stop() {
  braking_.velocity = candidate_;
  braking_.cycles = cycles_to_rest(candidate_);
  braking_.done = 0;
  if (braking_.cycles == 0) braking_.velocity.setZero();
  state_.stop = stop_;
}

// Moves the robot by the velocity that was chosen, or else by the stop's.
void Follower::advance(bool is_chosen) {
  const Limits& limits = robot().limits;
  if (is_chosen) {
    begin_stop();
    state_.velocity = braking_.velocity;
  } else {
    ++braking_.done;
    state_.velocity = reachable_.fallback;
  }
  state_.q = (state_.q + settings_.dt * state_.velocity).cwiseMin(limits.upper).cwiseMax(limits.lower);
  state_.cycles_to_rest = braking_.cycles - braking_.done;
  const bool is_resting = is_at_rest();
  if (is_resting) {
    braking_.velocity.setZero();
    braking_.cycles = braking_.done = state_.cycles_to_rest = 0;
    state_.stop = state_.q;
  }
  if (is_chosen || is_resting) {
    state_.proven = true;
    proven_at_ = state_.cycle;
    for (Body& body : bodies_) body.proven = body.placement;
  }
  goal_->tasks.error(method_.scene.move_hands_to(state_.q), 0.0, error_);
  state_.left = error_.norm();
  const bool is_still = (state_.velocity.array().abs() <= STANDSTILL * limits.velocity.array()).all();
  state_.status = state_.left <= settings_.tolerance ? FollowerStatus::reached
                  : is_still                         ? FollowerStatus::stopped
                  : is_chosen                        ? FollowerStatus::following
                                                     : FollowerStatus::braking;
}

void Follower::move_obstacles() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    if (body.velocity.isZero(0.0)) continue;
    const Eigen::Vector3d at = body.placement.getTranslation() + settings_.dt * body.velocity;
    place(static_cast<int>(i), {body.placement.getRotation(), at}, body.velocity);
  }
}

}  // namespace humanoid_rail
