#include "rollout.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include <boost/math/tools/toms748_solve.hpp>

#include "../kinematics/inverse_kinematics.hpp"
#include "step_judge.hpp"

namespace humanoid_rail {

namespace {

// A step that is not safe is halved this often before the robot stands still.
constexpr int HALVINGS = 6;
// The last step is at least this share of one: a shorter one would have a speed of rounding errors.
constexpr double SHORTEST = 1e-3;
// The share of a step at which the tolerance is met is precise to this.
constexpr double SHARE_PRECISION = 1e-12;
// The search for that share takes at most this many steps.
constexpr std::uintmax_t MAX_SHARE_STEPS = 100;

// One rollout, step by step.
class Rollout {
 public:
  Rollout(SafeVelocity& method, const Vector& start, const TaskStack& tasks, const Gains& gains, const Safety& safety,
          const Settings& settings)
      : method_(method),
        tasks_(tasks),
        gains_(gains),
        safety_(safety),
        settings_(settings),
        obstacles_(method.scene.obstacles()),
        judge_(method.scene.kinematics().robot_pointer(), obstacles_, safety.distance),
        projection_(safety.constraints
                        ? std::make_unique<InverseKinematics>(method.scene.kinematics().robot_pointer(), Obstacles())
                        : nullptr),
        moving_(obstacles_.move()),
        q_(start),
        next_(start.size()) {
    motion_.n = static_cast<std::size_t>(start.size());
  }

  RolloutResult run() {
    motion_.sample(t_, q_);
    look(q_, t_, here_);
    motion_.left = distance(q_, t_);
    if (motion_.left <= settings_.tolerance) return finish(stand(Status::reached));
    best_ = motion_.left;
    for (;;) {
      if (const auto ended = step()) return finish(*ended);
    }
  }

 private:
  // Ends the motion where it stands.
  Status stand(Status status) {
    motion_.visit(t_, q_, Vector::Zero(q_.size()));
    return status;
  }

  // Makes a step. Returns how the motion ends, if it does.
  std::optional<Status> step() {
    const double duration = std::min(settings_.dt, settings_.max_time - t_);
    const Vector velocity = method_.velocity(here_.seen, tasks_, gains_, safety_, settings_.dt);
    ++motion_.evaluations;
    singular_.look(t_, method_.projection.lost_error(), settings_.tolerance);
    if (t_ - singular_.since > settings_.patience) return stand(Status::singular);
    double share = choose_share(velocity, duration);
    if (share < 0.0) {
      if (!moving_ || !method_.keeps_equalities(velocity, 0.0)) return stand(Status::stalled);
      if (!can_stand_still(duration)) return stand(Status::overrun);
      share = 0.0;
      next_ = q_;
      look(next_, t_ + duration, there_);
    }
    motion_.visit(t_, q_, share * velocity);
    const double before = motion_.left;
    motion_.left = distance(next_, t_ + duration);
    if (motion_.left <= settings_.tolerance) {
      arrive(before, duration);
      return Status::reached;
    }
    return advance();
  }

  // The largest share of a step that is safe; among moving obstacles at least one without contact. Negative if there is
  // none. Sets next_ and there_.
  double choose_share(const Vector& velocity, double duration) {
    double free_share = -1.0;
    for (int halving = 0; halving <= HALVINGS + 1; ++halving) {
      const double share = halving <= HALVINGS ? std::ldexp(1.0, -halving) : 0.0;
      if (!method_.keeps_equalities(velocity, share)) continue;
      if (!set_next(share * duration * velocity)) continue;
      if (!moving_ && next_ == q_) return -1.0;
      look(next_, t_ + duration, there_);
      const Step step = judge_.judge(here_, there_);
      if (step == Step::safe) return share;
      if (step == Step::free && free_share < 0.0) free_share = share;
    }
    if (!moving_ || free_share < 0.0) return -1.0;
    if (!set_next(free_share * duration * velocity)) return -1.0;
    look(next_, t_ + duration, there_);
    return free_share;
  }

  // Sets where a change leads, brought back onto what is kept. False if it cannot be.
  bool set_next(const Vector& change) {
    const Limits& limits = method_.scene.robot().limits;
    next_ = (q_ + change).cwiseMin(limits.upper).cwiseMax(limits.lower);
    return project(next_);
  }

