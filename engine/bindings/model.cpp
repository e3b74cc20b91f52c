#include "../model/robot.hpp"

#include "bindings.hpp"

namespace humanoid_rail {

void bind_model(nb::module_& module) {
  nb::class_<Robot>(module, "Robot", "A robot's model, collision bodies, linear coupling and hands.")
      .def(
          "__init__",
          [](Robot* self, const std::string& model, const std::string& bodies, const Matrix& coupling,
             const Vector& offset, const std::vector<std::pair<std::size_t, std::vector<int>>>& hands,
             const std::vector<std::pair<int, int>>& self_collision_pairs, const Vector& pair_distances,
             const Vector& lower, const Vector& upper, const Vector& velocity_limit) {
            std::vector<Hand> converted;
            for (const auto& [frame, arm] : hands) converted.push_back({frame, arm});
            new (self) Robot(model, bodies, coupling, offset, converted, self_collision_pairs, pair_distances,
                             {lower, upper, velocity_limit});
          },
          "model"_a, "bodies"_a, "coupling"_a, "offset"_a, "hands"_a, "self_collision_pairs"_a, "pair_distances"_a,
          "lower"_a, "upper"_a, "velocity_limit"_a);
}

}  // namespace humanoid_rail
