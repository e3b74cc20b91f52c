#include "integration.hpp"

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

void append(Coordinates& rows, const Coordinates& row) { rows.insert(rows.end(), row.begin(), row.end()); }

// q_dot as odeint wants it, counted, with the latest evaluation remembered: the last one in a step is at its end.
class Velocity {
 public:
  Velocity(GradientProjection& method, const Vector& targets, const Gains& gains)
      : method_(method), targets_(targets), gains_(gains) {}

  void operator()(const Coordinates& q, Coordinates& q_dot, double t) { q_dot = at(q, t); }

  const Coordinates& at(const Coordinates& q, double t) {
    if (latest_q_ != q || latest_t_ != t) {
      const Vector& velocity = method_.velocity(vector(q), t, targets_, gains_);
      if (!velocity.allFinite()) throw std::runtime_error("q_dot is not finite");
      latest_q_ = q;
      latest_t_ = t;
      latest_.assign(velocity.begin(), velocity.end());
      ++evaluations;
    }
    return latest_;
  }

  double distance() const { return method_.error().norm(); }

  double distance(const Coordinates& q) {
    method_.kinematics.move_hands_to(vector(q));
    return (method_.kinematics.hands() - targets_).norm();
  }

  int evaluations = 0;

 private:
  GradientProjection& method_;
  const Vector& targets_;
  const Gains& gains_;
  Coordinates latest_q_;
  double latest_t_ = 0.0;
  Coordinates latest_;
};

// When in a step the distance falls to the tolerance.
double time_of_arrival(const Stepper& stepper, Velocity& velocity, double from, double to, double tolerance) {
  Coordinates q(stepper.current_state().size());
  const auto excess = [&](double t) {
    stepper.calc_state(t, q);
    return velocity.distance(q) - tolerance;
  };
  // Interpolated, the ends of the step may miss by rounding what the steps themselves reached.
  const double before = excess(from), after = excess(to);
  if (after >= 0.0) return to;
  if (before <= 0.0) return from;
  std::uintmax_t iterations = 100;
  const auto close = [](double a, double b) { return b - a <= 1e-12; };
  return boost::math::tools::toms748_solve(excess, from, to, before, after, close, iterations).second;
}

}  // namespace

Integration integrate(GradientProjection& method, const Vector& start, const Vector& targets, const Gains& gains,
                      const Settings& settings) {
  Integration result{};
  result.n = static_cast<std::size_t>(start.size());
  Velocity velocity(method, targets, gains);
  Stepper stepper(Controlled(ErrorNorm(settings.atol, settings.rtol)));
  Coordinates q(start.begin(), start.end()), between(q.size());
  double end = 0.0;

  const auto visit = [&](const Coordinates& q_dot) {
    result.visited_t.push_back(end);
    append(result.visited_q, q);
    append(result.visited_velocity, q_dot);
  };
  const auto sample = [&](double t, const Coordinates& at) {
    result.t.push_back(t);
    append(result.q, at);
  };
  const auto sample_step = [&] {
    // A last multiple of dt that is the end up to rounding would make an interval of no length.
    const double last = end - 1e-9 * std::min(settings.dt, end);
    for (double t; (t = settings.dt * static_cast<double>(result.t.size())) < last;) {
      stepper.calc_state(t, between);
      sample(t, between);
    }
  };
  const auto finish = [&](Status status) {
    sample(end, q);
    result.status = status;
    result.evaluations = velocity.evaluations;
    return std::move(result);
  };

  result.left = velocity.distance(q);
  if (result.left <= settings.tolerance) {
    visit(Coordinates(q.size(), 0.0));
    return finish(Status::reached);
  }
  double singular_since = INFINITE;
  try {
    visit(velocity.at(q, 0.0));
    stepper.initialize(q, 0.0, std::min(FIRST_STEP / gains.gain.maxCoeff(), settings.max_time));
    for (;;) {
      const auto [from, to] = stepper.do_step(std::ref(velocity));  // odeint takes functions by value.
      end = std::min(to, settings.max_time);
      if (to <= settings.max_time) {
        q = stepper.current_state();
      } else {
        stepper.calc_state(end, q);
      }
      const Coordinates& q_dot = velocity.at(q, end);
      result.left = velocity.distance();
      if (result.left <= settings.tolerance) {
        end = time_of_arrival(stepper, velocity, from, end, settings.tolerance);
        stepper.calc_state(end, q);
        sample_step();
        return finish(Status::reached);
      }
      visit(q_dot);
      sample_step();
      const bool held = method.is_held_by_singularity(settings.tolerance);
      singular_since = held ? std::min(singular_since, end) : INFINITE;
      const bool exhausted = velocity.evaluations > settings.max_evaluations;
      if (end - singular_since > settings.patience || (exhausted && held)) return finish(Status::singular);
      if (exhausted) return finish(Status::stalled);
      if (end >= settings.max_time) return finish(Status::time_limit);
    }
  } catch (const std::exception& error) {  // Steps that get ever smaller, among others.
    result.broken = error.what();
    return finish(Status::stalled);
  }
}

}  // namespace humanoid_rail
