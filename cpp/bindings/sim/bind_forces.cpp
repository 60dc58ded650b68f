#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/record.h"
#include "bindings/sim/binders.h"

namespace uwsim::bindings {
namespace {

/// A Touch with the other body's name.
struct ContactForce {
  std::string other;
  Eigen::Vector3d point_world_m;
  Eigen::Vector3d force_world_n;
  std::string link, other_link;
};

std::vector<ContactForce> named(const Simulation& simulation, std::size_t body, const std::vector<Touch>& touches) {
  std::vector<ContactForce> all;
  for (const Touch& touch : touches) {
    const bool is_body = touch.other != Touch::kNoBody;
    all.push_back({is_body ? simulation.body_name(touch.other) : "", touch.point_world_m, touch.force_world_n,
                   simulation.link_name(body, touch.link), simulation.link_name(touch.other, touch.other_link)});
  }
  return all;
}

/// Tethers, arms and the wind have a term only where there are any.
std::vector<std::pair<std::string, Vector6d>> by_name(const Simulation& simulation, const Forces& forces, bool has_arm,
                                                      bool feels_wind) {
  const Craft::Terms& craft = forces.craft;
  std::vector<std::pair<std::string, Vector6d>> terms{
      {"weight", craft.weight},         {"buoyancy", craft.buoyancy}, {"drag", craft.drag},
      {"added_mass", craft.added_mass}, {"coriolis", craft.coriolis}, {"actuators", forces.actuators},
      {"applied", forces.applied},      {"contact", forces.contact},  {"dock", forces.dock}};
  if (simulation.tethers() > 0) terms.emplace_back("tether", forces.tether);
  if (has_arm) terms.emplace_back("arm", forces.arm);
  if (feels_wind) terms.emplace_back("wind", forces.wind);
  return terms;
}

std::pair<py::array_t<double>, py::array_t<double>> as_arrays(WetSurface wet) {
  const auto n = static_cast<py::ssize_t>(wet.forces_body_n.size() / 3);
  auto corners = move_out(std::move(wet.corners_body_m), {n, 3, 3});
  auto forces = move_out(std::move(wet.forces_body_n), {n, 3});
  forbid_writing(corners);
  forbid_writing(forces);
  return {std::move(corners), std::move(forces)};
}

}  // namespace

void bind_object_spec(py::module_& m) {
  py::class_<AppliedWrench>(m, "AppliedWrench", "A wrench that something else exerts on a body, at its origin.")
      .def(py::init([](const Vector6d& wrench, bool in_world_axes, std::uint64_t from_tick, std::uint64_t until_tick) {
             return AppliedWrench{wrench, in_world_axes, from_tick, until_tick};
           }),
           py::arg("wrench"), py::arg("in_world_axes"), py::arg("from_tick"), py::arg("until_tick"),
           "wrench: (6,) [N, N m], along the world's axes or the body's; it acts in the steps of these ticks, the\n"
           "last excluded.");
  using Cubics = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;
  py::class_<BodyPath, std::shared_ptr<BodyPath>>(m, "BodyPath", "The motion of a body that nothing can push.")
      .def(py::init([](std::vector<double> breaks, const std::array<Cubics, 3>& curve_m, std::vector<double> times_s,
                       const Cubics& progress, bool closed, bool climbs, bool turns, const py::object& position_m,
                       const py::object& orientation_xyzw) {
             BodyPathSpec spec{.breaks = std::move(breaks),
                               .curve_m = {},
                               .times_s = std::move(times_s),
                               .progress = {},
                               .closed = closed,
                               .climbs = climbs,
                               .turns = turns,
                               .path_from_body = as_pose(position_m, orientation_xyzw, "path_from_body")};
             for (Eigen::Index k = 0; k < curve_m[0].rows(); ++k) {
               Eigen::Matrix<double, 4, 3>& piece = spec.curve_m.emplace_back();
               for (Eigen::Index axis = 0; axis < 3; ++axis) {
                 const Cubics& along = curve_m[static_cast<std::size_t>(axis)];
                 require(along.rows() == curve_m[0].rows(), "curve_m", along.rows(), "must be as long for each axis");
                 piece.col(axis) = along.row(k).transpose();
               }
             }
             for (Eigen::Index k = 0; k < progress.rows(); ++k) spec.progress.push_back(progress.row(k).transpose());
             return std::make_shared<BodyPath>(std::move(spec));
           }),
           py::arg("breaks"), py::arg("curve_m"), py::arg("times_s"), py::arg("progress"), py::arg("closed"),
           py::arg("climbs"), py::arg("turns"), py::arg("position_m"), py::arg("orientation_xyzw"),
           "breaks: (n + 1,), ascending, of the curve's parameter u. curve_m: x, y and z, each (n, 4): coefficients\n"
           "of 1, h, h^2 and h^3 in each piece, where h = u - break. times_s: (m + 1,) from 0, ascending. progress:\n"
           "(m, 4), u in powers of the time since the break. closed: it begins again after the last time. climbs: x\n"
           "is along the curve; otherwise along its horizontal part. turns: otherwise x keeps pointing east. "
           "position_m, orientation_xyzw: of the body in\n"
           "path axes. Raises ValueError.")
      .def("at", &BodyPath::at, py::arg("time_s"), "Return the BodyState at a time from 0 on.");
  py::class_<ObjectSpec, std::shared_ptr<ObjectSpec>>(m, "ObjectSpec", "A loose body.")
      .def(
          py::init([](std::string name, std::shared_ptr<Craft> craft, CollisionShape shape, double friction,
                      double restitution, const BodyState& start, std::vector<AppliedWrench> wrenches,
                      const std::optional<std::shared_ptr<BodyPath>>& path, std::vector<ArmLink> links,
                      const std::optional<RoundShape>& round) {
            auto spec = std::make_shared<ObjectSpec>();
            spec->body = {std::move(name), std::move(craft), shape, friction, restitution};
            spec->body.path = path.value_or(nullptr);
            spec->body.arm = std::move(links);
            if (round) spec->body.round = round_piece(*round);
            spec->start = path ? (*path)->at(0) : start;
            spec->wrenches = std::move(wrenches);
            return spec;
          }),
          py::arg("name"), py::arg("craft").none(false), py::arg("shape"), py::arg("friction"), py::arg("restitution"),
          py::arg("start"), py::arg("wrenches") = std::vector<AppliedWrench>{}, py::arg("path") = py::none(),
          py::arg("links") = std::vector<ArmLink>{}, py::arg("round") = py::none(),
          "path: that it follows, from its own start. links: that joints hold on it; a path then stands still. round:\n"
          "the ball or drum, body frame, that the craft's mesh stands for: contacts are with it, without facets.")
      .def(
          "carry",
          [](ObjectSpec& spec, std::size_t vehicle, std::size_t link, const py::object& position_m,
             const py::object& orientation_xyzw, const py::object& along_body, double spring_j) {
            spec.carrying = Carrying{vehicle, link, as_pose(position_m, orientation_xyzw, "carried"),
                                     as_vector3(along_body, "along_body"), spring_j};
          },
          py::arg("vehicle"), py::arg("link"), py::arg("position_m"), py::arg("orientation_xyzw"),
          py::arg("along_body"), py::arg("spring_j") = 0.0,
          "Let a vehicle carry it at a pose in the vehicle's frame until it is released, when a spring of this energy\n"
          "pushes it along a unit vector (3,) of the vehicle's frame. link: index of the vehicle's fixed link with\n"
          "its mass and water.");
}

void bind_forces(py::module_& m, py::class_<OwnedSimulation>& simulation) {
  Record<ContactForce>(m, "ContactForce", "A point at which a body was pressed in the last step, and the force on it.")
      .field("other", &ContactForce::other, "the other body's name; empty for terrain and obstacles")
      .field("point_world_m", &ContactForce::point_world_m, "(3,)")
      .field("force_world_n", &ContactForce::force_world_n, "(3,), on the body itself; mean over the step")
      .field("link", &ContactForce::link,
             "the link of the body's arm, or of an object's joints; empty: the body itself")
      .field("other_link", &ContactForce::other_link, "likewise of the other body")
      .done();
  simulation
      .def(
          "apply_wrench",
          [](OwnedSimulation& o, std::size_t v, const Vector6d& wrench, bool in_world_axes, double duration_s) {
            o.with([&](Simulation& s) { s.apply_wrench(v, wrench, in_world_axes, duration_s); });
          },
          py::arg("vehicle"), py::arg("wrench"), py::arg("in_world_axes"), py::arg("duration_s"),
          "Exert a wrench (6,) on a vehicle at its origin, besides those by schedule, for a duration, which may be\n"
          "inf, or until the next call. Raises ValueError.")
      .def(
          "release_object",
          [](OwnedSimulation& o, std::size_t k) { o.with([&](Simulation& s) { s.release_object(k); }); },
          py::arg("object"), "Let go of an object that a vehicle carries. Raises ValueError unless it is loaded.")
      .def(
          "load_object", [](OwnedSimulation& o, std::size_t k) { o.with([&](Simulation& s) { s.load_object(k); }); },
          py::arg("object"), "Put an object back to where its vehicle carries it. Raises ValueError if it is there.")
      .def(
          "object_loaded",
          [](OwnedSimulation& o, std::size_t k) {
            return o.with_briefly([&](Simulation& s) { return s.object_loaded(k); });
          },
          py::arg("object"), "Return whether a vehicle carries an object now.")
      .def(
          "apply_object_wrench",
          [](OwnedSimulation& o, std::size_t k, const Vector6d& wrench, bool in_world_axes, double duration_s) {
            o.with([&](Simulation& s) { s.apply_object_wrench(k, wrench, in_world_axes, duration_s); });
          },
          py::arg("object"), py::arg("wrench"), py::arg("in_world_axes"), py::arg("duration_s"), "See apply_wrench.")
      .def(
          "wet_surface",
          [](OwnedSimulation& o, std::size_t v) {
            return as_arrays(o.with([&](Simulation& s) { return s.wet_surface(v); }));
          },
          py::arg("vehicle"),
          "Return the corners (n, 3, 3) [m] of the triangles of the hull that are under water, those at the surface\n"
          "cut at it, and the force of the water's pressure on each (n, 3) [N]; body axes.")
      .def(
          "object_wet_surface",
          [](OwnedSimulation& o, std::size_t k) {
            return as_arrays(o.with([&](Simulation& s) { return s.object_wet_surface(k); }));
          },
          py::arg("object"), "See wet_surface.")
      .def(
          "forces",
          [](OwnedSimulation& o, std::size_t v) {
            return o.with([&](Simulation& s) { return by_name(s, s.forces(v), s.has_arm(v), s.feels_wind(v)); });
          },
          py::arg("vehicle"),
          "Return (name, wrench (6,)) pairs: means over the last step, body axes, at the origin [N, N m]. Raises\n"
          "ValueError with Bullet's engine.")
      .def(
          "object_forces",
          [](OwnedSimulation& o, std::size_t k) {
            return o.with([&](Simulation& s) { return by_name(s, s.object_forces(k), false, false); });
          },
          py::arg("object"))
      .def(
          "contacts",
          [](OwnedSimulation& o, std::size_t v) {
            return o.with([&](Simulation& s) { return named(s, v, s.touches(v)); });
          },
          py::arg("vehicle"), "Return the points at which the vehicle was pressed in the last step. Raises ValueError.")
      .def(
          "object_contacts",
          [](OwnedSimulation& o, std::size_t k) {
            return o.with([&](Simulation& s) { return named(s, s.body_of(k), s.object_touches(k)); });
          },
          py::arg("object"))
      .def(
          "object_state",
          [](OwnedSimulation& o, std::size_t k) {
            return o.with_briefly([&](Simulation& s) { return s.object_state(k); });
          },
          py::arg("object"));
}

}  // namespace uwsim::bindings
