#include "../following/follower_loop.hpp"
#include "bindings.hpp"

namespace humanoid_rail {

namespace {

using Point = Eigen::Vector3d;

std::shared_ptr<const Goal> goal(const TaskStack& tasks, const Gains& gains) {
  check_size("gain", gains.gain.size(), tasks.rows());
  // Its thread never waits for Python.
  if (gains.objective) throw std::invalid_argument("a follower takes no objectives");
  return std::make_shared<const Goal>(Goal{tasks, gains});
}

FollowerSettings settings(const Robot& robot, const Obstacles& obstacles, double dt, double tolerance,
                          const Vector& acceleration, const Vector& obstacle_speeds, double latency) {
  check_size("acceleration", acceleration.size(), robot.n());
  check_size("obstacle_speeds", obstacle_speeds.size(), obstacles.size());
  if (!(dt > 0.0) || !(tolerance > 0.0) || !(latency >= 0.0) || !(obstacle_speeds.array() >= 0.0).all()) {
    throw std::invalid_argument("a follower needs times, a tolerance and speeds that are no less than 0");
  }
  return {dt, tolerance, acceleration, obstacle_speeds, latency};
}

void bind_states(nb::module_& module) {
  nb::enum_<FollowerStatus>(module, "FollowerStatus", "What a robot does in a cycle.")
      .value("FOLLOWING", FollowerStatus::following)
      .value("REACHED", FollowerStatus::reached)
      .value("BRAKING", FollowerStatus::braking)
      .value("STOPPED", FollowerStatus::stopped);
  nb::class_<Nearest>(module, "Nearest", "The shortest line from a link to an obstacle or another link.")
      .def_ro("link", &Nearest::link)
      .def_ro("other", &Nearest::other)
      .def_prop_ro("with_obstacle", &Nearest::is_with_obstacle)
      .def_ro("distance", &Nearest::distance);
  nb::class_<FollowerState>(module, "FollowerState", "A robot at the end of a cycle.")
      .def_ro("cycle", &FollowerState::cycle)
      .def_ro("q", &FollowerState::q, nb::rv_policy::copy)
      .def_ro("velocity", &FollowerState::velocity, nb::rv_policy::copy)
      .def_ro("status", &FollowerState::status)
      .def_ro("left", &FollowerState::left)
      .def_ro("proven", &FollowerState::proven)
      .def_ro("stop", &FollowerState::stop, nb::rv_policy::copy)
      .def_ro("cycles_to_rest", &FollowerState::cycles_to_rest)
      .def_ro("jumped", &FollowerState::jumped)
      .def_ro("closest", &FollowerState::closest)
      .def_ro("blocking", &FollowerState::blocking);
  nb::class_<CycleTimes>(module, "CycleTimes", "How long cycles took.")
      .def_ro("cycles", &CycleTimes::cycles)
      .def_ro("overruns", &CycleTimes::overruns)
      .def_ro("longest", &CycleTimes::longest)
      .def("percentile", &CycleTimes::percentile, "share"_a);
}

}  // namespace

// Calls a method without the interpreter's lock: it may have to wait.
template <auto method>
auto released(FollowerLoop& self) {
  const LockRelease release;
  return (self.*method)();
}

void bind_follower(nb::module_& module) {
  bind_states(module);
  nb::class_<FollowerLoop>(module, "Follower", "Follows targets, cycle by cycle or in a thread of its own.")
      .def(
          "__init__",
          [](FollowerLoop* self, std::shared_ptr<const Robot> robot, const Obstacles& obstacles, const Vector& start,
             const TaskStack& tasks, const Gains& gains, const Safety& safety, double dt, double tolerance,
             const Vector& acceleration, const Vector& obstacle_speeds, double latency) {
            check_configuration("start", start, robot->n());
            if (safety.equality) throw std::invalid_argument("a follower takes no equalities");
            const auto options = settings(*robot, obstacles, dt, tolerance, acceleration, obstacle_speeds, latency);
            new (self) FollowerLoop(std::move(robot), obstacles, start, goal(tasks, gains), safety, options);
          },
          "robot"_a, "obstacles"_a, "start"_a, "tasks"_a, "gains"_a, "safety"_a, nb::kw_only(), "dt"_a, "tolerance"_a,
          "acceleration"_a, "obstacle_speeds"_a, "latency"_a)
      .def(
          "set_goal",
          [](FollowerLoop& self, const TaskStack& tasks, const Gains& gains) { self.set_goal(goal(tasks, gains)); },
          "tasks"_a, "gains"_a)
      .def(
          "move_obstacle",
          [](FollowerLoop& self, int obstacle, const Point& center, const Eigen::Matrix3d& rotation,
             const Point& velocity) {
            if (obstacle < 0 || obstacle >= self.obstacles()) throw std::out_of_range("no such obstacle");
            self.place(obstacle, {rotation, center}, velocity);
          },
          "obstacle"_a, "center"_a, "rotation"_a, "velocity"_a)
      .def(
          "step",
          [](FollowerLoop& self, bool brakes) {
            const LockRelease release;
            return self.step(brakes);
          },
          "brakes"_a)
      .def("start", &released<&FollowerLoop::start>)
      .def("stop", &released<&FollowerLoop::stop>)
      .def("end", &released<&FollowerLoop::end>)
      .def("state", &released<&FollowerLoop::state>)
      .def("times", &released<&FollowerLoop::times>)
      .def_prop_ro("is_running", &FollowerLoop::is_running)
      .def("contact", &FollowerLoop::contact, "A pair that touches where the robot is. Not while it runs.");
}

}  // namespace humanoid_rail
