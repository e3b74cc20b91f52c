#include "../search/sampler.hpp"
#include "bindings.hpp"
#include "guard.hpp"

namespace humanoid_rail {

namespace {

using RobotPointer = std::shared_ptr<const Robot>;

void check_rows(const char* what, const Eigen::Ref<const Rows>& rows, int n) {
  check_size(what, rows.cols(), n);
  check_finite(what, rows);
  if (rows.rows() == 0) throw std::invalid_argument(std::string(what) + " needs a row");
}

std::tuple<std::optional<Rows>, Rows, long> plain(Sampled found) {
  return {std::move(found.path), std::move(found.explored), found.checks};
}

}  // namespace

void bind_search(nb::module_& module) {
  using Filter = Guarded<EdgeFilter>;
  nb::class_<Filter>(module, "EdgeFilter", "Whether a robot seems to keep its distance on an edge, from samples of it.")
      .def(nb::init<RobotPointer, const Obstacles&, double, double, bool>(), "robot"_a, "obstacles"_a, "distance"_a,
           "own_share"_a, "portable"_a = false)
      .def(
          "is_edge_free",
          [](Filter& self, const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b) {
            check_configuration("a", a, self.constant().robot().n());
            check_configuration("b", b, self.constant().robot().n());
            return self.with([&](EdgeFilter& filter) { return filter.is_edge_free(a, b); });
          },
          "a"_a, "b"_a);
  using Guard = Guarded<Sampler>;
  nb::class_<Guard>(module, "Sampler", "Paths by sampling: RRT-Connect, shortcuts, and the proof of what they find.")
      .def(nb::init<RobotPointer, const Obstacles&, double, double, const Vector&, std::shared_ptr<const TaskStack>>(),
           "robot"_a, "obstacles"_a, "distance"_a, "own_share"_a, "units"_a, "constraints"_a = nb::none())
      .def(
          "walk",
          [](Guard& self, const Eigen::Ref<const Vector>& from, const Eigen::Ref<const Vector>& to) {
            check_configuration("start", from, self.constant().robot().n());
            check_configuration("goal", to, self.constant().robot().n());
            return plain(self.with([&](Sampler& sampler) { return sampler.walk(from, to); }));
          },
          "start"_a, "goal"_a)
      .def(
          "connect",
          [](Guard& self, const Eigen::Ref<const Vector>& start, const Eigen::Ref<const Rows>& goals,
             const Vector& lower, const Vector& upper, double longest, std::uint64_t seed, long max_checks,
             double seconds) {
            const int n = self.constant().robot().n();
            check_configuration("start", start, n);
            check_rows("goals", goals, n);
            check_configuration("lower", lower, n);
            check_configuration("upper", upper, n);
            if (!(longest > 0.0)) throw std::invalid_argument("longest needs a number greater than 0");
            return plain(self.with([&](Sampler& sampler) {
              return sampler.connect(start, goals, {lower, upper}, longest, seed, {max_checks, seconds});
            }));
          },
          "start"_a, "goals"_a, "lower"_a, "upper"_a, "longest"_a, "seed"_a, "max_checks"_a, "seconds"_a)
      .def(
          "shorten",
          [](Guard& self, const Eigen::Ref<const Rows>& path, double shorter_than, std::uint64_t seed, long max_checks,
             double seconds) {
            check_rows("path", path, self.constant().robot().n());
            return plain(self.with(
                [&](Sampler& sampler) { return sampler.shorten(path, shorter_than, seed, {max_checks, seconds}); }));
          },
          "path"_a, "shorter_than"_a, "seed"_a, "max_checks"_a, "seconds"_a);
}

}  // namespace humanoid_rail
