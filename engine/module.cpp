// What Python sees of the engine; humanoid_rail/native.py gives it the interface of the Python engine.

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include <coal/config.hh>
#include <coal/shape/geometric_shapes.h>
#include <pinocchio/config.hpp>

#include "floor.hpp"
#include "inverse_kinematics.hpp"
#include "rollout.hpp"
#include "validity.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace humanoid_rail {

namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Rows rows(const std::vector<double>& values, std::size_t columns) {
  const auto n = static_cast<Eigen::Index>(columns);
  return Eigen::Map<const Rows>(values.data(), static_cast<Eigen::Index>(values.size()) / n, n);
}

Eigen::Map<const Vector> vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

void check_size(const char* what, Eigen::Index given, Eigen::Index size) {
  if (given != size) {
    throw std::invalid_argument(std::string(what) + " needs " + std::to_string(size) + " numbers, not " +
                                std::to_string(given));
  }
}

// Distances of links (L) from obstacles (O), infinite where a pair is not listed.
Rows table(const std::vector<Nearest>& pairs, const GradientProjection& method) {
  Rows clearance = Rows::Constant(method.kinematics.robot().links(), method.clearances.obstacles(),
                                  INFINITE);
  for (const Nearest& pair : pairs) clearance(pair.link, pair.other) = pair.distance;
  return clearance;
}

void check_finite(const char* what, const Eigen::Ref<const Rows>& given) {
  if (!given.allFinite()) throw std::invalid_argument(std::string(what) + " needs finite numbers");
}

void move_to(GradientProjection& method, const Eigen::Ref<const Vector>& q, double t) {
  check_size("q", q.size(), method.kinematics.robot().n());
  check_finite("q", q.transpose());
  method.kinematics.move_to(q);
  method.clearances.move_to(t);
}

// Hands (3h), J, mu, d mu/dq, clearances of links from obstacles (L, O) and their gradients (L O, n); the clearances of
// links from pieces (L, K), their gradients (L K, n) and rates (L, K); those of pairs of links (P) and their gradients
// (P, n).
auto state(SafeVelocity& safe, const Eigen::Ref<const Vector>& q, double t) {
  GradientProjection& method = safe.projection;
  move_to(method, q, t);
  const Kinematics& kinematics = method.kinematics;
  const Robot& robot = kinematics.robot();
  Vector full = Vector::Zero(robot.model.nv);
  kinematics.add_manipulability_gradient(1.0, full);
  const Vector manipulability_gradient = robot.coupling.transpose() * full;

  Vector gradient(robot.n());
  const auto obstacle_gradient = [&](const Nearest& pair) {
    gradient.setZero();
    kinematics.add_wrench(pair.wrench(), robot.joint_of(pair.link), 0, -1.0, gradient);
    return gradient.transpose();
  };
  const auto& pairs = method.clearances.within(INFINITE, kinematics);
  const int obstacles = method.clearances.obstacles();
  Rows gradients = Rows::Zero(robot.links() * obstacles, robot.n());
  for (const Nearest& pair : pairs) gradients.row(pair.link * obstacles + pair.other) = obstacle_gradient(pair);
  const auto pieces = static_cast<Eigen::Index>(method.clearances.pieces().size());
  Rows distances(robot.links(), pieces), rates(robot.links(), pieces), piece_gradients(robot.links() * pieces, robot.n());
  for (const Nearest& pair : method.clearances.pieces_within()) {
    distances(pair.link, pair.piece) = pair.distance;
    rates(pair.link, pair.piece) = pair.rate;
    piece_gradients.row(pair.pair) = obstacle_gradient(pair);
  }
  const auto& links = safe.self_clearances.within(INFINITE, kinematics);
  Vector link_distances(static_cast<Eigen::Index>(links.size()));
  Rows link_gradients(link_distances.size(), robot.n());
  for (const Nearest& pair : links) {
    gradient.setZero();
    kinematics.add_wrench(pair.wrench(), robot.joint_of(pair.link), 0, -1.0, gradient);
    kinematics.add_wrench(pair.wrench(), robot.joint_of(pair.other), 0, 1.0, gradient);
    link_distances[pair.pair] = pair.distance;
    link_gradients.row(pair.pair) = gradient.transpose();
  }
  return std::make_tuple(Vector(kinematics.hands()), Matrix(kinematics.jacobian()), kinematics.manipulability(),
                         manipulability_gradient, table(pairs, method), std::move(gradients),
                         std::make_tuple(std::move(distances), std::move(piece_gradients), std::move(rates)),
                         std::make_pair(std::move(link_distances), std::move(link_gradients)));
}

