// What Python sees of the engine, a file a room.
#include <coal/config.hh>
#include <pinocchio/config.hpp>

#include "../resolution/rollout.hpp"
#include "bindings.hpp"

namespace humanoid_rail {

NB_MODULE(_engine, module) {
  module.doc() = "The native engine: velocities, motions and proofs on Pinocchio and coal, in C++.";
  // What an exception keeps at exit, a callback that it came through among others, is no leak to warn a user of.
  nb::set_leak_warnings(false);
  module.attr("PINOCCHIO_VERSION") = PINOCCHIO_VERSION;
  module.attr("COAL_VERSION") = COAL_VERSION;
  module.attr("CONTACT") = CONTACT;
  module.attr("RESOLUTION") = RESOLUTION;
  module.attr("MAX_CHECKS") = MAX_CHECKS;
  module.attr("APART") = APART;
  module.attr("PROGRESS") = PROGRESS;
  prepare_for_interpreter();
  bind_model(module);
  bind_scene(module);
  bind_tasks(module);
  bind_kinematics(module);
  bind_collision(module);
  bind_options(module);
  bind_resolution(module);
  bind_search(module);
  bind_follower(module);
  bind_optimisation(module);
  bind_benchmark(module);
}

}  // namespace humanoid_rail
