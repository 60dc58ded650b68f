#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <cmath>
#include <string>

#include "arrays.h"
#include "bind.h"
#include "convert.h"
#include "uwsim/sonar/depth_image.h"
#include "uwsim/sonar/forward_looking.h"
#include "uwsim/sonar/side_scan.h"
#include "uwsim/sonar/single_beam.h"

namespace uwsim::bindings {
namespace {

using Levels = py::array_t<float>;

Levels look(const ForwardLookingModel& model, const RayScene& scene, const Water& water, const py::object& position_m,
            const py::object& orientation_xyzw, std::uint64_t seed, const std::string& stream, std::uint64_t tick,
            int threads) {
  const Pose pose = as_pose(position_m, orientation_xyzw, "sonar");
  std::vector<float> levels;
  {
    const py::gil_scoped_release unlocked;
    levels = forward_look(model, scene, water, pose, RandomStream(seed, stream), tick, threads);
  }
  return move_out(std::move(levels), {model.acoustics.range_bins, model.beams});
}

py::typing::Tuple<Levels, Levels, Levels> scan_sides(const SideScanModel& model, const RayScene& scene,
                                                     const Water& water, const py::object& positions_m,
                                                     const py::object& orientations_xyzw, std::uint64_t seed,
                                                     const std::string& stream, std::uint64_t first_ping, int threads) {
  const auto positions = as_array<double>(positions_m, "positions_m", {-1, 3});
  const auto orientations = as_array<double>(orientations_xyzw, "orientations_xyzw", {positions.shape(0), 4});
  std::vector<Pose> poses;
  for (py::ssize_t k = 0; k < positions.shape(0); ++k) {
    poses.push_back(as_pose(positions[py::int_(k)], orientations[py::int_(k)], "sonar[" + std::to_string(k) + "]"));
  }
  SideScanLines lines;
  {
    const py::gil_scoped_release unlocked;
    lines = side_scan(model, scene, water, poses, RandomStream(seed, stream), first_ping, threads);
  }
  const std::vector<py::ssize_t> shape{positions.shape(0), model.acoustics.range_bins};
  return py::make_tuple(move_out(std::move(lines.port_db), shape), move_out(std::move(lines.starboard_db), shape),
                        move_out(std::move(lines.altitude_m)));
}

std::vector<double> as_angles(const py::object& angles_rad) {
  const auto array = as_array<double>(angles_rad, "angles_rad", {-1});
  std::vector<double> angles(array.data(), array.data() + array.size());
  for (const double angle : angles) require(std::isfinite(angle), "angles_rad", angle, "must be finite");
  return angles;
}

py::typing::Tuple<Levels, Levels> profile(const SingleBeamModel& model, const RayScene& scene, const Water& water,
                                          const py::object& position_m, const py::object& orientation_xyzw,
                                          const py::object& angles_rad, std::uint64_t seed, const std::string& stream,
                                          std::uint64_t first_ping, int threads) {
  const Pose pose = as_pose(position_m, orientation_xyzw, "sonar");
  const std::vector<double> angles = as_angles(angles_rad);
  SingleBeamProfiles profiles;
  {
    const py::gil_scoped_release unlocked;
    profiles = single_beam(model, scene, water, pose, angles, RandomStream(seed, stream), first_ping, threads);
  }
  return py::make_tuple(
      move_out(std::move(profiles.level_db), {static_cast<py::ssize_t>(angles.size()), model.acoustics.range_bins}),
      move_out(std::move(profiles.ranges_m)));
}

Levels see_depth(const DepthCamera& camera, const RayScene& scene, const py::object& position_m,
                 const py::object& orientation_xyzw, int threads) {
  const Pose pose = as_pose(position_m, orientation_xyzw, "camera");
  DepthImage image;
  {
    const py::gil_scoped_release unlocked;
    image = depth_image(camera, scene, pose, threads);
  }
  return move_out(std::move(image.depth_m), {camera.height, camera.width});
}

Levels ranges_of(const DepthCamera& camera, const py::object& depth_m, const py::object& angles_rad,
                 RowReduction reduction, bool interpolate) {
  camera.check();
  const auto depths = as_array<float>(depth_m, "depth_m", {camera.height, camera.width});
  const DepthImage image{camera, {depths.data(), depths.data() + depths.size()}};
  return move_out(depth_image_ranges(image, as_angles(angles_rad), reduction, interpolate));
}

void bind_models(py::module_& m) {
  py::class_<ImagingAcoustics>(m, "ImagingAcoustics", "What picture-making sonars share; see uwsim.imaging.Acoustics.")
      .def(py::init<>())
      .def_readwrite("frequency_hz", &ImagingAcoustics::frequency_hz)
      .def_readwrite("source_level_db", &ImagingAcoustics::source_level_db)
      .def_readwrite("noise_level_db", &ImagingAcoustics::noise_level_db)
      .def_readwrite("bottom_strength_db", &ImagingAcoustics::bottom_strength_db)
      .def_readwrite("solid_strength_db", &ImagingAcoustics::solid_strength_db)
      .def_readwrite("strengths_db", &ImagingAcoustics::strengths_db, "By label; NaN: bottom's or solids'.")
      .def_readwrite("range_max_m", &ImagingAcoustics::range_max_m)
      .def_readwrite("range_bins", &ImagingAcoustics::range_bins)
      .def_readwrite("time_varied_gain", &ImagingAcoustics::time_varied_gain)
      .def_readwrite("gain_db_decade", &ImagingAcoustics::gain_db_decade)
      .def_readwrite("looks", &ImagingAcoustics::looks)
      .def("absorption_db_m", &ImagingAcoustics::absorption_db_m, py::arg("water"), py::arg("head_z_m"),
           "Of the water at the head [dB/m].");
  py::class_<ForwardLookingModel>(m, "ForwardLookingModel", "See uwsim.imaging.ForwardLooking.")
      .def(py::init<>())
      .def_readwrite("acoustics", &ForwardLookingModel::acoustics)
      .def_readwrite("beams", &ForwardLookingModel::beams)
      .def_readwrite("field_of_view_rad", &ForwardLookingModel::field_of_view_rad)
      .def_readwrite("beam_width_rad", &ForwardLookingModel::beam_width_rad)
      .def_readwrite("vertical_width_rad", &ForwardLookingModel::vertical_width_rad)
      .def_readwrite("taper", &ForwardLookingModel::taper)
      .def_readwrite("columns_per_beam", &ForwardLookingModel::columns_per_beam)
      .def_readwrite("rays_per_column", &ForwardLookingModel::rays_per_column)
      .def("check", &ForwardLookingModel::check, "Raises ValueError.");
  py::class_<SideScanModel>(m, "SideScanModel", "See uwsim.imaging.SideScan.")
      .def(py::init<>())
      .def_readwrite("acoustics", &SideScanModel::acoustics)
      .def_readwrite("along_width_rad", &SideScanModel::along_width_rad)
      .def_readwrite("vertical_width_rad", &SideScanModel::vertical_width_rad)
      .def_readwrite("depression_rad", &SideScanModel::depression_rad)
      .def_readwrite("planes", &SideScanModel::planes)
      .def_readwrite("detection_db", &SideScanModel::detection_db)
      .def("check", &SideScanModel::check, "Raises ValueError.");
  py::class_<SingleBeamModel>(m, "SingleBeamModel", "See uwsim.imaging.SingleBeam.")
      .def(py::init<>())
      .def_readwrite("acoustics", &SingleBeamModel::acoustics)
      .def_readwrite("beam_width_rad", &SingleBeamModel::beam_width_rad)
      .def_readwrite("rays_across", &SingleBeamModel::rays_across)
      .def_readwrite("detection_db", &SingleBeamModel::detection_db)
      .def("check", &SingleBeamModel::check, "Raises ValueError.");
  py::class_<DepthCamera>(m, "DepthCamera", "See uwsim.depth_map.DepthMap.")
      .def(py::init<>())
      .def_readwrite("width", &DepthCamera::width)
      .def_readwrite("height", &DepthCamera::height)
      .def_readwrite("horizontal_fov_rad", &DepthCamera::horizontal_fov_rad)
      .def_readwrite("vertical_fov_rad", &DepthCamera::vertical_fov_rad)
      .def_readwrite("range_max_m", &DepthCamera::range_max_m)
      .def_readwrite("depth_bits", &DepthCamera::depth_bits)
      .def("check", &DepthCamera::check, "Raises ValueError.");
  py::enum_<RowReduction>(m, "RowReduction")
      .value("MIDDLE", RowReduction::kMiddle)
      .value("NEAREST", RowReduction::kNearest);
}

}  // namespace

void bind_imaging(py::module_& m) {
  bind_models(m);
  m.def("forward_look", &look, py::arg("model"), py::arg("scene"), py::arg("water"), py::arg("position_m"),
        py::arg("orientation_xyzw"), py::arg("seed"), py::arg("stream"), py::arg("tick"), py::arg("threads") = 1,
        "(bins, beams) float32, dB re 1 uPa; pose: world from sonar. Raises ValueError. Releases the GIL.");
  m.def("side_scan", &scan_sides, py::arg("model"), py::arg("scene"), py::arg("water"), py::arg("positions_m"),
        py::arg("orientations_xyzw"), py::arg("seed"), py::arg("stream"), py::arg("first_ping"), py::arg("threads") = 1,
        "Poses (n, 3) and (n, 4). (port_db (n, bins), starboard_db (n, bins), altitude_m (n,)), float32. Raises "
        "ValueError. Releases the GIL.");
  m.def("single_beam", &profile, py::arg("model"), py::arg("scene"), py::arg("water"), py::arg("position_m"),
        py::arg("orientation_xyzw"), py::arg("angles_rad"), py::arg("seed"), py::arg("stream"), py::arg("first_ping"),
        py::arg("threads") = 1,
        "angles_rad (n,). (level_db (n, bins), ranges_m (n,)), float32, inf = no echo. Raises ValueError. Releases the "
        "GIL.");
  m.def("depth_image", &see_depth, py::arg("camera"), py::arg("scene"), py::arg("position_m"),
        py::arg("orientation_xyzw"), py::arg("threads") = 1,
        "(height, width) float32 along the camera's x axis, inf = nothing. Raises ValueError. Releases the GIL.");
  m.def("depth_image_ranges", &ranges_of, py::arg("camera"), py::arg("depth_m"), py::arg("angles_rad"),
        py::arg("reduction"), py::arg("interpolate"),
        "depth_m (height, width), angles_rad (n,) -> (n,) float32, inf = no echo. Raises ValueError.");
}

}  // namespace uwsim::bindings
