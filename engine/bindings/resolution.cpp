#include "../kinematics/evaluation.hpp"
#include "../resolution/rollout.hpp"
#include "../resolution/step_judge.hpp"
#include "bindings.hpp"
#include "guard.hpp"

namespace humanoid_rail {

namespace {

using Guard = Guarded<SafeVelocity>;

Rows rows(const std::vector<double>& values, std::size_t columns) {
  const auto n = static_cast<Eigen::Index>(columns);
  return Eigen::Map<const Rows>(values.data(), static_cast<Eigen::Index>(values.size()) / n, n);
}

Vector vector(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

int joints(const Guard& self) { return self.constant().scene.robot().n(); }

void check_gains(const Gains& gains, const TaskStack& tasks) { check_size("gain", gains.gain.size(), tasks.rows()); }

void bind_motions(nb::module_& module) {
  nb::enum_<Status>(module, "Status", "What became of the tasks.")
      .value("REACHED", Status::reached)
      .value("STALLED", Status::stalled)
      .value("TIME_LIMIT", Status::time_limit)
      .value("SINGULAR", Status::singular)
      .value("OVERRUN", Status::overrun)
      .value("OUT_OF_TIME", Status::out_of_time);
  nb::class_<Integration>(module, "Integration", "A sampled motion and why it ended.")
      .def_ro("status", &Integration::status)
      .def_ro("left", &Integration::left)
      .def_ro("evaluations", &Integration::evaluations)
      .def_ro("broken", &Integration::broken)
      .def_prop_ro("t", [](const Integration& self) { return vector(self.t); })
      .def_prop_ro("q", [](const Integration& self) { return rows(self.q, self.n); })
      .def_prop_ro("visited", [](const Integration& self) {
        return std::make_tuple(vector(self.visited_t), rows(self.visited_q, self.n),
                               rows(self.visited_velocity, self.n));
      });
}

void bind_evaluations(nb::class_<Guard>& kinematics) {
  kinematics
      .def(
          "state",
          [](Guard& self, const Eigen::Ref<const Vector>& q, double t) {
            check_configuration("q", q, joints(self));
            check_time(t);
            return self.with([&](SafeVelocity& with) { return state(with.scene, q, t); });
          },
          "q"_a, "t"_a)
      .def(
          "measure",
          [](Guard& self, const Eigen::Ref<const Vector>& q, double t, double horizon) {
            check_configuration("q", q, joints(self));
            check_time(t);
            return self.with([&](SafeVelocity& with) { return measure(with.scene, q, t, horizon); });
          },
          "q"_a, "t"_a, "horizon"_a)
      .def(
          "along",
          [](Guard& self, const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q, double horizon) {
            check_size("q", q.cols(), joints(self));
            check_size("t", t.size(), q.rows());
            check_finite("q", q);
            return self.with([&](SafeVelocity& with) { return along(with.scene, t, q, horizon); });
          },
          "t"_a, "q"_a, "horizon"_a);
}

void bind_velocities(nb::class_<Guard>& kinematics) {
  kinematics
      .def(
          "projection_velocity",
          [](Guard& self, const Eigen::Ref<const Vector>& q, double t, const TaskStack& tasks, const Gains& gains) {
            check_configuration("q", q, joints(self));
            check_gains(gains, tasks);
            return self.with([&](SafeVelocity& with) { return Vector(with.projection_velocity(q, t, tasks, gains)); });
          },
          "q"_a, "t"_a, "tasks"_a, "gains"_a, "q_dot of eq. 4.9.")
      .def(
          "velocity",
          [](Guard& self, const Eigen::Ref<const Vector>& q, double t, const TaskStack& tasks, const Gains& gains,
             const Safety& safety, double dt) {
            check_configuration("q", q, joints(self));
            check_gains(gains, tasks);
            return self.with([&](SafeVelocity& with) { return Vector(with.velocity(q, t, tasks, gains, safety, dt)); });
          },
          "q"_a, "t"_a, "tasks"_a, "gains"_a, "safety"_a, "dt"_a, "q_dot of the quadratic program.")
      .def(
          "reachable_velocity",
          [](Guard& self, const Eigen::Ref<const Vector>& q, double t, const TaskStack& tasks, const Gains& gains,
             const Safety& safety, double dt, const Vector& lower, const Vector& upper, const Vector& fallback) {
            check_configuration("q", q, joints(self));
            check_gains(gains, tasks);
            for (const Vector* part : {&lower, &upper, &fallback})
              check_configuration("reachable", *part, joints(self));
            return self.with([&](SafeVelocity& with) {
              Observation seen;
              with.observe(q, t, gains, safety, seen);
              return Vector(with.velocity(seen, tasks, gains, safety, dt, {lower, upper, fallback}));
            });
          },
          "q"_a, "t"_a, "tasks"_a, "gains"_a, "safety"_a, "dt"_a, "lower"_a, "upper"_a, "fallback"_a,
          "The same among the velocities that can be had.")
      .def(
          "constraints",
          [](Guard& self) {
            return self.with([](SafeVelocity& with) { return std::make_pair(with.rows(), with.sides()); });
          },
          "The rows and sides of the last velocity's program.");
}

void bind_followers(nb::class_<Guard>& kinematics) {
  kinematics
      .def(
          "integrate",
          [](Guard& self, const Vector& start, const TaskStack& tasks, const Gains& gains, const Settings& settings) {
            check_configuration("start", start, joints(self));
            check_gains(gains, tasks);
            return self.with([&](SafeVelocity& with) {
              return integrate(with.scene, with.projection, start, tasks, gains, settings);
            });
          },
          "start"_a, "tasks"_a, "gains"_a, "settings"_a)
      .def(
          "rollout",
          [](Guard& self, const Vector& start, const TaskStack& tasks, const Gains& gains, const Safety& safety,
             const Settings& settings) {
            check_configuration("start", start, joints(self));
            check_gains(gains, tasks);
            RolloutResult result =
                self.with([&](SafeVelocity& with) { return rollout(with, start, tasks, gains, safety, settings); });
            return std::make_pair(std::move(result.motion), std::move(result.overrun));
          },
          "start"_a, "tasks"_a, "gains"_a, "safety"_a, "settings"_a);
}

void bind_step_judge(nb::module_& module) {
  nb::enum_<Step>(module, "Step", "What is known of a step of a rollout.")
      .value("SAFE", Step::safe)
      .value("FREE", Step::free)
      .value("BLOCKED", Step::blocked);
  struct Judge {
    Judge(const std::shared_ptr<const Robot>& robot, double safety_distance)
        : scene(robot, Obstacles()), judge(robot, Obstacles(), safety_distance) {}
    SceneKinematics scene;
    StepJudge judge;
  };
  using JudgeGuard = Guarded<Judge>;
  nb::class_<JudgeGuard>(module, "StepJudge", "Whether steps without obstacles are safe.")
      .def(nb::init<std::shared_ptr<const Robot>, double>(), "robot"_a, "safety_distance"_a)
      .def(
          "judge",
          [](JudgeGuard& self, const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b, double horizon) {
            const int n = self.constant().scene.robot().n();
            check_configuration("a", a, n);
            check_configuration("b", b, n);
            return self.with([&](Judge& with) {
              const auto place = [&](const Eigen::Ref<const Vector>& q) {
                Place at;
                with.scene.glance(q, 0.0, horizon, horizon, at.seen);
                SweptDistance::snapshot(0.0, with.scene.kinematics(), at.snapshot);
                return at;
              };
              return with.judge.judge(place(a), place(b));
            });
          },
          "a"_a, "b"_a, "horizon"_a,
          "Of the step from a to b; pairs farther apart than the horizon are not looked at.");
}

}  // namespace

void bind_resolution(nb::module_& module) {
  bind_motions(module);
  nb::class_<Guard> kinematics(module, "SafeVelocity",
                               "A robot among obstacles: what is true of it, and how it moves.");
  kinematics.def(nb::init<std::shared_ptr<const Robot>, const Obstacles&>(), "robot"_a, "obstacles"_a);
  bind_evaluations(kinematics);
  bind_velocities(kinematics);
  bind_followers(kinematics);
  bind_step_judge(module);
}

}  // namespace humanoid_rail
