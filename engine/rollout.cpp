#include "rollout.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <boost/math/tools/toms748_solve.hpp>

namespace humanoid_rail {

namespace {

// How often a step that is not safe is halved before the robot stands still.
constexpr int HALVINGS = 6;
// What a step has to keep between all pairs on its way, m: twice what coal's distances are precise to.
constexpr double APART = 2e-6;
// The shortest last step, as a share of one: a shorter one would have a speed of rounding errors.
constexpr double SHORTEST = 1e-3;
// What rounding may take from a distance in a step, m.
constexpr double ROUNDING = 1e-9;
// Of |e|: less than this in the time a motion has to get somewhere is no progress.
constexpr double PROGRESS = 0.01;

enum class Step { safe, free, blocked };

// A robot among obstacles at the end of a step.
struct Place {
  Snapshot snapshot;
  std::vector<Nearest> obstacles, links;  // Pairs within the horizons, in the order of their numbers.
};

// Steps of a robot among obstacles.
class Walk {
 public:
  Walk(SafeVelocity& method, const Gains& gains, const Safety& safety)
      : method_(method),
        gains_(gains),
        safety_(safety),
        kinematics_(method.projection.kinematics),
        sweep_(kinematics_.robot_pointer(), method.projection.clearances.pieces()) {
    for (const auto& piece : method.projection.clearances.pieces()) {
      fastest_ = std::max(fastest_, piece.velocity.norm());
    }
  }

  void look(const Vector& q, double t, Place& place) {
    method_.look(q, t, gains_, safety_);
    sweep_.take(t, q, kinematics_, place.snapshot);
    place.obstacles.clear();
    if (method_.projection.clearances.obstacles() > 0) place.obstacles = method_.near_obstacles();
    place.links = method_.near_links();
    const auto before = [](const Nearest& a, const Nearest& b) { return a.pair < b.pair; };
    std::sort(place.obstacles.begin(), place.obstacles.end(), before);
  }

  // Whether the way from a to b is free of contact, and at its end no pair is below the safety distance or, where it was
  // below already, nearer.
  Step judge(const Place& a, const Place& b) {
    const Robot& robot = kinematics_.robot();
    full_a_ = robot.offset + robot.coupling * a.snapshot.q;
    full_b_ = robot.offset + robot.coupling * b.snapshot.q;
    sweep_.measure(full_a_, full_b_, ways_);
    const double duration = b.snapshot.t - a.snapshot.t;
    Step step = Step::safe;
    const auto keeps = [&](const std::vector<Nearest>& before, const std::vector<Nearest>& after, double horizon,
                           const std::vector<Reach>& reaches, double speed) {
      // What is within neither horizon stays apart if nothing gets so far.
      for (const Reach& reach : reaches) {
        if (horizon < (reach.travel + speed * duration) / 2.0) return false;
      }
      auto i = before.begin();
      for (const Nearest& there : after) {
        while (i != before.end() && i->pair < there.pair) ++i;
        const bool was_near = i != before.end() && i->pair == there.pair;
        const double was = was_near ? i->distance : horizon;
        Reach reach = ways_.of(there);
        reach.travel += speed * duration;
        const double bound = was_near ? sweep_.least(*i, a.snapshot, there, b.snapshot, reach, APART)
                                      : (was + there.distance - reach.travel) / 2.0;
        if (bound < APART) return false;
        if (there.distance < std::min(safety_.distance, was) - ROUNDING) step = Step::free;
      }
      // Those that have left the horizon.
      auto j = after.begin();
      for (const Nearest& here : before) {
        while (j != after.end() && j->pair < here.pair) ++j;
        if (j != after.end() && j->pair == here.pair) continue;
        if ((here.distance + horizon - ways_.of(here).travel - speed * duration) / 2.0 < APART) return false;
      }
      return true;
    };
    if (!keeps(a.obstacles, b.obstacles, method_.obstacle_horizon(), ways_.links, fastest_) ||
        !keeps(a.links, b.links, method_.link_horizon(), ways_.pairs, 0.0)) {
      return Step::blocked;
    }
    return step;
  }

