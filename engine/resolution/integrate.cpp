#include "integrate.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <boost/math/tools/toms748_solve.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/dense_output_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>

namespace humanoid_rail {

namespace {

namespace odeint = boost::numeric::odeint;

using Coordinates = std::vector<double>;
using DormandPrince = odeint::runge_kutta_dopri5<Coordinates>;

Eigen::Map<const Vector> vector(const Coordinates& q) { return {q.data(), static_cast<Eigen::Index>(q.size())}; }

// The error of a step in units of the tolerances: root mean square over the coordinates, as in Hairer, Norsett and
// Wanner, Solving ordinary differential equations I, II.4, and in SciPy; odeint's own takes the maximum.
class ErrorNorm : public odeint::default_error_checker<double, odeint::range_algebra, odeint::default_operations> {
 public:
  ErrorNorm(double atol, double rtol) : default_error_checker(atol, rtol, 1.0, 0.0) {}

  double error(odeint::range_algebra& algebra, const Coordinates& q, const Coordinates& q_dot, Coordinates& errors,
               double dt) const {
    default_error_checker::error(algebra, q, q_dot, errors, dt);  // Scales the errors in place.
    return vector(errors).norm() / std::sqrt(static_cast<double>(errors.size()));
  }
};

using Controlled = odeint::controlled_runge_kutta<DormandPrince, ErrorNorm>;
using Stepper = odeint::dense_output_runge_kutta<Controlled>;

// The first step, in units of the fastest time constant; from there the error decides.
constexpr double FIRST_STEP = 0.01;

// A last multiple of dt that is the end up to this share of it would make an interval of no length.
constexpr double ROUNDING = 1e-9;
// The time of arrival is precise to this, s.
constexpr double TIME_PRECISION = 1e-12;
// The search for the time of arrival takes at most this many steps.
constexpr std::uintmax_t MAX_TIME_STEPS = 100;

// The velocity is no number, so the integrator cannot go on.
struct NotFinite : std::runtime_error {
  NotFinite() : std::runtime_error("q_dot is not finite") {}
};

// q_dot as odeint wants it, counted, with the latest evaluation remembered: the last one in a step is at its end.
class Velocity {
 public:
  Velocity(SceneKinematics& scene, GradientProjection& method, const TaskStack& tasks, const Gains& gains)
      : scene_(scene), method_(method), tasks_(tasks), gains_(gains) {}

  void operator()(const Coordinates& q, Coordinates& q_dot, double t) { q_dot = at(q, t); }

  const Coordinates& at(const Coordinates& q, double t) {
    if (latest_q_ != q || latest_t_ != t) {
      scene_.observe(vector(q), t, gains_.horizon(), -INFINITE, seen_);
      const Vector& velocity = method_.velocity(scene_, seen_, tasks_, gains_);
      if (!velocity.allFinite()) throw NotFinite();
      latest_q_ = q;
      latest_t_ = t;
      latest_.assign(velocity.begin(), velocity.end());
      ++evaluations_;
    }
    return latest_;
  }

  // |e| where q_dot was asked for last, and at another configuration.
  [[nodiscard]] double distance() const { return method_.error().norm(); }
  [[nodiscard]] double distance(const Coordinates& q, double t) {
    tasks_.error(scene_.move_hands_to(vector(q)), t, error_);
    return error_.norm();
  }
  [[nodiscard]] double lost_error() const { return method_.lost_error(); }
  [[nodiscard]] int evaluations() const { return evaluations_; }

 private:
  SceneKinematics& scene_;
  GradientProjection& method_;
  const TaskStack& tasks_;
  const Gains& gains_;
  int evaluations_ = 0;
  Observation seen_;
  Vector error_;
  Coordinates latest_q_;
  double latest_t_ = 0.0;
  Coordinates latest_;
};

// One integration, step by step.
class Integrator {
 public:
  Integrator(Velocity velocity, const Vector& start, const Gains& gains, const Settings& settings)
      : velocity_(std::move(velocity)),
        settings_(settings),
        first_step_(std::min(FIRST_STEP / gains.gain.maxCoeff(), settings.max_time)),
        stepper_(Controlled(ErrorNorm(settings.atol, settings.rtol))),
        q_(start.begin(), start.end()),
        between_(q_.size()) {
    result_.n = q_.size();
  }

