#include <pybind11/eigen.h>

#include "bindings/binders.h"
#include "bindings/control/binders.h"
#include "bindings/control/estimate.h"
#include "uwsim/control/autopilot.h"

namespace uwsim::bindings {
namespace {

/// Reads the two components of a tuple, list or array (2,) without creating an array.
Eigen::Vector2d as_pair(const py::object& object, const char* name) {
  const py::sequence pair(object);
  require(pair.size() == 2, std::string(name) + ".shape", pair.size(), "expected (2,)");
  return {py::float_(pair[0]), py::float_(pair[1])};
}

}  // namespace

void bind_control(py::module_& m) {
  py::class_<AutopilotGains>(m, "AutopilotGains", "Gains in full effort per unit of error.")
      .def(py::init([](double speed, double speed_integral, double heading, double heading_rate, double height,
                       double height_rate, double height_integral, double level, double level_rate) {
             return AutopilotGains{speed,       speed_integral,  heading, heading_rate, height,
                                   height_rate, height_integral, level,   level_rate};
           }),
           py::kw_only(), py::arg("speed"), py::arg("speed_integral"), py::arg("heading"), py::arg("heading_rate"),
           py::arg("height"), py::arg("height_rate"), py::arg("height_integral"), py::arg("level"),
           py::arg("level_rate"));

  py::class_<Autopilot>(
      m, "Autopilot",
      "Maintains heading, horizontal velocity and height, and keeps the vehicle level, without a model of it.")
      .def(py::init<double, const AutopilotGains&>(), py::arg("period_s"), py::arg("gains"))
      .def_readwrite("gains", &Autopilot::gains)
      .def_readwrite("integrals", &Autopilot::integrals,
                     "Integrals of surge, sway and height (3,), in units of effort.")
      .def(
          "steer",
          [](Autopilot& autopilot, const py::object& pose, const py::object& velocity, double heading_rad,
             const py::object& velocity_world_m_s, double z_world_m) {
            const Course course{heading_rad, as_pair(velocity_world_m_s, "velocity_world_m_s"), z_world_m};
            return as_efforts(autopilot.steer(as_estimate(pose, velocity), course));
          },
          py::arg("pose"), py::arg("velocity"), py::arg("heading_rad"), py::arg("velocity_world_m_s"),
          py::arg("z_world_m"),
          "Return the efforts of one control period, surge to yaw, each in [-1, 1]. pose has world_from_body (4,\n"
          "4); velocity has linear_body_m_s (3,) and angular_body_rad_s (3,). Raises ValueError for other shapes.");
  bind_motion_controller(m);
  bind_path_follower(m);
}

}  // namespace uwsim::bindings
