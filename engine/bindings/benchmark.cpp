#include "../benchmark/library_calls.hpp"

#include "bindings.hpp"
#include "guard.hpp"

namespace humanoid_rail {

void bind_benchmark(nb::module_& module) {
  using Guard = Guarded<SafeVelocity>;
  module.def(
      "library_call_seconds",
      [](const Robot& robot, const Obstacles& obstacles, const Matrix& configurations, int repeats) {
        check_size("configurations", configurations.cols(), robot.n());
        return interruptibly([&] { return library_call_seconds(robot, obstacles, configurations, repeats); });
      },
      "robot"_a, "obstacles"_a, "configurations"_a, "repeats"_a,
      "Seconds of the bare Pinocchio and coal calls that one evaluation of eq. 4.9 is made of.");
  module.def(
      "velocity_seconds",
      [](Guard& kinematics, const Matrix& configurations, const TaskStack& tasks, const Gains& gains, int repeats) {
        check_size("configurations", configurations.cols(), kinematics.constant().scene.robot().n());
        check_size("gain", gains.gain.size(), tasks.rows());
        return kinematics.with(
            [&](SafeVelocity& with) { return velocity_seconds(with, configurations, tasks, gains, repeats); });
      },
      "kinematics"_a, "configurations"_a, "tasks"_a, "gains"_a, "repeats"_a,
      "Seconds of one evaluation of eq. 4.9, called from C++.");
  module.def(
      "safe_velocity_seconds",
      [](Guard& kinematics, const Matrix& configurations, const TaskStack& tasks, const Gains& gains,
         const Safety& safety, double dt, int repeats) {
        check_size("configurations", configurations.cols(), kinematics.constant().scene.robot().n());
        check_size("gain", gains.gain.size(), tasks.rows());
        return kinematics.with([&](SafeVelocity& with) {
          return safe_velocity_seconds(with, configurations, tasks, gains, safety, dt, repeats);
        });
      },
      "kinematics"_a, "configurations"_a, "tasks"_a, "gains"_a, "safety"_a, "dt"_a, "repeats"_a,
      "Seconds of one safe velocity, called from C++.");
}

}  // namespace humanoid_rail
