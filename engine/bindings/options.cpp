#include "../resolution/integrate.hpp"
#include "../resolution/qp.hpp"
#include "bindings.hpp"

namespace humanoid_rail {

namespace {

void bind_gains(nb::module_& module) {
  nb::class_<Gains>(module, "Gains", "Parameters of eq. 4.9.")
      .def(
          "__init__",
          [](Gains* self, const Vector& gain, double c_mu, double c_kappa, double epsilon, double singular_value,
             std::optional<nb::callable> objective) {
            new (self) Gains{gain, c_mu, c_kappa, epsilon, singular_value, {}};
            if (!objective) return;
            self->objective = [callback = Callback("an objective", std::move(*objective))](const Vector& q, double t) {
              return callback.call<Vector>(q, t);
            };
          },
          "gain"_a, "c_mu"_a, "c_kappa"_a, "epsilon"_a, "singular_value"_a, "objective"_a = nb::none());
}

void bind_safety(nb::module_& module) {
  nb::class_<Safety>(module, "Safety", "Parameters of the constraints of the safe velocity.")
      .def(
          "__init__",
          [](Safety* self, double distance, double gain, double horizon, double margin_share, double least_margin,
             double limit_gain, double task_weight, double least_rate, double fastest, double precision,
             std::vector<double> shares, std::optional<nb::callable> equality,
             std::shared_ptr<const TaskStack> constraints) {
            if (!(distance >= 0.0) || !(gain > 0.0)) throw std::invalid_argument("a distance and a gain are positive");
            new (self) Safety{distance,
                              gain,
                              horizon,
                              margin_share,
                              least_margin,
                              limit_gain,
                              task_weight,
                              least_rate,
                              fastest,
                              precision,
                              std::move(shares),
                              {},
                              std::move(constraints)};
            if (!equality) return;
            self->equality = [callback = Callback("an equality", std::move(*equality))](const Vector& q, double t) {
              return callback.call<std::pair<Matrix, Vector>>(q, t);
            };
          },
          nb::kw_only(), "distance"_a, "gain"_a, "horizon"_a, "margin_share"_a, "least_margin"_a, "limit_gain"_a,
          "task_weight"_a, "least_rate"_a, "fastest"_a, "precision"_a, "shares"_a, "equality"_a = nb::none(),
          "constraints"_a = nb::none());
}

void bind_settings(nb::module_& module) {
  nb::class_<Settings>(module, "Settings", "When a motion ends, and how precisely it is integrated.")
      .def(
          "__init__",
          [](Settings* self, double tolerance, double dt, double max_time, double rtol, double atol,
             int max_evaluations, double patience, double progress, double planning_time) {
            for (double number : {tolerance, dt, max_time, rtol, atol}) {
              if (!(number > 0.0)) throw std::invalid_argument("settings need numbers greater than 0");
            }
            new (self)
                Settings{tolerance, dt, max_time, rtol, atol, max_evaluations, patience, progress, planning_time};
          },
          nb::kw_only(), "tolerance"_a, "dt"_a, "max_time"_a, "rtol"_a, "atol"_a, "max_evaluations"_a, "patience"_a,
          "progress"_a, "planning_time"_a);
}

}  // namespace

void bind_options(nb::module_& module) {
  bind_gains(module);
  bind_safety(module);
  bind_settings(module);
}

}  // namespace humanoid_rail
