#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "bindings/core/convert.h"
#include "bindings/vehicle/binders.h"
#include "uwsim/vehicle/actuators.h"
#include "uwsim/vehicle/battery_cells.h"
#include "uwsim/vehicle/windage.h"

namespace uwsim::bindings {
void bind_actuators(py::module_& m) {
  py::class_<ThrustCurve>(m, "ThrustCurve",
                          "Thrust in still water as a function of a command in [-1, 1], linear between points.")
      .def(py::init([](std::vector<double> commands, std::vector<double> thrusts_n, const std::string& path) {
             return ThrustCurve(std::move(commands), std::move(thrusts_n), path);
           }),
           py::arg("commands"), py::arg("thrusts_n"), py::arg("path") = "thrust_curve",
           "Create a curve. Raises ValueError unless commands increase, thrusts never decrease and command 0 maps\n"
           "to 0 N.")
      .def("thrust_n", &ThrustCurve::thrust_n, py::arg("command"))
      .def("command", &ThrustCurve::command, py::arg("thrust_n"), "Return a command that produces this thrust.")
      .def_property_readonly("lowest_n", &ThrustCurve::lowest_n)
      .def_property_readonly("highest_n", &ThrustCurve::highest_n);

  py::class_<ThrusterSheet>(m, "ThrusterSheet", "A thruster's performance in still water at one supply voltage.")
      .def(py::init([](double voltage_v, const py::object& commands, const py::object& thrusts_n,
                       const py::object& currents_a, const py::object& rpm) {
             return ThrusterSheet{voltage_v, as_numbers(commands, "commands"), as_numbers(thrusts_n, "thrusts_n"),
                                  as_numbers(currents_a, "currents_a"), as_numbers(rpm, "rpm")};
           }),
           py::arg("voltage_v"), py::arg("commands"), py::arg("thrusts_n"), py::arg("currents_a"), py::arg("rpm"))
      .def_readonly("voltage_v", &ThrusterSheet::voltage_v);

  py::class_<ThrusterSheets>(m, "ThrusterSheets",
                             "Thrust, current and revolutions by command and supply voltage, between measured sheets.")
      .def(py::init([](std::vector<ThrusterSheet> sheets, const std::string& path) {
             return ThrusterSheets(std::move(sheets), path);
           }),
           py::arg("sheets"), py::arg("path") = "sheets",
           "Raises ValueError unless voltages and commands increase, command 0 gives 0 N and no current is negative.")
      .def_property_readonly("voltages_v", &ThrusterSheets::voltages_v)
      .def(
          "at",
          [](const ThrusterSheets& sheets, double command, double voltage_v) {
            const ThrusterSheets::Point p = sheets.at(command, voltage_v);
            return py::make_tuple(p.thrust_n, p.current_a, p.rpm);
          },
          py::arg("command"), py::arg("voltage_v"),
          "Thrust [N], current [A] and revolutions [1/min]. Raises ValueError beyond the sheets' voltages.");

  py::class_<BatterySpec>(m, "BatterySpec", "Cells with a voltage that falls with charge and load.")
      .def(py::init<>())
      .def_readwrite("capacity_ah", &BatterySpec::capacity_ah)
      .def_readwrite("charges", &BatterySpec::charges, "fractions of the capacity, from 0 to 1")
      .def_readwrite("open_circuit_v", &BatterySpec::open_circuit_v, "at each charge, at rest")
      .def_readwrite("resistance_ohm", &BatterySpec::resistance_ohm)
      .def_readwrite("cutoff_v", &BatterySpec::cutoff_v, "below this voltage it switches off")
      .def_readwrite("hotel_w", &BatterySpec::hotel_w, "power of everything but the thrusters")
      .def_readwrite("initial_charge", &BatterySpec::initial_charge, "fraction");

  py::class_<ThrusterParameters>(m, "ThrusterParameters", "A propeller and its motor, body frame.")
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
      .def_readonly("position_body_m", &ThrusterParameters::position_body_m, "position of the hub (3,) [m]")
      .def_readonly("axis_body", &ThrusterParameters::axis_body, "(3,) unit, direction of a positive thrust")
      .def_readonly("curve", &ThrusterParameters::curve)
      .def_readwrite("sheets", &ThrusterParameters::sheets, "for a supply whose voltage varies")
      .def_readwrite("time_constant_s", &ThrusterParameters::time_constant_s, "of the thrust; 0 for no lag")
      .def_readwrite("diameter_m", &ThrusterParameters::diameter_m)
      .def_readwrite("bollard_coefficient", &ThrusterParameters::bollard_coefficient, "K_T at zero speed")
      .def_readwrite("zero_thrust_advance_ratio", &ThrusterParameters::zero_thrust_advance_ratio,
                     "inf if thrust does not decrease with speed")
      .def_readwrite("is_vertical", &ThrusterParameters::is_vertical,
                     "a force along the world's vertical: buoyancy or weight")
      .def_property(
          "counter_body_m", [](const ThrusterParameters& p) { return p.counter_body_m; },
          [](ThrusterParameters& p, const py::object& at) {
            p.counter_body_m = at.is_none() ? std::nullopt : std::optional(as_vector3(at, "counter_body_m"));
          },
          "(3,), where the opposite of a vertical force acts [m]; None: nowhere")
      .def_readwrite("ventilates", &ThrusterParameters::ventilates, "draws air near the surface")
      .def_readwrite("health", &ThrusterParameters::health,
                     "fraction of the thrust that remains after a fault; the allocation does not account for it")
      .def_readwrite("torque_per_thrust_m", &ThrusterParameters::torque_per_thrust_m, "k_q [m]")
      .def_readwrite("spin", &ThrusterParameters::spin,
                     "1 right-handed, -1 left-handed about the axis when thrusting ahead");

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
      .def_readonly("position_body_m", &FinParameters::position_body_m, "centre of pressure (3,) [m]")
      .def_readonly("span_body", &FinParameters::span_body, "(3,) unit; deflections are right-handed about it")
      .def_readonly("area_m2", &FinParameters::area_m2)
      .def_readonly("aspect_ratio", &FinParameters::aspect_ratio)
      .def_readwrite("parasitic_drag", &FinParameters::parasitic_drag)
      .def_readwrite("efficiency", &FinParameters::efficiency, "Oswald efficiency factor")
      .def_readwrite("stall_angle_rad", &FinParameters::stall_angle_rad)
      .def_readwrite("stall_sharpness_rad", &FinParameters::stall_sharpness_rad)
      .def_readwrite("stalls", &FinParameters::stalls)
      .def_readwrite("deflection_max_rad", &FinParameters::deflection_max_rad, "0: fixed")
      .def_readwrite("rate_max_rad_s", &FinParameters::rate_max_rad_s)
      .def_readwrite("slipstream_of", &FinParameters::slipstream_of, "name of a thruster; none if empty")
      .def("lift_slope", &FinParameters::lift_slope, "Return dC_L / d alpha at zero lift [1/rad].");

  py::class_<Windage>(m, "Windage", "What a wind meets of a hull that floats (Fossen 2011, sec. 8.1).")
      .def(py::init<>())
      .def_readwrite("frontal_area_m2", &Windage::frontal_area_m2)
      .def_readwrite("lateral_area_m2", &Windage::lateral_area_m2)
      .def_readwrite("length_m", &Windage::length_m)
      .def_readwrite("height_m", &Windage::height_m, "of the areas' centre above the body's origin")
      .def_readwrite("surge", &Windage::surge, "c_x")
      .def_readwrite("sway", &Windage::sway, "c_y")
      .def_readwrite("yaw", &Windage::yaw, "c_n")
      .def_readwrite("speed_share", &Windage::speed_share, "the wind at that height, relative to that at 10 m")
      .def_readwrite("dry_volume_m3", &Windage::dry_volume_m3, "of the hull above the water as it floats");

  py::class_<ActuatorsSpec>(m, "ActuatorsSpec", "The thrusters and fins of a vehicle.")
      .def(py::init<>())
      .def_readwrite("full_wrench_body", &ActuatorsSpec::full_wrench_body,
                     "(6,) direct force and torque along and about the axes at full effort, without thrusters [N, N m]")
      .def_readwrite("thrusters", &ActuatorsSpec::thrusters)
      .def_readwrite("fins", &ActuatorsSpec::fins);
}

}  // namespace uwsim::bindings
