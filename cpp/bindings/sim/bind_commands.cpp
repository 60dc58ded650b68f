#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "bindings/sim/binders.h"
#include "uwsim/vehicle/actuators.h"

namespace uwsim::bindings {
namespace {

/// Returns a pair (name, value(part)) for each thruster or fin.
template <typename Part, typename Value>
std::vector<std::pair<std::string, double>> by_name(const std::vector<Part>& parts, Value value) {
  std::vector<std::pair<std::string, double>> named;
  for (const Part& part : parts) named.emplace_back(part.parameters().name, value(part));
  return named;
}

/// Binds a method of the simulation that reads a vehicle's actuators with the GIL released.
template <typename Read>
auto reading(Read read) {
  return [read](OwnedSimulation& owned, std::size_t vehicle) {
    return owned.with([&](Simulation& sim) { return read(std::as_const(sim).actuators(vehicle)); });
  };
}

}  // namespace

void bind_commands(py::class_<OwnedSimulation>& simulation) {
  const auto vehicle = py::arg("vehicle");
  simulation
      .def(
          "set_effort",
          [](OwnedSimulation& o, std::size_t v, double surge, double sway, double heave, double roll, double pitch,
             double yaw) {
            const Vector6d effort{surge, sway, heave, roll, pitch, yaw};
            o.with_briefly([&](Simulation& s) { s.actuators(v).set_effort(effort); });
          },
          vehicle, py::arg("surge"), py::arg("sway"), py::arg("heave"), py::arg("roll"), py::arg("pitch"),
          py::arg("yaw"), "Set the efforts, each in [-1, 1]. Raises ValueError.")
      .def("effort", reading([](const Actuators& a) { return Vector6d(a.effort()); }), vehicle)
      .def(
          "set_wrench",
          [](OwnedSimulation& o, std::size_t v, const Vector6d& wrench_body) {
            o.with([&](Simulation& s) { s.actuators(v).set_wrench(wrench_body); });
          },
          vehicle, py::arg("wrench_body"),
          "Set the wrench (6,) [N, N m]; a wrench beyond the thrusters' limits is scaled down in its direction.\n"
          "Raises ValueError.")
      .def(
          "set_thrusters",
          [](OwnedSimulation& o, std::size_t v, const Actuators::Named& commands) {
            o.with([&](Simulation& s) { s.actuators(v).set_thrusters(commands); });
          },
          vehicle, py::arg("commands"),
          "Set thruster commands from (name, command in [-1, 1]) pairs; the others stop. Raises ValueError.")
      .def(
          "set_fins",
          [](OwnedSimulation& o, std::size_t v, const Actuators::Named& angles_rad) {
            o.with([&](Simulation& s) { s.actuators(v).set_fins(angles_rad); });
          },
          vehicle, py::arg("angles_rad"),
          "Set fin deflections from (name, deflection [rad]) pairs; the others are centred. Raises ValueError.")
      .def("controllable", reading([](const Actuators& a) { return a.controllable(); }), vehicle,
           "Return, for each axis, surge to yaw, whether an effort about it has an effect.")
      .def("full_wrench_body", reading([](const Actuators& a) { return a.full_wrench_body(); }), vehicle,
           "Return two arrays (6,): magnitudes of the largest wrench along or about each axis alone, forward and\n"
           "backward [N, N m].")
      .def("thruster_commands", reading([](const Actuators& a) {
             return by_name(a.thrusters(), [](const Thruster& t) { return t.command(); });
           }),
           vehicle, "Return (name, command) pairs.")
      .def("thrusts_n", reading([](const Actuators& a) {
             return by_name(a.thrusters(), [](const Thruster& t) { return t.thrust_n(); });
           }),
           vehicle, "Return (name, present still-water thrust [N]) pairs.")
      .def("currents_a", reading([](const Actuators& a) {
             return by_name(a.thrusters(), [](const Thruster& t) { return t.current_a(); });
           }),
           vehicle, "(name, present current [A]) pairs; 0 without a battery that has cells.")
      .def("fin_angles_rad", reading([](const Actuators& a) {
             std::vector<Fin> movable;
             std::copy_if(a.fins().begin(), a.fins().end(), std::back_inserter(movable),
                          [](const Fin& f) { return f.parameters().deflection_max_rad > 0; });
             return by_name(movable, [](const Fin& f) { return f.angle_rad(); });
           }),
           vehicle, "Return (name, present deflection [rad]) pairs of the fins that can be deflected.");
}

}  // namespace uwsim::bindings
