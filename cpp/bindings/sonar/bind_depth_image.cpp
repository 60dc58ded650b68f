#include <pybind11/stl.h>

#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/gil.h"
#include "bindings/sonar/angles.h"
#include "bindings/sonar/binders.h"
#include "uwsim/sonar/depth_image.h"

namespace uwsim::bindings {
namespace {

using Depths = py::array_t<float>;

Depths render(const DepthCamera& camera, const RayScene& scene, const py::object& position_m,
              const py::object& orientation_xyzw, int threads) {
  const Pose pose = as_pose(position_m, orientation_xyzw, "camera");
  DepthImage image;
  {
    const GilReleased unlocked;
    image = depth_image(camera, scene, pose, threads);
  }
  return move_out(std::move(image.depth_m), {camera.height, camera.width});
}

Depths ranges(const DepthCamera& camera, const py::object& depth_m, const py::object& angles_rad,
              RowReduction reduction, bool interpolate) {
  camera.check();
  const auto depths = as_array<float>(depth_m, "depth_m", {camera.height, camera.width});
  const DepthImage image{camera, {depths.data(), depths.data() + depths.size()}};
  return move_out(depth_image_ranges(image, as_angles(angles_rad), reduction, interpolate));
}

}  // namespace

void bind_depth_image(py::module_& m) {
  py::class_<DepthCamera>(m, "DepthCamera",
                          "Parameters of a depth camera; see uwsim.instruments.sonars.depth_map.DepthMap.")
      .def(py::init<>())
      .def_readwrite("width", &DepthCamera::width)
      .def_readwrite("height", &DepthCamera::height)
      .def_readwrite("horizontal_fov_rad", &DepthCamera::horizontal_fov_rad)
      .def_readwrite("vertical_fov_rad", &DepthCamera::vertical_fov_rad)
      .def_readwrite("range_max_m", &DepthCamera::range_max_m)
      .def_readwrite("depth_bits", &DepthCamera::depth_bits)
      .def("check", &DepthCamera::check, "Raise ValueError if a parameter is invalid.");
  py::enum_<RowReduction>(m, "RowReduction")
      .value("MIDDLE", RowReduction::kMiddle)
      .value("NEAREST", RowReduction::kNearest);
  m.def("depth_image", &render, py::arg("camera"), py::arg("scene"), py::arg("position_m"), py::arg("orientation_xyzw"),
        py::arg("threads") = 1,
        "Return a depth image, (height, width) float32 along the camera's x axis, inf if nothing is hit. Raises\n"
        "ValueError. Releases the GIL.");
  m.def("depth_image_ranges", &ranges, py::arg("camera"), py::arg("depth_m"), py::arg("angles_rad"),
        py::arg("reduction"), py::arg("interpolate"),
        "Return the ranges (n,) float32, inf for no echo, from depth_m (height, width) and angles_rad (n,).\n"
        "Raises ValueError.");
}

}  // namespace uwsim::bindings
