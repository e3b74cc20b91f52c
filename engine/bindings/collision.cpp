#include "../collision/certifier.hpp"
#include "../collision/closest_pairs.hpp"
#include "../collision/edge_checker.hpp"
#include "../kinematics/link_boxes.hpp"
#include "bindings.hpp"
#include "guard.hpp"

namespace humanoid_rail {

namespace {

using RobotPointer = std::shared_ptr<const Robot>;

// A pair, which is given by its number.
Nearest pair_of(const SweptDistance& swept, int number) {
  const auto pairs = all_pairs(swept.robot(), swept.pieces());
  if (number < 0 || number >= static_cast<int>(pairs.size())) throw std::invalid_argument("there is no such pair");
  return pairs[static_cast<std::size_t>(number)];
}

double lower_bound(SweptDistance& swept, int number, const Snapshot& a, const Snapshot& b) {
  Nearest here = pair_of(swept, number), there = here;
  swept.measure(here, a);
  swept.measure(there, b);
  EdgeBounds bounds;
  swept.edge_bounds(a.q, b.q, bounds);
  Displacement moved = bounds.of(here);
  moved.length += swept.speed(here) * (b.t - a.t);
  return swept.lower_bound(here, a, there, b, moved, INFINITE);
}

void bind_certifier(nb::module_& module) {
  nb::class_<Contact>(module, "Contact", "A link that touches an obstacle or another link.")
      .def_ro("t", &Contact::t)
      .def_ro("link", &Contact::link)
      .def_ro("other", &Contact::other)
      .def_ro("with_obstacle", &Contact::with_obstacle)
      .def_ro("point", &Contact::point);
  nb::class_<Certificate>(module, "Certificate", "What is proven of a motion.")
      .def_ro("certified", &Certificate::certified)
      .def_ro("min_obstacles", &Certificate::min_obstacles)
      .def_ro("min_links", &Certificate::min_links)
      .def_ro("bound", &Certificate::bound)
      .def_ro("others_bound", &Certificate::others_bound)
      .def_ro("contact", &Certificate::contact)
      .def_ro("stopped", &Certificate::stopped);
  using Guard = Guarded<Certifier>;
  nb::class_<Guard>(module, "Certifier", "Proves motions free of contact, or finds the first contact.")
      .def(nb::init<RobotPointer, const Obstacles&>(), "robot"_a, "obstacles"_a)
      .def(
          "certify",
          [](Guard& self, const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q,
             const Eigen::Ref<const Rows>& velocity, long max_checks) {
            const int n = self.constant().robot().n();
            check_size("q", q.cols(), n);
            check_size("t", t.size(), q.rows());
            check_finite("t", t.transpose());
            check_finite("q", q);
            if (velocity.rows() > 0) check_size("velocity", velocity.rows(), q.rows());
            check_size("velocity", velocity.cols(), n);
            check_finite("velocity", velocity);
            if (q.rows() == 0) throw std::invalid_argument("a motion needs a sample");
            return self.with(
                [&](Certifier& certifier) { return certifier.certify(SampledMotion(t, q, velocity), max_checks); });
          },
          "t"_a, "q"_a, "velocity"_a, "max_checks"_a, "Without velocities, (0, n), the motion is linear in q.");
}

void bind_edge_checker(nb::module_& module) {
  using Guard = Guarded<EdgeChecker>;
  nb::class_<Guard>(module, "EdgeChecker", "Whether a robot keeps its distance at a configuration or on an edge.")
      .def(nb::init<RobotPointer, const Obstacles&, double, double>(), "robot"_a, "obstacles"_a, "distance"_a,
           "own_share"_a)
      .def(
          "is_valid",
          [](Guard& self, const Eigen::Ref<const Vector>& q) {
            check_configuration("q", q, self.constant().robot().n());
            return self.with([&](EdgeChecker& checker) { return checker.is_valid(q); });
          },
          "q"_a)
      .def(
          "is_edge_valid",
          [](Guard& self, const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b) {
            check_configuration("a", a, self.constant().robot().n());
            check_configuration("b", b, self.constant().robot().n());
            return self.with([&](EdgeChecker& checker) { return checker.is_edge_valid(a, b); });
          },
          "a"_a, "b"_a);
}

void bind_swept_distance(nb::module_& module) {
  using Guard = Guarded<SweptDistance>;
  nb::class_<Guard>(module, "SweptDistance", "Lower bounds of clearances on the edge between two configurations.")
      .def(
          "__init__",
          [](Guard* self, RobotPointer robot, const Obstacles& obstacles) {
            new (self) Guard(std::move(robot), obstacles.pieces());
          },
          "robot"_a, "obstacles"_a)
      .def("pairs",
           [](Guard& self) {
             std::vector<std::tuple<int, int, int>> found;
             for (const Nearest& pair : all_pairs(self.constant().robot(), self.constant().pieces())) {
               found.emplace_back(pair.link, pair.other, pair.piece);
             }
             return found;
           })
      .def(
          "distance",
          [](Guard& self, int pair, double t, const Eigen::Ref<const Vector>& q) {
            check_configuration("q", q, self.constant().robot().n());
            return self.with([&](SweptDistance& swept) {
              Nearest found = pair_of(swept, pair);
              swept.measure(found, swept.snapshot(t, q));
              return std::make_tuple(found.distance, found.point, found.normal);
            });
          },
          "pair"_a, "t"_a, "q"_a)
      .def(
          "lower_bound",
          [](Guard& self, int pair, double t_a, const Eigen::Ref<const Vector>& a, double t_b,
             const Eigen::Ref<const Vector>& b) {
            check_configuration("a", a, self.constant().robot().n());
            check_configuration("b", b, self.constant().robot().n());
            return self.with([&](SweptDistance& swept) {
              const Snapshot at_a = swept.snapshot(t_a, a), at_b = swept.snapshot(t_b, b);
              return lower_bound(swept, pair, at_a, at_b);
            });
          },
          "pair"_a, "t_a"_a, "a"_a, "t_b"_a, "b"_a);
}

void bind_motion_bound(nb::module_& module) {
  struct Bound {
    RobotPointer robot;
    MotionBound bound;
  };
  using Guard = Guarded<Bound>;
  nb::class_<Guard>(module, "MotionBound", "How far the points of links can get while joints move at constant rates.")
      .def(
          "__init__",
          [](Guard* self, RobotPointer robot) {
            const Robot& known = *robot;
            new (self) Guard(Bound{std::move(robot), MotionBound(known)});
          },
          "robot"_a)
      .def(
          "displacements",
          [](Guard& self, const Vector& change, const Vector& slide, std::size_t origin) {
            const Robot& robot = *self.constant().robot;
            check_configuration("change", change, robot.model.nv);
            check_configuration("slide", slide, robot.model.nv);
            if (origin >= static_cast<std::size_t>(robot.model.njoints)) throw std::invalid_argument("no such origin");
            std::vector<Displacement> links(static_cast<std::size_t>(robot.links()));
            self.with([&](Bound& with) { with.bound.displacements(change, slide, origin, links); });
            Vector length(robot.links()), curvature(robot.links());
            for (std::size_t i = 0; i < links.size(); ++i) {
              length[static_cast<Eigen::Index>(i)] = links[i].length;
              curvature[static_cast<Eigen::Index>(i)] = links[i].curvature;
            }
            return std::make_pair(length, curvature);
          },
          "change"_a, "slide"_a, "origin"_a);
}

void bind_link_boxes(nb::module_& module) {
  struct Boxes {
    explicit Boxes(const RobotPointer& robot) : kinematics(robot), boxes(robot) {}
    Kinematics kinematics;
    LinkBoxes boxes;
  };
  using Guard = Guarded<Boxes>;
  nb::class_<Guard>(module, "LinkBoxes", "Bounds of pairs of links that take long to measure, from boxes around them.")
      .def(nb::init<RobotPointer>(), "robot"_a)
      .def(
          "bounds",
          [](Guard& self, const Eigen::Ref<const Vector>& q, const Vector& velocity) {
            const Robot& robot = self.constant().kinematics.robot();
            check_configuration("q", q, robot.n());
            check_configuration("velocity", velocity, robot.n());
            return self.with([&](Boxes& with) {
              with.kinematics.move_to(q);
              with.boxes.move_to(with.kinematics);
              with.boxes.set_velocity(with.kinematics, velocity);
              std::vector<std::tuple<int, double, double>> found;
              int pair = -1;
              for (const auto& [link, other] : robot.self_collision_pairs) {
                if (!robot.takes_long(++pair)) continue;
                found.emplace_back(pair, with.boxes.distance(link, other), with.boxes.approach(link, other));
              }
              return found;
            });
          },
          "q"_a, "velocity"_a,
          "Of each pair its number, a lower bound of its distance, m, and an upper one of its approach, m/s.");
}

using Closest = std::tuple<int, int, double, Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>;

std::vector<Closest> plain(const std::vector<Nearest>& pairs) {
  std::vector<Closest> found;
  for (const Nearest& pair : pairs) {
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> points;
    points.row(0) = pair.point;
    points.row(1) = pair.point + pair.distance * pair.normal;
    found.emplace_back(pair.link, pair.other, pair.distance, points);
  }
  return found;
}

}  // namespace

void bind_collision(nb::module_& module) {
  bind_certifier(module);
  bind_edge_checker(module);
  bind_swept_distance(module);
  bind_motion_bound(module);
  bind_link_boxes(module);
  module.def(
      "closest_pairs",
      [](RobotPointer robot, const Obstacles& obstacles, const Eigen::Ref<const Vector>& t,
         const Eigen::Ref<const Rows>& q) {
        check_size("q", q.cols(), robot->n());
        check_size("t", t.size(), q.rows());
        check_finite("t", t.transpose());
        check_finite("q", q);
        const ClosestPairs found = interruptibly([&] { return closest_pairs(robot, obstacles, t, q); });
        return std::make_pair(plain(found.obstacles), plain(found.links));
      },
      "robot"_a, "obstacles"_a, "t"_a, "q"_a, "The closest link and obstacle, and the closest links, at each moment.");
}

}  // namespace humanoid_rail
