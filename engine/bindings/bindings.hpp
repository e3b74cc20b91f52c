// What the files of the bindings share.
#pragma once

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "../types.hpp"
#include "interpreter.hpp"

namespace humanoid_rail {

namespace nb = nanobind;
using namespace nb::literals;

void bind_model(nb::module_& module);
void bind_scene(nb::module_& module);
void bind_kinematics(nb::module_& module);
void bind_tasks(nb::module_& module);
void bind_collision(nb::module_& module);
void bind_options(nb::module_& module);
void bind_resolution(nb::module_& module);
void bind_search(nb::module_& module);
void bind_follower(nb::module_& module);
void bind_optimisation(nb::module_& module);
void bind_benchmark(nb::module_& module);

inline void check_size(const char* what, Eigen::Index given, Eigen::Index size) {
  if (given == size) return;
  throw std::invalid_argument(std::string(what) + " needs " + std::to_string(size) + " numbers, not " +
                              std::to_string(given));
}

inline void check_finite(const char* what, const Eigen::Ref<const Rows>& given) {
  if (!given.allFinite()) throw std::invalid_argument(std::string(what) + " needs finite numbers");
}

inline void check_configuration(const char* what, const Eigen::Ref<const Vector>& q, int n) {
  check_size(what, q.size(), n);
  check_finite(what, q.transpose());
}

inline void check_time(double t) {
  if (!std::isfinite(t)) throw std::invalid_argument("t needs a finite number");
}

// A Python function that C++ may keep, copy and drop without the interpreter's lock, and that takes it to be called.
class Callback {
 public:
  // `what` says in errors what the function is.
  Callback(const char* what, nb::callable function)
      : what_(what), function_(new nb::callable(std::move(function)), [](nb::callable* kept) {
          if (!nb::is_alive()) return;  // The interpreter has gone, and its objects with it.
          const LockAcquire acquire;
          delete kept;
        }) {}

  template <class Result>
  [[nodiscard]] Result call(const Vector& q, double t) const {
    const LockAcquire acquire;
    const nb::object returned = (*function_)(q, t);
    Result result;
    if (nb::try_cast(returned, result)) return result;
    const std::string type = nb::cast<std::string>(returned.type().attr("__name__"));
    throw nb::type_error((std::string(what_) + " must not return a " + type).c_str());
  }

 private:
  const char* what_;
  std::shared_ptr<nb::callable> function_;
};

}  // namespace humanoid_rail