  Integration run() {
    result_.left = velocity_.distance(q_, 0.0);
    if (result_.left <= settings_.tolerance) {
      result_.visit(end_, vector(q_), Vector::Zero(static_cast<Eigen::Index>(q_.size())));
      return finish(Status::reached);
    }
    try {
      result_.visit(end_, vector(q_), vector(velocity_.at(q_, 0.0)));
      stepper_.initialize(q_, 0.0, first_step_);
      for (;;) {
        if (const auto ended = step()) return finish(*ended);
      }
    } catch (const odeint::odeint_error& error) {  // Steps that get ever smaller, among others.
      result_.broken = error.what();
    } catch (const NotFinite& error) {
      result_.broken = error.what();
    }
    return finish(Status::stalled);
  }

 private:
  // Makes a step. Returns how the motion ends, if it does.
  std::optional<Status> step() {
    const auto [from, to] = stepper_.do_step(std::ref(velocity_));  // odeint takes functions by value.
    end_ = std::min(to, settings_.max_time);
    if (to <= settings_.max_time) {
      q_ = stepper_.current_state();
    } else {
      stepper_.calc_state(end_, q_);
    }
    const Coordinates& q_dot = velocity_.at(q_, end_);
    result_.left = velocity_.distance();
    if (result_.left <= settings_.tolerance) {
      end_ = time_of_arrival(from, end_);
      stepper_.calc_state(end_, q_);
      sample_step();
      return Status::reached;
    }
    result_.visit(end_, vector(q_), vector(q_dot));
    sample_step();
    const double lost = velocity_.lost_error();
    singular_.look(end_, lost, settings_.tolerance);
    const bool exhausted = velocity_.evaluations() > settings_.max_evaluations;
    if (end_ - singular_.since > settings_.patience || (exhausted && lost > settings_.tolerance)) {
      return Status::singular;
    }
    if (exhausted) return Status::stalled;
    if (end_ >= settings_.max_time) return Status::time_limit;
    return std::nullopt;
  }

  void sample_step() {
    const double last = end_ - ROUNDING * std::min(settings_.dt, end_);
    for (double t; (t = settings_.dt * static_cast<double>(result_.t.size())) < last;) {
      stepper_.calc_state(t, between_);
      result_.sample(t, vector(between_));
    }
  }

  // When in a step the distance falls to the tolerance.
  double time_of_arrival(double from, double to) {
    Coordinates q(q_.size());
    const auto excess = [&](double t) {
      stepper_.calc_state(t, q);
      return velocity_.distance(q, t) - settings_.tolerance;
    };
    // Interpolated, the ends of the step may miss by rounding what the steps themselves reached.
    const double before = excess(from), after = excess(to);
    if (after >= 0.0) return to;
    if (before <= 0.0) return from;
    std::uintmax_t iterations = MAX_TIME_STEPS;
    const auto close = [](double a, double b) { return b - a <= TIME_PRECISION; };
    return boost::math::tools::toms748_solve(excess, from, to, before, after, close, iterations).second;
  }

  Integration finish(Status status) {
    result_.sample(end_, vector(q_));
    result_.status = status;
    result_.evaluations = velocity_.evaluations();
    return std::move(result_);
  }

  Velocity velocity_;
  const Settings& settings_;
  double first_step_;
  Stepper stepper_;
  Coordinates q_, between_;
  double end_ = 0.0;
  SingularityWatch singular_;
  Integration result_;
};

}  // namespace

void Integration::sample(double time, const Eigen::Ref<const Vector>& at) {
  t.push_back(time);
  q.insert(q.end(), at.begin(), at.end());
}

void Integration::visit(double time, const Eigen::Ref<const Vector>& at, const Eigen::Ref<const Vector>& velocity) {
  visited_t.push_back(time);
  visited_q.insert(visited_q.end(), at.begin(), at.end());
  visited_velocity.insert(visited_velocity.end(), velocity.begin(), velocity.end());
}

Integration integrate(SceneKinematics& scene, GradientProjection& method, const Vector& start, const TaskStack& tasks,
                      const Gains& gains, const Settings& settings) {
  return Integrator(Velocity(scene, method, tasks, gains), start, gains, settings).run();
}

}  // namespace humanoid_rail
