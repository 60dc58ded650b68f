#include <pybind11/eigen.h>
#include <pybind11/stl.h>

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
#include "uwsim/core/check.h"

namespace uwsim::bindings {
namespace {

py::array_t<float> by_pixel(const Lens& lens, const std::vector<float>& x, const std::vector<float>& y) {
  std::vector<float> both(2 * static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height));
  for (std::size_t k = 0; k < x.size(); ++k) both[2 * k] = x[k], both[2 * k + 1] = y[k];
  return move_out(std::move(both), {lens.height, lens.width, 2});
}

py::array_t<float> ray_table_of(const Camera& camera, bool distort, bool in_water) {
  const RayTable& rays = camera.rays(distort, in_water);
  return by_pixel(camera.lens(), rays.x, rays.y);
}

py::array_t<float> ray_offsets_of(const Camera& camera) {
  const RayTable& rays = camera.rays(true, true);
  return by_pixel(camera.lens(), rays.offset_x_m, rays.offset_y_m);
}

Lens lens_of(Lens lens, const std::vector<double>& d, const std::optional<FlatPort>& port) {
  require(d.size() == 4 || d.size() == 5 || d.size() == 8, "camera.distortion.size", d.size(), "must be 4, 5 or 8");
  lens.is_equidistant = d.size() == 4;
  if (lens.is_equidistant) {
    lens.k1 = d[0], lens.k2 = d[1], lens.k3 = d[2], lens.k4 = d[3];
  } else {
    lens.k1 = d[0], lens.k2 = d[1], lens.p1 = d[2], lens.p2 = d[3], lens.k3 = d[4];
    if (d.size() == 8) lens.k4 = d[5], lens.k5 = d[6], lens.k6 = d[7];
  }
  lens.port = port;
  return lens;
}

void bind_lens(py::module_& m) {
  py::class_<FlatPort>(m, "FlatPort", "A flat window between the lens, in air, and the water.")
      .def(py::init([](double distance_m, double thickness_m, double refractive_index) {
             return FlatPort{distance_m, thickness_m, refractive_index};
           }),
           py::arg("distance_m"), py::arg("thickness_m"), py::arg("refractive_index"));
  py::class_<Lens>(m, "Lens", "Distortion as in OpenCV and CameraInfo, in pixels; lens.h contains the equations.")
      .def(py::init([](int width, int height, double fx, double fy, double cx, double cy,
                       const std::vector<double>& distortion, const std::optional<FlatPort>& port) {
             return lens_of(Lens{width, height, fx, fy, cx, cy}, distortion, port);
           }),
           py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"),
           py::arg("distortion") = std::vector<double>(5), py::arg("port") = py::none(),
           "distortion: k1, k2, p1, p2, k3 (plumb_bob), these and k4, k5, k6 (rational_polynomial), or k1, k2, k3,\n"
           "k4 (equidistant)");
  py::class_<Camera, std::shared_ptr<Camera>>(m, "Camera",
                                              "A camera: lens and image sensor. Raises ValueError naming the field.")
      .def(py::init([](std::string name, const Lens& lens, double exposure, double full_well, double read_noise,
                       double vignetting, std::optional<double> wobble_rad, double shutter_s, double readout_s) {
             const GilReleased unlocked;  // building the ray tables takes a while
             return std::make_shared<Camera>(
                 std::move(name), lens,
                 ImageSensor{exposure, full_well, read_noise, vignetting, wobble_rad, shutter_s, readout_s});
           }),
           py::arg("name"), py::arg("lens"), py::arg("exposure") = ImageSensor{}.exposure,
           py::arg("full_well") = ImageSensor{}.full_well, py::arg("read_noise") = ImageSensor{}.read_noise,
           py::arg("vignetting") = ImageSensor{}.vignetting, py::arg("wobble_rad") = py::none(),
           py::arg("shutter_s") = 0.0, py::arg("readout_s") = 0.0)
      .def_property_readonly("name", &Camera::name)
      .def_property_readonly(
          "folded_pixels", [](const Camera& camera) { return camera.rays(true, false).folded; },
          "The number of pixels that no ray meets, because the distortion folds the image over.")
      .def("ray_table", &ray_table_of, py::arg("distort") = true, py::arg("in_water") = true,
           "Return X/Z and Y/Z of the ray through each pixel's centre, in the optical frame, (height, width, 2)\n"
           "float32.")
      .def("ray_offsets_m", &ray_offsets_of,
           "(height, width, 2) float32: X and Y of the points where these rays, extended, meet Z = 0 in water; 0\n"
           "without a flat port.");
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
  m.def(
      "mounted_poses",
      [](const py::object& positions_m, const py::object& orientations_xyzw, const py::object& mount_positions_m,
         const py::object& mount_orientations_xyzw) {
        const std::vector<Pose> carriers = as_poses(positions_m, orientations_xyzw, "carriers");
        const std::vector<Pose> mounts = as_poses(mount_positions_m, mount_orientations_xyzw, "mounts");
        require(mounts.size() == carriers.size(), "mounts.size", mounts.size(), "must equal the number of carriers");
        const auto n = static_cast<py::ssize_t>(carriers.size());
        DoubleArray positions({n, py::ssize_t{3}}), orientations({n, py::ssize_t{4}});
        for (std::size_t k = 0; k < carriers.size(); ++k) {
          const Pose pose = carriers[k] * mounts[k];
          Eigen::Vector3d::Map(positions.mutable_data(static_cast<py::ssize_t>(k))) = pose.position_m;
          Eigen::Vector4d::Map(orientations.mutable_data(static_cast<py::ssize_t>(k))) = pose.orientation.coeffs();
        }
        return std::tuple(positions, orientations);
      },
      py::arg("positions_m"), py::arg("orientations_xyzw"), py::arg("mount_positions_m"),
      py::arg("mount_orientations_xyzw"),
      "Return n poses as mounted_pose does: positions (n, 3) and orientations (n, 4) as x, y, z, w.");
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