  bool project(Vector& q) {
    if (!safety_.constraints) return true;
    Posture found = projection_->solve(q, *safety_.constraints, -INFINITE);
    q = std::move(found.q);
    return found.reached;
  }

  // What fast obstacles do in a step may take a closer look to tell.
  bool can_stand_still(double duration) {
    Certifier certifier(method_.scene.kinematics().robot_pointer(), obstacles_);
    Rows still(2, q_.size());
    still << q_.transpose(), q_.transpose();
    const Vector times = Eigen::Vector2d(t_, t_ + duration);
    const Certificate certificate = certifier.certify(SampledMotion(times, still, Rows(0, q_.size())));
    if (!certificate.certified) overrun_ = certificate.contact;
    return certificate.certified;
  }

  // Ends the motion where in the step the distance falls to the tolerance.
  void arrive(double before, double duration) {
    Vector at(q_.size());
    const auto excess = [&](double share) {
      at = q_ + share * (next_ - q_);
      return distance(at, t_ + share * duration) - settings_.tolerance;
    };
    double share = 1.0;
    if (const double after = excess(1.0); after < 0.0) {
      std::uintmax_t steps = MAX_SHARE_STEPS;
      const auto close = [](double a, double b) { return b - a <= SHARE_PRECISION; };
      const double left = before - settings_.tolerance;
      share = boost::math::tools::toms748_solve(excess, 0.0, 1.0, left, after, close, steps).second;
    }
    share = std::max(share, SHORTEST);
    motion_.left = excess(share) + settings_.tolerance;
    t_ += share * duration;
    at = q_ + share * (next_ - q_);
    project(at);
    motion_.sample(t_, at);
  }

  std::optional<Status> advance() {
    t_ = std::min(settings_.dt * static_cast<double>(motion_.t.size()), settings_.max_time);
    q_ = next_;
    std::swap(here_, there_);
    motion_.sample(t_, q_);
    if (motion_.left < (1.0 - PROGRESS) * best_) {
      best_ = motion_.left;
      best_t_ = t_;
    }
    if (!moving_ && t_ - best_t_ > settings_.progress) return Status::stalled;
    if (t_ > settings_.max_time - SHORTEST * settings_.dt) return Status::time_limit;
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - began_;
    if (taken.count() > settings_.planning_time) return Status::out_of_time;
    return std::nullopt;
  }

  void look(const Vector& q, double t, Place& place) {
    method_.observe(q, t, gains_, safety_, place.seen);
    SweptDistance::snapshot(t, method_.scene.kinematics(), place.snapshot);
    const auto before = [](const Nearest& a, const Nearest& b) { return a.pair < b.pair; };
    for (auto* pairs : {&place.seen.near.obstacles, &place.seen.near.pieces}) {
      std::sort(pairs->begin(), pairs->end(), before);
    }
  }

  double distance(const Vector& q, double t) {
    const Kinematics& kinematics = method_.scene.kinematics();
    if (kinematics.configuration() != q) method_.scene.move_hands_to(q);
    tasks_.error(kinematics, t, error_);
    return error_.norm();
  }

  RolloutResult finish(Status status) {
    motion_.status = status;
    return {std::move(motion_), overrun_};
  }

  SafeVelocity& method_;
  const TaskStack& tasks_;
  const Gains& gains_;
  const Safety& safety_;
  const Settings& settings_;
  const Obstacles& obstacles_;
  StepJudge judge_;
  std::unique_ptr<InverseKinematics> projection_;  // None where nothing is kept.
  bool moving_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  Place here_, there_;
  Vector q_, next_, error_;
  double t_ = 0.0, best_ = INFINITE, best_t_ = 0.0;
  SingularityWatch singular_;
  Integration motion_;
  std::optional<Contact> overrun_;
};

}  // namespace

RolloutResult rollout(SafeVelocity& method, const Vector& start, const TaskStack& tasks, const Gains& gains,
                      const Safety& safety, const Settings& settings) {
  return Rollout(method, start, tasks, gains, safety, settings).run();
}

}  // namespace humanoid_rail