// Hands (3h), mu and clearances (L, O) up to a horizon, and the shortest in any case; those of pairs of links (P).
auto measure(SafeVelocity& safe, const Eigen::Ref<const Vector>& q, double t, double horizon) {
  GradientProjection& method = safe.projection;
  move_to(method, q, t);
  const Kinematics& kinematics = method.kinematics;
  const auto& links = safe.self_clearances.within(INFINITE, kinematics);
  Vector distances(static_cast<Eigen::Index>(links.size()));
  for (const Nearest& pair : links) distances[pair.pair] = pair.distance;
  return std::make_tuple(Vector(kinematics.hands()), kinematics.manipulability(),
                         table(method.clearances.within_or_nearest(horizon, kinematics), method),
                         std::move(distances));
}

// The same along a motion, at times (N) and configurations (N, n): hands (N, 3h), mu (N) and each obstacle's clearance
// from the nearest link (N, O).
auto along(GradientProjection& method, const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& motion,
           double horizon) {
  check_size("q", motion.cols(), method.kinematics.robot().n());
  check_size("t", t.size(), motion.rows());
  check_finite("q", motion);
  const nb::gil_scoped_release release;
  const Kinematics& kinematics = method.kinematics;
  Rows hands(motion.rows(), kinematics.robot().rows());
  Vector manipulability(motion.rows());
  Rows clearance = Rows::Constant(motion.rows(), method.clearances.obstacles(), INFINITE);
  Vector q(motion.cols());
  for (Eigen::Index i = 0; i < motion.rows(); ++i) {
    q = motion.row(i);
    method.kinematics.move_to(q);
    method.clearances.move_to(t[i]);
    hands.row(i) = kinematics.hands();
    manipulability[i] = kinematics.manipulability();
    for (const Nearest& pair : method.clearances.within_or_nearest(horizon, kinematics)) {
      clearance(i, pair.other) = std::min(clearance(i, pair.other), pair.distance);
    }
  }
  return std::make_tuple(std::move(hands), std::move(manipulability), std::move(clearance));
}

void check_task(const Gains& gains, const Eigen::Ref<const Vector>& targets, const GradientProjection& method) {
  check_size("targets", targets.size(), method.kinematics.robot().rows());
  check_size("gain", gains.gain.size(), method.kinematics.robot().rows());
  check_finite("targets", targets.transpose());
}

coal::Transform3s placement(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& center) {
  return {rotation, center};
}

}  // namespace

