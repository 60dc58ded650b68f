#include <pybind11/eigen.h>

#include "bindings/control/binders.h"
#include "bindings/core/convert.h"
#include "bindings/core/record.h"
#include "uwsim/control/path_follower.h"

namespace uwsim::bindings {
void bind_path_follower(py::module_& m) {
  Record<Guidance>(m, "Guidance", "Guidance along a path from a given position.")
      .field("course_rad", &Guidance::course_rad,
             "direction of the commanded velocity, from the world's x axis, counter-clockwise")
      .field("path_rad", &Guidance::path_rad, "direction of the path segment")
      .field("cross_track_m", &Guidance::cross_track_m, "distance from the path, positive to port")
      .field("along_m", &Guidance::along_m, "distance travelled along the path")
      .field("left_m", &Guidance::left_m, "remaining distance to the path's end")
      .field("z_world_m", &Guidance::z_world_m, "height of the path abeam of the vehicle")
      .field("is_done", &Guidance::is_done, "whether the end has been passed")
      .done();
  py::class_<PathFollower>(m, "PathFollower", "Line-of-sight guidance along straight segments.")
      .def(py::init([](const py::object& points_m, double lookahead_m, double integral_m_s, double period_s) {
             return PathFollower(as_points(points_m, "points_m"), lookahead_m, integral_m_s, period_s);
           }),
           py::arg("points_m"), py::arg("lookahead_m"), py::arg("integral_m_s"), py::arg("period_s"),
           "points_m: (n, 3), at least two vertices. Raises ValueError.")
      .def("guide", &PathFollower::guide, py::arg("position_world_m"), "Return guidance for one control period.")
      .def("pace", &PathFollower::pace, py::arg("course_rad"), py::arg("speed_m_s"), py::arg("force_share"),
           "Adapt the pace for one control period to the share of the force that the thrusters delivered, and return\n"
           "the velocity over ground (2,) along a course.")
      .def_readwrite("segment", &PathFollower::segment)
      .def_readwrite("integral_s", &PathFollower::integral_s);
}

}  // namespace uwsim::bindings
