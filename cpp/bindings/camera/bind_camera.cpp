#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings/binders.h"
#include "bindings/camera/bands.h"
#include "bindings/camera/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/gil.h"
#include "uwsim/camera/camera.h"
#include "uwsim/camera/lamp.h"

namespace uwsim::bindings {
namespace {

py::array_t<float> ray_table_of(const Camera& camera, bool distort) {
  const RayTable& rays = camera.rays(distort);
  std::vector<float> both;
  both.reserve(2 * rays.x.size());
  for (std::size_t k = 0; k < rays.x.size(); ++k) {
    both.push_back(rays.x[k]);
    both.push_back(rays.y[k]);
  }
  return move_out(std::move(both), {camera.lens().height, camera.lens().width, 2});
}

void bind_lens(py::module_& m) {
  py::class_<Lens>(m, "Lens",
                   "Distortion as in OpenCV and CameraInfo (plumb_bob), in pixels; lens.h contains the equations.")
      .def(py::init([](int width, int height, double fx, double fy, double cx, double cy,
                       const std::array<double, 5>& distortion) {
             const auto& [k1, k2, p1, p2, k3] = distortion;
             return Lens{width, height, fx, fy, cx, cy, k1, k2, p1, p2, k3};
           }),
           py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"),
           py::arg("distortion") = std::array<double, 5>{}, "distortion: k1, k2, p1, p2, k3");
  py::class_<Camera, std::shared_ptr<Camera>>(m, "Camera",
                                              "A camera: lens and image sensor. Raises ValueError naming the field.")
      .def(py::init([](std::string name, const Lens& lens, double exposure, double full_well, double read_noise,
                       double vignetting, std::optional<double> wobble_rad) {
             const GilReleased unlocked;  // building the ray tables takes a while
             return std::make_shared<Camera>(std::move(name), lens,
                                             ImageSensor{exposure, full_well, read_noise, vignetting, wobble_rad});
           }),
           py::arg("name"), py::arg("lens"), py::arg("exposure") = ImageSensor{}.exposure,
           py::arg("full_well") = ImageSensor{}.full_well, py::arg("read_noise") = ImageSensor{}.read_noise,
           py::arg("vignetting") = ImageSensor{}.vignetting, py::arg("wobble_rad") = py::none())
      .def_property_readonly("name", &Camera::name)
      .def("ray_table", &ray_table_of, py::arg("distort") = true,
           "Return X/Z and Y/Z of the ray through each pixel's centre, in the optical frame, (height, width, 2)\n"
           "float32.");
}

void bind_lamp(py::module_& m) {
  m.def(
      "mounted_pose",
      [](const py::object& position_m, const py::object& orientation_xyzw, const py::object& mount_position_m,
         const py::object& mount_orientation_xyzw) {
        const Pose pose = as_pose(position_m, orientation_xyzw, "carrier") *
                          as_pose(mount_position_m, mount_orientation_xyzw, "mount");
        return std::tuple(pose.position_m, Eigen::Vector4d(pose.orientation.coeffs()), pose.matrix());
      },
      py::arg("position_m"), py::arg("orientation_xyzw"), py::arg("mount_position_m"),
      py::arg("mount_orientation_xyzw"),
      "Return the pose of an object mounted on a carrier: position (3,), orientation (4,) as x, y, z, w, and\n"
      "both as (4, 4).");
  py::class_<SpotLamp>(m, "SpotLamp", "A spot lamp that shines along its x axis; an irradiance of 1 is 1e5 lx.")
      .def(py::init([](const py::object& position_m, const py::object& orientation_xyzw, double flux_lm,
                       double half_angle_rad, double soft_share, const py::object& colour) {
             SpotLamp lamp{as_pose(position_m, orientation_xyzw, "lamp"), flux_lm, half_angle_rad, soft_share,
                           as_bands(colour, "lamp.colour")};
             lamp.check();
             return lamp;
           }),
           py::arg("position_m"), py::arg("orientation_xyzw"), py::arg("flux_lm"), py::arg("half_angle_rad"),
           py::arg("soft_share"), py::arg("colour"));
}

}  // namespace

void bind_camera(py::module_& m) {
  bind_optics(m);
  bind_lens(m);
  bind_lamp(m);
  bind_picture(m);
  bind_camera_scene(m);
}

}  // namespace uwsim::bindings
