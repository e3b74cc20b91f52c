#include "../kinematics/task.hpp"

#include "bindings.hpp"

namespace humanoid_rail {

void bind_tasks(nb::module_& module) {
  using Point = Eigen::Vector3d;
  nb::class_<Task>(module, "Task", "Something to be reached: an error that is to become 0.");
  nb::class_<PointTask, Task>(module, "PointTask", "A point of a hand that has to be at a place.")
      .def(nb::init<int, const Point&, const Point&>(), "hand"_a, "offset"_a, "target"_a);
  nb::class_<DirectionTask, Task>(module, "DirectionTask", "A hand that has to point in a direction.")
      .def(nb::init<int, const Point&, const Point&, double>(), "hand"_a, "pointing"_a, "direction"_a, "lever"_a);
  nb::class_<RelativeTask, Task>(module, "RelativeTask", "Two hands that have to be in a relation.")
      .def(nb::init<int, int, const Point&, bool>(), "first"_a, "second"_a, "difference"_a, "in_first"_a = false);
  nb::class_<DistanceTask, Task>(module, "DistanceTask", "Two hands that have to be at a distance.")
      .def(nb::init<int, int, double>(), "first"_a, "second"_a, "distance"_a);
  using Across = LineTask::Across;
  nb::class_<LineTask, Task>(module, "LineTask", "A point of a hand that has to be on a line.")
      .def(nb::init<int, const Point&, const Point&, const Across&>(), "hand"_a, "offset"_a, "point"_a, "across"_a);
  nb::class_<AxisTask, Task>(module, "AxisTask", "An axis of a hand that has to lie along a direction.")
      .def(nb::init<int, const Point&, const Point&, const Across&, double>(), "hand"_a, "axis"_a, "direction"_a,
           "across"_a, "lever"_a);
  nb::class_<OrientationTask, Task>(module, "OrientationTask", "A hand that has to be turned in one way.")
      .def(nb::init<int, const Eigen::Matrix3d&, int, double>(), "hand"_a, "rotation"_a, "reference"_a, "lever"_a);
  nb::class_<ConfigurationTask, Task>(module, "ConfigurationTask", "Joints that have to be at positions.")
      .def(nb::init<std::vector<int>, Vector>(), "joints"_a, "target"_a);
  using Inner = std::shared_ptr<const Task>;
  nb::class_<WithinBoxTask, Task>(module, "WithinBoxTask", "A task that is done within a tolerance along axes.")
      .def(nb::init<Inner, Matrix, Vector>(), "task"_a, "axes"_a, "tolerance"_a);
  nb::class_<WithinBallTask, Task>(module, "WithinBallTask", "A task that is done within a tolerance of its norm.")
      .def(nb::init<Inner, double>(), "task"_a, "tolerance"_a);
  nb::class_<FunctionTask, Task>(module, "FunctionTask", "A task that is computed in Python.")
      .def(
          "__init__",
          [](FunctionTask* self, Eigen::Index rows, nb::callable function) {
            new (self)
                FunctionTask(rows, [callback = Callback("a task", std::move(function))](const Vector& q, double t) {
                  return callback.call<std::pair<Vector, Matrix>>(q, t);
                });
          },
          "rows"_a, "function"_a);
  nb::class_<TaskStack>(module, "TaskStack", "Tasks one below the other.")
      .def(nb::init<std::vector<std::shared_ptr<const Task>>>(), "tasks"_a)
      .def_prop_ro("rows", &TaskStack::rows);
}

}  // namespace humanoid_rail
