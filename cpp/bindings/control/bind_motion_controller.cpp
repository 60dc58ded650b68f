#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <memory>

#include "bindings/control/binders.h"
#include "bindings/control/estimate.h"
#include "uwsim/control/motion_controller.h"

namespace uwsim::bindings {
namespace {

/// Returns a control loop's state as an array of numbers, which missions can save.
py::array_t<double> memory_out(const MotionController& controller) {
  const MotionMemory& m = controller.memory;
  Eigen::Matrix<double, 25, 1> numbers;
  numbers << m.integral_world, m.integral_body, m.velocity_world_m_s, m.turn_body_rad_s, m.measured_body,
      m.derivative_body, m.begun ? 1.0 : 0.0;
  return py::cast(numbers);
}

void memory_in(MotionController& controller, const Eigen::Matrix<double, 25, 1>& numbers) {
  require(numbers.allFinite(), "memory", "non-finite", "must be finite");
  MotionMemory& m = controller.memory;
  m.integral_world = numbers.segment<3>(0);
  m.integral_body = numbers.segment<3>(3);
  m.velocity_world_m_s = numbers.segment<3>(6);
  m.turn_body_rad_s = numbers.segment<3>(9);
  m.measured_body = numbers.segment<6>(12);
  m.derivative_body = numbers.segment<6>(18);
  m.begun = numbers[24] != 0;
}

}  // namespace

void bind_motion_controller(py::module_& m) {
  py::class_<PidGains>(m, "PidGains")
      .def(py::init([](double proportional, double integral, double derivative, double filter_s, double tracking_s) {
             return PidGains{proportional, integral, derivative, filter_s, tracking_s};
           }),
           py::kw_only(), py::arg("proportional"), py::arg("integral") = 0.0, py::arg("derivative") = 0.0,
           py::arg("filter_s") = 0.1, py::arg("tracking_s") = 1.0);
  py::class_<Pid>(m, "Pid", "A PID controller with a filtered derivative and anti-windup by back-calculation.")
      .def(py::init<>())
      .def(
          "output",
          [](Pid& pid, double error, double measured, const PidGains& gains, double period_s) {
            return pid.output(error, measured, gains, period_s);
          },
          py::arg("error"), py::arg("measured"), py::arg("gains"), py::arg("period_s"))
      .def("settle", &Pid::settle, py::arg("applied"), py::arg("gains"), py::arg("period_s"),
           "Complete the period with the output that the actuators actually delivered.")
      .def_readonly("integral", &Pid::integral)
      .def_readonly("derivative", &Pid::derivative);

  py::class_<ControlModel>(m, "ControlModel", "A controller's model of its vehicle, in deep, still water.")
      .def(py::init([](std::shared_ptr<Craft> craft, const ActuatorsSpec& actuators, double density_kg_m3,
                       double gravity_m_s2) {
             return ControlModel(std::move(craft), actuators, density_kg_m3, gravity_m_s2);
           }),
           py::arg("craft").none(false), py::arg("actuators"), py::arg("density_kg_m3"),
           py::arg("gravity_m_s2") = EvenWater().gravity_m_s2)
      .def_property_readonly("driven", &ControlModel::driven,
                             "For each axis, surge to yaw, whether thrusters or fins drive it.")
      .def("reachable", &ControlModel::reachable, py::arg("wrench_body"), py::arg("surge_m_s") = 0.0,
           py::arg("across_first") = false,
           "Return the part of a requested wrench (6,) that thrusters, and fins at the given speed ahead, can\n"
           "deliver. Torque takes priority over force; both keep their direction. With across_first, force across\n"
           "the vehicle takes priority over force along it.")
      .def("effort", &ControlModel::effort, py::arg("wrench_body"), py::arg("surge_m_s") = 0.0,
           "Return the efforts (6,) for a reachable wrench (6,).")
      .def(
          "wrench_body",
          [](const ControlModel& model, const Eigen::Matrix3d& world_from_body, const Vector6d& velocity,
             const Vector6d& acceleration) { return model.wrench_body(world_from_body, velocity, acceleration); },
          py::arg("world_from_body"), py::arg("velocity"), py::arg("acceleration"),
          "Return the wrench (6,) for an acceleration (6,) at a rotation (3, 3) and velocity (6,), in body axes.");

  py::class_<LoopGains>(m, "LoopGains", "The cascade of one axis: position, velocity, acceleration.")
      .def(py::init([](double position_1_s, double velocity_1_s, double integral_1_s2, double acceleration_1) {
             return LoopGains{position_1_s, velocity_1_s, integral_1_s2, acceleration_1};
           }),
           py::kw_only(), py::arg("position_1_s"), py::arg("velocity_1_s"), py::arg("integral_1_s2"),
           py::arg("acceleration_1"));
  py::class_<ControlGains>(m, "ControlGains", "Gains and limits of all loops.")
      .def(py::init([](const std::array<LoopGains, 6>& loops, double filter_s, double tracking_s, double speed_max_m_s,
                       double climb_max_m_s, double turn_max_rad_s, double acceleration_max_m_s2,
                       double turn_acceleration_max_rad_s2) {
             return ControlGains{loops,
                                 filter_s,
                                 tracking_s,
                                 speed_max_m_s,
                                 climb_max_m_s,
                                 turn_max_rad_s,
                                 acceleration_max_m_s2,
                                 turn_acceleration_max_rad_s2};
           }),
           py::kw_only(), py::arg("loops"), py::arg("filter_s"), py::arg("tracking_s"), py::arg("speed_max_m_s"),
           py::arg("climb_max_m_s"), py::arg("turn_max_rad_s"), py::arg("acceleration_max_m_s2"),
           py::arg("turn_acceleration_max_rad_s2"));

  py::class_<MotionController>(m, "MotionController", "Position, depth, heading, attitude and velocity control.")
      .def(py::init<ControlModel, const ControlGains&, double>(), py::arg("model"), py::arg("gains"),
           py::arg("period_s"), "Create a controller. Raises ValueError for invalid gains.")
      .def(
          "reach",
          [](MotionController& controller, const py::object& pose, const py::object& velocity,
             const Eigen::Vector3d& position_world_m, const Eigen::Vector3d& velocity_world_m_s, double roll_rad,
             double pitch_rad, double heading_rad, bool across_first) {
            return as_efforts(controller.reach(
                as_estimate(pose, velocity),
                {position_world_m, velocity_world_m_s, roll_rad, pitch_rad, heading_rad, across_first}));
          },
          py::arg("pose"), py::arg("velocity"), py::arg("position_world_m"), py::arg("velocity_world_m_s"),
          py::arg("roll_rad"), py::arg("pitch_rad"), py::arg("heading_rad"), py::arg("across_first") = false,
          "Return the efforts of one control period for reaching a position (3,) that moves at a velocity (3,);\n"
          "positions that are NaN are not controlled. across_first: see ControlModel.reachable. pose, velocity:\n"
          "see Autopilot.steer.")
      .def(
          "hold_velocity",
          [](MotionController& controller, const py::object& pose, const py::object& velocity,
             const Vector6d& velocity_body) {
            return as_efforts(controller.hold_velocity(as_estimate(pose, velocity), velocity_body));
          },
          py::arg("pose"), py::arg("velocity"), py::arg("velocity_body"),
          "Return the efforts of one control period for maintaining a velocity (6,) in body axes, [m/s] and\n"
          "[rad/s].")
      .def_property_readonly("force_share", &MotionController::force_share,
                             "The fraction of the requested force that the thrusters delivered in the last period.")
      .def_property("memory", &memory_out, &memory_in,
                    "The state (25,) carried from one period to the next, which can be saved.");
}

}  // namespace uwsim::bindings
