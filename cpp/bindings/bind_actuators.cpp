#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "bind.h"
#include "convert.h"
#include "owned_simulation.h"
#include "uwsim/vehicle/actuators.h"

namespace uwsim::bindings {
namespace {

void bind_parts(py::module_& m) {
  py::class_<ThrustCurve>(m, "ThrustCurve",
                          "Thrust in still water against a command in [-1, 1], linear between points.")
      .def(py::init([](std::vector<double> commands, std::vector<double> thrusts_n, const std::string& path) {
             return ThrustCurve(std::move(commands), std::move(thrusts_n), path);
           }),
           py::arg("commands"), py::arg("thrusts_n"), py::arg("path") = "thrust_curve",
           "Raises ValueError unless commands increase, thrusts never fall and command 0 gives 0 N.")
      .def("thrust_n", &ThrustCurve::thrust_n, py::arg("command"))
      .def("command", &ThrustCurve::command, py::arg("thrust_n"), "A command that gives this thrust.")
      .def_property_readonly("lowest_n", &ThrustCurve::lowest_n)
      .def_property_readonly("highest_n", &ThrustCurve::highest_n);

  py::class_<ThrusterParameters>(m, "ThrusterParameters", "A propeller with its motor, body frame.")
      .def(py::init(
               [](std::string name, const py::object& position_body_m, const py::object& axis_body, ThrustCurve curve) {
                 ThrusterParameters p;
                 p.name = std::move(name);
                 p.position_body_m = as_vector3(position_body_m, "position_body_m");
                 p.axis_body = as_vector3(axis_body, "axis_body").normalized();
                 p.curve = std::move(curve);
                 return p;
               }),
           py::arg("name"), py::arg("position_body_m"), py::arg("axis_body"), py::arg("curve"))
      .def_readonly("name", &ThrusterParameters::name)
      .def_readonly("position_body_m", &ThrusterParameters::position_body_m, "(3,) [m], hub")
      .def_readonly("axis_body", &ThrusterParameters::axis_body, "(3,) unit, where a positive thrust pushes")
      .def_readonly("curve", &ThrusterParameters::curve)
      .def_readwrite("time_constant_s", &ThrusterParameters::time_constant_s, "of the thrust; 0 follows at once")
      .def_readwrite("diameter_m", &ThrusterParameters::diameter_m)
      .def_readwrite("bollard_coefficient", &ThrusterParameters::bollard_coefficient, "K_T at rest")
      .def_readwrite("zero_thrust_advance_ratio", &ThrusterParameters::zero_thrust_advance_ratio, "inf: no loss")
      .def_readwrite("torque_per_thrust_m", &ThrusterParameters::torque_per_thrust_m, "k_q [m]")
      .def_readwrite("spin", &ThrusterParameters::spin, "1 right-handed about the axis, -1 left-handed");

  py::class_<FinParameters>(m, "FinParameters", "A lifting surface, body frame.")
      .def(py::init([](std::string name, const py::object& position_body_m, const py::object& span_body, double area_m2,
                       double aspect_ratio) {
             FinParameters p;
             p.name = std::move(name);
             p.position_body_m = as_vector3(position_body_m, "position_body_m");
             p.span_body = as_vector3(span_body, "span_body").normalized();
             p.area_m2 = area_m2;
             p.aspect_ratio = aspect_ratio;
             return p;
           }),
           py::arg("name"), py::arg("position_body_m"), py::arg("span_body"), py::arg("area_m2"),
           py::arg("aspect_ratio"))
      .def_readonly("name", &FinParameters::name)
      .def_readonly("position_body_m", &FinParameters::position_body_m, "(3,) [m], centre of pressure")
      .def_readonly("span_body", &FinParameters::span_body, "(3,) unit; a deflection turns about it, right-handed")
      .def_readonly("area_m2", &FinParameters::area_m2)
      .def_readonly("aspect_ratio", &FinParameters::aspect_ratio)
      .def_readwrite("parasitic_drag", &FinParameters::parasitic_drag)
      .def_readwrite("efficiency", &FinParameters::efficiency, "Oswald's")
      .def_readwrite("stall_angle_rad", &FinParameters::stall_angle_rad)
      .def_readwrite("stall_sharpness_rad", &FinParameters::stall_sharpness_rad)
      .def_readwrite("stalls", &FinParameters::stalls)
      .def_readwrite("deflection_max_rad", &FinParameters::deflection_max_rad, "0: fixed")
      .def_readwrite("rate_max_rad_s", &FinParameters::rate_max_rad_s)
      .def("lift_slope", &FinParameters::lift_slope, "dC_L / d alpha at no lift [1/rad].");

  py::class_<ActuatorsSpec>(m, "ActuatorsSpec", "What drives and steers a vehicle.")
      .def(py::init<>())
      .def_readwrite("full_wrench_body", &ActuatorsSpec::full_wrench_body,
                     "(6,) force and torque straight along and about the axes at full effort [N, N m]")
      .def_readwrite("thrusters", &ActuatorsSpec::thrusters)
      .def_readwrite("fins", &ActuatorsSpec::fins);
}

template <typename Part, typename Value>
std::vector<std::pair<std::string, double>> by_name(const std::vector<Part>& parts, Value value) {
  std::vector<std::pair<std::string, double>> named;
  for (const Part& part : parts) named.emplace_back(part.parameters().name, value(part));
  return named;
}

/// A method of the simulation that looks at a vehicle's actuators with the GIL released.
template <typename Look>
auto looking(Look look) {
  return [look](OwnedSimulation& owned, std::size_t vehicle) {
    return owned.with([&](Simulation& sim) { return look(std::as_const(sim).actuators(vehicle)); });
  };
}

}  // namespace

void bind_commands(py::class_<OwnedSimulation>& simulation) {
  const auto vehicle = py::arg("vehicle");
  simulation
      .def(
          "set_effort",
          [](OwnedSimulation& o, std::size_t v, const Vector6d& effort) {
            o.with([&](Simulation& s) { s.actuators(v).set_effort(effort); });
          },
          vehicle, py::arg("effort"), "(6,) surge sway heave roll pitch yaw in [-1, 1]. Raises ValueError.")
      .def("effort", looking([](const Actuators& a) { return Vector6d(a.effort()); }), vehicle)
      .def(
          "set_wrench",
          [](OwnedSimulation& o, std::size_t v, const Vector6d& wrench_body) {
            o.with([&](Simulation& s) { s.actuators(v).set_wrench(wrench_body); });
          },
          vehicle, py::arg("wrench_body"), "(6,) [N, N m]; beyond the thrusters it keeps its direction.")
      .def(
          "set_thrusters",
          [](OwnedSimulation& o, std::size_t v, const Actuators::Named& commands) {
            o.with([&](Simulation& s) { s.actuators(v).set_thrusters(commands); });
          },
          vehicle, py::arg("commands"), "(name, command in [-1, 1]) pairs; unnamed ones stop. Raises ValueError.")
      .def(
          "set_fins",
          [](OwnedSimulation& o, std::size_t v, const Actuators::Named& angles_rad) {
            o.with([&](Simulation& s) { s.actuators(v).set_fins(angles_rad); });
          },
          vehicle, py::arg("angles_rad"), "(name, deflection) pairs; unnamed ones centre. Raises ValueError.")
      .def("controllable", looking([](const Actuators& a) { return a.controllable(); }), vehicle,
           "Whether an effort does something, surge to yaw.")
      .def("full_wrench_body", looking([](const Actuators& a) { return a.full_wrench_body(); }), vehicle,
           "Two (6,): the largest wrench about each axis alone, ahead and astern, magnitudes [N, N m].")
      .def("thruster_commands", looking([](const Actuators& a) {
             return by_name(a.thrusters(), [](const Thruster& t) { return t.command(); });
           }),
           vehicle, "(name, command) pairs.")
      .def("thrusts_n", looking([](const Actuators& a) {
             return by_name(a.thrusters(), [](const Thruster& t) { return t.thrust_n(); });
           }),
           vehicle, "(name, still-water thrust now [N]) pairs.")
      .def("fin_angles_rad", looking([](const Actuators& a) {
             std::vector<Fin> movable;
             std::copy_if(a.fins().begin(), a.fins().end(), std::back_inserter(movable),
                          [](const Fin& f) { return f.parameters().deflection_max_rad > 0; });
             return by_name(movable, [](const Fin& f) { return f.angle_rad(); });
           }),
           vehicle, "(name, deflection now [rad]) pairs of those that move.");
}

void bind_actuators(py::module_& m) { bind_parts(m); }

}  // namespace uwsim::bindings
