#include "../optimisation/clearance_rows.hpp"
#include "bindings.hpp"
#include "guard.hpp"

namespace humanoid_rail {

void bind_optimisation(nb::module_& module) {
  nb::class_<ClearanceRows>(module, "ClearanceRows", "The pairs that a small change of samples may bring too near.")
      .def_ro("sample", &ClearanceRows::sample)
      .def_ro("spare", &ClearanceRows::spare)
      .def_ro("gradient", &ClearanceRows::gradient)
      .def_ro("least", &ClearanceRows::least);
  using Guard = Guarded<SceneKinematics>;
  nb::class_<Guard>(module, "MotionClearance", "How near a robot is to everything at samples of a motion.")
      .def(nb::init<std::shared_ptr<const Robot>, const Obstacles&>(), "robot"_a, "obstacles"_a)
      .def(
          "rows",
          [](Guard& self, const Eigen::Ref<const Rows>& samples, double distance, double horizon,
             const Eigen::Ref<const Vector>& reach) {
            check_size("a sample", samples.cols(), self.constant().robot().n());
            check_finite("samples", samples);
            check_size("reach", reach.size(), self.constant().robot().n());
            return self.with(
                [&](SceneKinematics& scene) { return clearance_rows(scene, samples, distance, horizon, reach); });
          },
          "samples"_a, "distance"_a, "horizon"_a, "reach"_a);
}

}  // namespace humanoid_rail