NB_MODULE(_engine, module) {
  module.doc() = "The native engine: eq. 4.9 and its integration on Pinocchio and coal, in C++.";
  module.attr("SINGULAR_VALUE") = SINGULAR_VALUE;
  module.attr("MAX_DAMPING") = MAX_DAMPING;
  module.attr("INFLUENCE") = INFLUENCE;
  module.attr("FREE_SPEED") = FREE_SPEED;
  module.attr("LIMIT_GAIN") = LIMIT_GAIN;
  module.attr("TASK_WEIGHT") = TASK_WEIGHT;
  module.attr("LEAST_RATE") = LEAST_RATE;
  module.attr("SHARE") = SHARE;
  module.attr("LEAST_MARGIN") = LEAST_MARGIN;
  module.attr("PINOCCHIO_VERSION") = PINOCCHIO_VERSION;
  module.attr("COAL_VERSION") = COAL_VERSION;

  nb::class_<Robot>(module, "Robot", "A robot's model, collision bodies, linear coupling and hands.")
      .def(
          "__init__",
          [](Robot* self, const std::string& model, const std::string& bodies, const Matrix& coupling,
             const Vector& offset, const std::vector<std::pair<std::size_t, std::vector<int>>>& hands,
             const std::vector<std::pair<int, int>>& self_collision_pairs, const Vector& lower, const Vector& upper,
             const Vector& velocity_limit) {
            std::vector<Hand> converted;
            for (const auto& [frame, arm] : hands) converted.push_back({frame, arm});
            new (self) Robot(model, bodies, coupling, offset, converted, self_collision_pairs,
                             {lower, upper, velocity_limit});
          },
          "model"_a, "bodies"_a, "coupling"_a, "offset"_a, "hands"_a, "self_collision_pairs"_a, "lower"_a, "upper"_a,
          "velocity_limit"_a);

  nb::class_<Obstacles>(module, "Obstacles", "Obstacles, at rest or moving; each call adds one.")
      .def(nb::init<>())
      .def(
          "sphere",
          [](Obstacles& self, const Eigen::Vector3d& center, double radius, const Eigen::Vector3d& velocity) {
            self.add(std::make_shared<coal::Sphere>(radius), placement(Eigen::Matrix3d::Identity(), center), velocity);
          },
          "center"_a, "radius"_a, "velocity"_a)
      .def(
          "box",
          [](Obstacles& self, const Eigen::Vector3d& center, const Eigen::Matrix3d& rotation,
             const Eigen::Vector3d& size, const Eigen::Vector3d& velocity) {
            self.add(std::make_shared<coal::Box>(size), placement(rotation, center), velocity);
          },
          "center"_a, "rotation"_a, "size"_a, "velocity"_a)
      .def(
          "capsule",
          [](Obstacles& self, const Eigen::Vector3d& center, const Eigen::Matrix3d& rotation, double radius,
             double length, const Eigen::Vector3d& velocity) {
            self.add(std::make_shared<coal::Capsule>(radius, length), placement(rotation, center), velocity);
          },
          "center"_a, "rotation"_a, "radius"_a, "length"_a, "velocity"_a)
      .def(
          "halfspace",
          [](Obstacles& self, const Eigen::Vector3d& normal, double offset, const Eigen::Vector3d& velocity) {
            self.add(std::make_shared<coal::Halfspace>(normal, offset), coal::Transform3s(), velocity);
          },
          "normal"_a, "offset"_a, "velocity"_a)
      .def(
          "convex",
          [](Obstacles& self, const Eigen::Vector3d& center, const Eigen::Matrix3d& rotation,
             const std::vector<Matrix>& pieces, const Eigen::Vector3d& velocity) {
            self.add_convex(pieces, placement(rotation, center), velocity);
          },
          "center"_a, "rotation"_a, "pieces"_a, "velocity"_a);

  nb::class_<Gains>(module, "Gains", "Parameters of eq. 4.9.")
      .def(
          "__init__",
          [](Gains* self, const Vector& gain, double c_mu, double c_kappa, double epsilon) {
            new (self) Gains{gain, c_mu, c_kappa, epsilon};
          },
          "gain"_a, "c_mu"_a, "c_kappa"_a, "epsilon"_a);

  nb::enum_<Status>(module, "Status", "What became of the targets.")
      .value("REACHED", Status::reached)
      .value("STALLED", Status::stalled)
      .value("TIME_LIMIT", Status::time_limit)
      .value("SINGULAR", Status::singular)
      .value("OVERRUN", Status::overrun)
      .value("OUT_OF_TIME", Status::out_of_time);

  nb::class_<Settings>(module, "Settings", "When a motion ends, and how precisely it is integrated.")
      .def(
          "__init__",
          [](Settings* self, double tolerance, double dt, double max_time, double rtol, double atol,
             int max_evaluations, double patience, double progress, double planning_time) {
            for (double number : {tolerance, dt, max_time, rtol, atol}) {
              if (!(number > 0.0)) throw std::invalid_argument("settings need numbers greater than 0");
            }
            new (self) Settings{tolerance, dt, max_time, rtol, atol, max_evaluations, patience, progress,
                               planning_time};
          },
          nb::kw_only(), "tolerance"_a, "dt"_a, "max_time"_a, "rtol"_a, "atol"_a, "max_evaluations"_a, "patience"_a,
          "progress"_a, "planning_time"_a);

  nb::class_<Integration>(module, "Integration", "A sampled motion and why it ended.")
      .def_ro("status", &Integration::status)
      .def_ro("left", &Integration::left)
      .def_ro("evaluations", &Integration::evaluations)
      .def_ro("broken", &Integration::broken)
      .def_prop_ro("t", [](const Integration& self) { return Vector(vector(self.t)); })
      .def_prop_ro("q", [](const Integration& self) { return rows(self.q, self.n); })
      .def_prop_ro("visited", [](const Integration& self) {
        return std::make_tuple(Vector(vector(self.visited_t)), rows(self.visited_q, self.n),
                               rows(self.visited_velocity, self.n));
      });

  nb::class_<GradientProjection>(module, "GradientProjection",
                                 "Eq. 4.9 for a robot among obstacles. Not to be shared between threads.")
      .def(
          "__init__",
          [](GradientProjection* self, std::shared_ptr<const Robot> robot, const Obstacles& obstacles) {
            new (self) GradientProjection(std::move(robot), obstacles);
          },
          "robot"_a, "obstacles"_a)
      .def("along", &along, "t"_a, "q"_a, "horizon"_a)
      .def(
          "velocity",
          [](GradientProjection& self, const Eigen::Ref<const Vector>& q, double t,
             const Eigen::Ref<const Vector>& targets, const Gains& gains) {
            check_size("q", q.size(), self.kinematics.robot().n());
            check_finite("q", q.transpose());
            check_task(gains, targets, self);
            return Vector(self.velocity(q, t, targets, gains));
          },
          "q"_a, "t"_a, "targets"_a, "gains"_a)
      .def(
          "integrate",
          [](GradientProjection& self, const Eigen::Ref<const Vector>& start, const Eigen::Ref<const Vector>& targets,
             const Gains& gains, const Settings& settings) {
            check_size("start", start.size(), self.kinematics.robot().n());
            check_finite("start", start.transpose());
            check_task(gains, targets, self);
            const nb::gil_scoped_release release;
            return integrate(self, start, targets, gains, settings);
          },
          "start"_a, "targets"_a, "gains"_a, "settings"_a);

  nb::class_<Safety>(module, "Safety", "Parameters of the constraints of the safe velocity.")
      .def(
          "__init__",
          [](Safety* self, double distance, double gain) {
            if (!(distance >= 0.0) || !(gain > 0.0)) throw std::invalid_argument("a distance and a gain are positive");
            new (self) Safety{distance, gain};
          },
          nb::kw_only(), "distance"_a, "gain"_a);

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
      .def_ro("contact", &Certificate::contact);

  nb::class_<Certifier>(module, "Certifier", "Looks for contact on motions. Not to be shared between threads.")
      .def(
          "__init__",
          [](Certifier* self, std::shared_ptr<const Robot> robot, const Obstacles& obstacles) {
            new (self) Certifier(std::move(robot), obstacles);
          },
          "robot"_a, "obstacles"_a)
      .def(
          "certify",
          [](Certifier& self, const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Rows>& q) {
            check_size("q", q.cols(), self.robot().n());
            check_size("t", t.size(), q.rows());
            check_finite("t", t.transpose());
            check_finite("q", q);
            if (q.rows() == 0) throw std::invalid_argument("a motion needs a sample");
            const nb::gil_scoped_release release;
            return self.certify(t, q);
          },
          "t"_a, "q"_a);

  nb::class_<SafeVelocity>(module, "SafeVelocity",
                           "The velocity closest to eq. 4.9's that keeps clear. Not to be shared between threads.")
      .def(
          "__init__",
          [](SafeVelocity* self, std::shared_ptr<const Robot> robot, const Obstacles& obstacles) {
            new (self) SafeVelocity(std::move(robot), obstacles);
          },
          "robot"_a, "obstacles"_a)
      .def_prop_ro(
          "projection", [](SafeVelocity& self) -> GradientProjection& { return self.projection; },
          nb::rv_policy::reference_internal)
      .def("state", &state, "q"_a, "t"_a)
      .def("measure", &measure, "q"_a, "t"_a, "horizon"_a)
      .def(
          "velocity",
          [](SafeVelocity& self, const Eigen::Ref<const Vector>& q, double t, const Eigen::Ref<const Vector>& targets,
             const Gains& gains, const Safety& safety, double dt) {
            check_size("q", q.size(), self.projection.kinematics.robot().n());
            check_finite("q", q.transpose());
            check_task(gains, targets, self.projection);
            return Vector(self.velocity(q, t, targets, gains, safety, dt));
          },
          "q"_a, "t"_a, "targets"_a, "gains"_a, "safety"_a, "dt"_a)
      .def("constraints", [](const SafeVelocity& self) { return std::make_tuple(self.rows(), self.sides()); })
      .def(
          "rollout",
          [](SafeVelocity& self, const Obstacles& obstacles, const Eigen::Ref<const Vector>& start,
             const Eigen::Ref<const Vector>& targets, const Gains& gains, const Safety& safety,
             const Settings& settings) {
            check_size("start", start.size(), self.projection.kinematics.robot().n());
            check_finite("start", start.transpose());
            check_task(gains, targets, self.projection);
            const nb::gil_scoped_release release;
            Rollout result = rollout(self, obstacles, start, targets, gains, safety, settings);
            return std::make_pair(std::move(result.motion), std::move(result.overrun));
          },
          "obstacles"_a, "start"_a, "targets"_a, "gains"_a, "safety"_a, "settings"_a);

  nb::class_<Validity>(module, "Validity", "Whether a robot keeps its distance. Not to be shared between threads.")
      .def(
          "__init__",
          [](Validity* self, std::shared_ptr<const Robot> robot, const Obstacles& obstacles, double distance) {
            new (self) Validity(std::move(robot), obstacles, distance);
          },
          "robot"_a, "obstacles"_a, "distance"_a)
      .def(
          "holds_at",
          [](Validity& self, const Eigen::Ref<const Vector>& q) {
            check_size("q", q.size(), self.robot().n());
            check_finite("q", q.transpose());
            return self.holds_at(q);
          },
          "q"_a)
      .def(
          "holds_between",
          [](Validity& self, const Eigen::Ref<const Vector>& a, const Eigen::Ref<const Vector>& b) {
            check_size("a", a.size(), self.robot().n());
            check_size("b", b.size(), self.robot().n());
            check_finite("a", a.transpose());
            check_finite("b", b.transpose());
            return self.holds_between(a, b);
          },
          "a"_a, "b"_a);

  nb::class_<InverseKinematics>(module, "InverseKinematics",
                                "Looks for configurations. Not to be shared between threads.")
      .def(
          "__init__",
          [](InverseKinematics* self, std::shared_ptr<const Robot> robot, const Obstacles& obstacles) {
            new (self) InverseKinematics(std::move(robot), obstacles);
          },
          "robot"_a, "obstacles"_a)
      .def(
          "solve",
          [](InverseKinematics& self, const Eigen::Ref<const Vector>& start, const Eigen::Ref<const Vector>& targets,
             const Eigen::Ref<const Vector>& weights, double distance) {
            check_size("start", start.size(), self.robot().n());
            check_finite("start", start.transpose());
            check_size("targets", targets.size(), self.robot().rows());
            check_size("weights", weights.size(), self.robot().rows());
            const Posture found = self.solve(start, targets, weights, distance);
            return std::make_tuple(found.q, found.error, found.clearance);
          },
          "start"_a, "targets"_a, "weights"_a, "distance"_a);

  module.def(
      "floor_seconds",
      [](const Robot& robot, const Obstacles& obstacles, const Matrix& configurations, int repeats) {
        check_size("configurations", configurations.cols(), robot.n());
        return floor_seconds(robot, obstacles, configurations, repeats);
      },
      "robot"_a, "obstacles"_a, "configurations"_a, "repeats"_a,
      "Seconds of the bare Pinocchio and coal calls that one evaluation of eq. 4.9 is made of.");
  module.def(
      "velocity_seconds",
      [](GradientProjection& method, const Matrix& configurations, const Vector& targets, const Gains& gains,
         int repeats) {
        check_size("configurations", configurations.cols(), method.kinematics.robot().n());
        check_task(gains, targets, method);
        return velocity_seconds(method, configurations, targets, gains, repeats);
      },
      "method"_a, "configurations"_a, "targets"_a, "gains"_a, "repeats"_a,
      "Seconds of one evaluation of eq. 4.9, called from C++.");
  module.def(
      "safe_velocity_seconds",
      [](SafeVelocity& method, const Matrix& configurations, const Vector& targets, const Gains& gains,
         const Safety& safety, double dt, int repeats) {
        check_size("configurations", configurations.cols(), method.projection.kinematics.robot().n());
        check_task(gains, targets, method.projection);
        return safe_velocity_seconds(method, configurations, targets, gains, safety, dt, repeats);
      },
      "method"_a, "configurations"_a, "targets"_a, "gains"_a, "safety"_a, "dt"_a, "repeats"_a,
      "Seconds of one safe velocity, called from C++.");
}

}  // namespace humanoid_rail