 private:
  SafeVelocity& method_;
  const Gains& gains_;
  const Safety& safety_;
  const Kinematics& kinematics_;
  Sweep sweep_;
  double fastest_ = 0.0;  // Of the obstacles, m/s.
  Vector full_a_, full_b_;
  Ways ways_;
};

}  // namespace

Rollout rollout(SafeVelocity& method, const Obstacles& obstacles, const Vector& start, const Vector& targets,
                const Gains& gains, const Safety& safety, const Settings& settings) {
  Rollout result{};
  Integration& motion = result.motion;
  motion.n = static_cast<std::size_t>(start.size());
  const GradientProjection& projection = method.projection;
  const Limits& limits = projection.kinematics.robot().limits;
  const bool moving = obstacles.move();
  const auto began = std::chrono::steady_clock::now();
  Walk walk(method, gains, safety);
  Place here, there;
  Vector q = start, next(start.size());
  double t = 0.0;

  const auto sample = [&](const Vector& at) {
    motion.t.push_back(t);
    motion.q.insert(motion.q.end(), at.begin(), at.end());
  };
  const auto visit = [&](const Vector& velocity) {
    motion.visited_t.push_back(t);
    motion.visited_q.insert(motion.visited_q.end(), q.begin(), q.end());
    motion.visited_velocity.insert(motion.visited_velocity.end(), velocity.begin(), velocity.end());
  };
  const auto finish = [&](Status status) {
    motion.status = status;
    return std::move(result);
  };
  const auto distance = [&] { return (projection.kinematics.hands() - targets).norm(); };

  sample(q);
  walk.look(q, t, here);
  motion.left = distance();
  if (motion.left <= settings.tolerance) {
    visit(Vector::Zero(start.size()));
    return finish(Status::reached);
  }
  double best = motion.left, best_t = 0.0, singular_since = INFINITE;
  for (;;) {
    const double duration = std::min(settings.dt, settings.max_time - t);
    const Vector velocity = method.resolve(targets, gains, safety, settings.dt);
    ++motion.evaluations;
    const bool held = projection.is_held_by_singularity(settings.tolerance);
    singular_since = held ? std::min(singular_since, t) : INFINITE;
    if (t - singular_since > settings.patience) {
      visit(Vector::Zero(start.size()));
      return finish(Status::singular);
    }
    // The largest step that is safe; with obstacles on the move at least one without contact.
    double share = 1.0, free_share = -1.0;
    Step step = Step::blocked;
    for (int halving = 0; halving <= HALVINGS + 1; ++halving) {
      share = halving <= HALVINGS ? std::ldexp(1.0, -halving) : 0.0;
      next = (q + share * duration * velocity).cwiseMin(limits.upper).cwiseMax(limits.lower);
      if (!moving && next == q) break;
      walk.look(next, t + duration, there);
      step = walk.judge(here, there);
      if (step == Step::safe) break;
      if (step == Step::free && free_share < 0.0) free_share = share;
    }
    if (step != Step::safe && moving && free_share >= 0.0) {
      share = free_share;
      next = (q + share * duration * velocity).cwiseMin(limits.upper).cwiseMax(limits.lower);
      walk.look(next, t + duration, there);
      step = Step::free;
    }
    if (step == Step::blocked || (step == Step::free && !moving)) {
      if (!moving) {
        visit(Vector::Zero(start.size()));
        return finish(Status::stalled);
      }
      // What fast obstacles do in a step may take a closer look to tell.
      Certifier certifier(projection.kinematics.robot_pointer(), obstacles);
      Certifier::Rows still(2, q.size());
      still << q.transpose(), q.transpose();
      const Certificate certificate = certifier.certify(Eigen::Vector2d(t, t + duration), still);
      if (!certificate.certified) {
        visit(Vector::Zero(start.size()));
        result.overrun = certificate.contact;
        return finish(Status::overrun);
      }
      share = 0.0;
      next = q;
      walk.look(next, t + duration, there);
    }
    visit(share * velocity);
    const double before = motion.left;
    motion.left = distance();
    if (motion.left <= settings.tolerance) {
      // When on the way the distance falls to the tolerance.
      Vector at(q.size());
      const auto excess = [&](double s) {
        at = q + s * (next - q);
        method.projection.kinematics.move_hands_to(at);
        return distance() - settings.tolerance;
      };
      double s = 1.0;
      if (const double after = excess(1.0); after < 0.0) {
        std::uintmax_t iterations = 100;
        const auto close = [](double a, double b) { return b - a <= 1e-12; };
        s = boost::math::tools::toms748_solve(excess, 0.0, 1.0, before - settings.tolerance, after, close, iterations)
                .second;
      }
      s = std::max(s, SHORTEST);
      motion.left = excess(s) + settings.tolerance;
      t += s * duration;
      sample(q + s * (next - q));
      return finish(Status::reached);
    }
    t = std::min(settings.dt * static_cast<double>(motion.t.size()), settings.max_time);
    q = next;
    std::swap(here, there);
    sample(q);
    if (motion.left < (1.0 - PROGRESS) * best) {
      best = motion.left;
      best_t = t;
    }
    if (!moving && t - best_t > settings.progress) return finish(Status::stalled);
    if (t > settings.max_time - SHORTEST * settings.dt) return finish(Status::time_limit);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - began;
    if (taken.count() > settings.planning_time) return finish(Status::out_of_time);
  }
}

}  // namespace humanoid_rail
