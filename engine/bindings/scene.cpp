#include <coal/shape/geometric_shapes.h>

#include "../scene/obstacles.hpp"
#include "bindings.hpp"

namespace humanoid_rail {

void bind_scene(nb::module_& module) {
  using Point = Eigen::Vector3d;
  using Turn = Eigen::Matrix3d;
  nb::class_<Obstacles>(module, "Obstacles", "Obstacles, at rest or moving; each call adds one.")
      .def(nb::init<>())
      .def(
          "sphere",
          [](Obstacles& self, const Point& center, double radius, const Point& velocity) {
            self.add(std::make_shared<coal::Sphere>(radius), {Turn::Identity(), center}, velocity);
          },
          "center"_a, "radius"_a, "velocity"_a)
      .def(
          "box",
          [](Obstacles& self, const Point& center, const Turn& rotation, const Point& size, const Point& velocity) {
            self.add(std::make_shared<coal::Box>(size), {rotation, center}, velocity);
          },
          "center"_a, "rotation"_a, "size"_a, "velocity"_a)
      .def(
          "capsule",
          [](Obstacles& self, const Point& center, const Turn& rotation, double radius, double length,
             const Point& velocity) {
            self.add(std::make_shared<coal::Capsule>(radius, length), {rotation, center}, velocity);
          },
          "center"_a, "rotation"_a, "radius"_a, "length"_a, "velocity"_a)
      .def(
          "cylinder",
          [](Obstacles& self, const Point& center, const Turn& rotation, double radius, double length,
             const Point& velocity) {
            self.add(std::make_shared<coal::Cylinder>(radius, length), {rotation, center}, velocity);
          },
          "center"_a, "rotation"_a, "radius"_a, "length"_a, "velocity"_a)
      .def(
          "spheres",
          [](Obstacles& self, const Point& center, const Turn& rotation, const Matrix& centers, const Vector& radii,
             const Point& velocity) { self.add_spheres(centers, radii, {rotation, center}, velocity); },
          "center"_a, "rotation"_a, "centers"_a, "radii"_a, "velocity"_a)
      .def(
          "halfspace",
          [](Obstacles& self, const Point& normal, double offset, const Point& velocity) {
            self.add(std::make_shared<coal::Halfspace>(normal, offset), coal::Transform3s(), velocity);
          },
          "normal"_a, "offset"_a, "velocity"_a)
      .def(
          "convex",
          [](Obstacles& self, const Point& center, const Turn& rotation, const std::vector<Matrix>& pieces,
             const Point& velocity) { self.add_convex(pieces, {rotation, center}, velocity); },
          "center"_a, "rotation"_a, "pieces"_a, "velocity"_a);
}

}  // namespace humanoid_rail
