#include "../kinematics/evaluation.hpp"
#include "../kinematics/inverse_kinematics.hpp"
#include "bindings.hpp"
#include "guard.hpp"

namespace humanoid_rail {

namespace {

void bind_values(nb::module_& module) {
  nb::class_<State>(module, "State", "Everything that is true of a robot among obstacles at a configuration.")
      .def_ro("hands", &State::hands)
      .def_ro("rotations", &State::rotations)
      .def_ro("jacobian", &State::jacobian)
      .def_ro("angular_jacobian", &State::angular_jacobian)
      .def_ro("manipulability", &State::manipulability)
      .def_ro("manipulability_gradient", &State::manipulability_gradient)
      .def_ro("clearance", &State::clearance)
      .def_ro("clearance_gradient", &State::clearance_gradient)
      .def_ro("piece_distance", &State::piece_distance)
      .def_ro("piece_gradient", &State::piece_gradient)
      .def_ro("piece_rate", &State::piece_rate)
      .def_ro("link_distance", &State::link_distance)
      .def_ro("link_gradient", &State::link_gradient);
  nb::class_<Measurement>(module, "Measurement", "The values of a state without its derivatives.")
      .def_ro("hands", &Measurement::hands)
      .def_ro("manipulability", &Measurement::manipulability)
      .def_ro("clearance", &Measurement::clearance)
      .def_ro("link_distance", &Measurement::link_distance);
  nb::class_<Course>(module, "Course", "What is true along a motion.")
      .def_ro("hands", &Course::hands)
      .def_ro("manipulability", &Course::manipulability)
      .def_ro("clearance", &Course::clearance);
  nb::class_<Posture>(module, "Posture", "A configuration that was found, and how good it is.")
      .def_ro("q", &Posture::q)
      .def_ro("error", &Posture::error)
      .def_ro("clearance", &Posture::clearance)
      .def_ro("reached", &Posture::reached);
}

}  // namespace

void bind_kinematics(nb::module_& module) {
  bind_values(module);
  using Guard = Guarded<InverseKinematics>;
  nb::class_<Guard>(module, "InverseKinematics", "Looks for configurations in which tasks are done.")
      .def(nb::init<std::shared_ptr<const Robot>, const Obstacles&>(), "robot"_a, "obstacles"_a)
      .def(
          "solve",
          [](Guard& self, const Eigen::Ref<const Vector>& start, const TaskStack& tasks, double distance) {
            check_configuration("start", start, self.constant().robot().n());
            return self.with([&](InverseKinematics& solver) { return solver.solve(start, tasks, distance); });
          },
          "start"_a, "tasks"_a, "distance"_a)
      .def(
          "reached",
          [](Guard& self, const Eigen::Ref<const Rows>& starts, const TaskStack& tasks, double distance) {
            check_size("starts", starts.cols(), self.constant().robot().n());
            check_finite("starts", starts);
            return self.with([&](InverseKinematics& solver) {
              std::vector<Vector> found;
              for (const auto& start : starts.rowwise()) {
                Posture posture = solver.solve(start.transpose(), tasks, distance);
                if (posture.reached) found.push_back(std::move(posture.q));
              }
              return found;
            });
          },
          "starts"_a, "tasks"_a, "distance"_a, "The configurations in which the tasks are done.")
      .def(
          "pulled",
          [](Guard& self, const Eigen::Ref<const Vector>& goal, const Eigen::Ref<const Vector>& start,
             const TaskStack& tasks, double distance) {
            check_configuration("goal", goal, self.constant().robot().n());
            check_configuration("start", start, self.constant().robot().n());
            return self.with([&](InverseKinematics& solver) { return solver.pulled(goal, start, tasks, distance); });
          },
          "goal"_a, "start"_a, "tasks"_a, "distance"_a)
      .def(
          "evaluate",
          [](Guard& self, const Eigen::Ref<const Vector>& q, const TaskStack& tasks) {
            check_configuration("q", q, self.constant().robot().n());
            return self.with([&](InverseKinematics& solver) { return solver.evaluate(q, tasks); });
          },
          "q"_a, "tasks"_a)
      .def(
          "errors",
          [](Guard& self, const Eigen::Ref<const Rows>& q, const TaskStack& tasks) {
            check_size("q", q.cols(), self.constant().robot().n());
            check_finite("q", q);
            return self.with([&](InverseKinematics& solver) {
              Rows errors(q.rows(), tasks.rows());
              for (Eigen::Index i = 0; i < q.rows(); ++i) errors.row(i) = solver.errors(q.row(i).transpose(), tasks);
              return errors;
            });
          },
          "q"_a, "tasks"_a, "The errors of the tasks at each configuration.");
}

}  // namespace humanoid_rail
