#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "arrays.h"
#include "bind.h"
#include "convert.h"
#include "uwsim/camera/refraction.h"
#include "uwsim/camera/renderer.h"

namespace uwsim::bindings {
namespace {

struct PictureArrays {
  py::array rgb, radiance, depth_m, normals_world, labels, classes;
  double gain;
  PictureCost cost;
  py::bytes packets;
};

PictureArrays arrays_of(Picture&& picture, const PictureCost& cost) {
  const py::ssize_t height = picture.height, width = picture.width;
  PictureArrays out;
  const py::ssize_t coloured = picture.rgb.empty() ? 0 : height, radiant = picture.radiance.empty() ? 0 : height;
  out.rgb = read_only(move_out(std::move(picture.rgb), {coloured, width, 3}));
  out.radiance = read_only(move_out(std::move(picture.radiance), {radiant, width, 3}));
  out.depth_m = read_only(move_out(std::move(picture.depth_m), {height, width}));
  out.normals_world = read_only(move_out(std::move(picture.normals_world), {height, width, 3}));
  out.labels = read_only(move_out(std::move(picture.labels), {height, width}));
  out.classes = read_only(move_out(std::move(picture.classes), {height, width}));
  out.gain = picture.gain;
  out.cost = cost;
  return out;
}

Bands as_bands(const py::object& object, const char* name) { return as_vector3(object, name).array(); }

std::optional<Bands> colour_of(const py::object& colour) {
  if (colour.is_none()) return std::nullopt;
  return as_bands(colour, "material.colour");
}

Effects effects_of(const std::vector<std::string>& names) {
  Effects effects = Effects::none();
  for (const std::string& name : names) {
    const auto found = std::find(kEffectNames.begin(), kEffectNames.end(), name);
    std::string known;
    for (const std::string_view effect : kEffectNames) known += (known.empty() ? "" : ", ") + std::string(effect);
    require(found != kEffectNames.end(), "effects", name, "must be one of " + known);
    effects.set(static_cast<Effect>(found - kEffectNames.begin()), true);
  }
  return effects;
}

SurfaceClass class_of(const std::string& name) {
  const auto found = std::find(kSurfaceClassNames.begin(), kSurfaceClassNames.end(), name);
  require(found != kSurfaceClassNames.end(), "class", name, "must be a name of surface_class_names()");
  return static_cast<SurfaceClass>(found - kSurfaceClassNames.begin());
}

std::vector<Pose> poses_of(const py::object& positions_m, const py::object& orientations_xyzw) {
  const auto positions = as_points(positions_m, "bodies.positions_m");
  const auto turns = as_array<double>(orientations_xyzw, "bodies.orientations_xyzw", {-1, 4});
  require(turns.shape(0) == static_cast<py::ssize_t>(positions.size()), "bodies.orientations_xyzw", turns.shape(0),
          "must be one for each position");
  std::vector<Pose> poses;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const auto row = static_cast<py::ssize_t>(k);
    const Eigen::Quaterniond turn(turns.at(row, 3), turns.at(row, 0), turns.at(row, 1), turns.at(row, 2));
    require(turn.norm() > 1e-6, "bodies.orientations_xyzw", turn.coeffs().transpose(), "must not be zero");
    poses.push_back({positions[k], turn.normalized()});
  }
  return poses;
}

PictureArrays take(const CameraScene& scene, const Camera& camera, const Optics& optics, const py::object& position_m,
                   const py::object& orientation_xyzw, double time_s, std::uint64_t tick,
                   const std::vector<std::string>& effects, std::vector<Lamp> lamps, const py::object& body_positions_m,
                   const py::object& body_orientations_xyzw, std::optional<std::size_t> hidden_body, bool geometry_only,
                   bool keep_radiance, bool measure, bool record, int threads) {
  Exposure exposure;
  exposure.world_from_camera = as_pose(position_m, orientation_xyzw, "camera");
  require(std::isfinite(time_s), "time_s", time_s, "must be finite");
  exposure.time_s = time_s;
  exposure.tick = tick;
  exposure.effects = effects_of(effects);
  exposure.lamps = std::move(lamps);
  if (!body_positions_m.is_none()) exposure.world_from_bodies = poses_of(body_positions_m, body_orientations_xyzw);
  exposure.hidden = hidden_body;
  exposure.geometry_only = geometry_only;
  exposure.keep_radiance = keep_radiance;
  exposure.measure = measure;
  require(threads >= 1 && threads <= 1024, "threads", threads, "must be in [1, 1024]");
  exposure.threads = threads;
  RayRecord packets;
  if (record) exposure.record = &packets;
  PictureCost cost;
  Picture picture = [&] {
    const py::gil_scoped_release unlocked;
    return render(scene, camera, optics, exposure, &cost);
  }();
  PictureArrays out = arrays_of(std::move(picture), cost);
  static_assert(sizeof(RayRecord::Packet) == 580);
  const auto* bytes = reinterpret_cast<const char*>(packets.packets.data());
  out.packets = py::bytes(bytes, packets.packets.size() * sizeof(RayRecord::Packet));
  return out;
}

void bind_optics(py::module_& m) {
  m.def("jerlov_types", &jerlov_types, "Names of the Jerlov water types.");
  m.def("material_names", &material_names);
  m.def("effect_names", [] { return std::vector<std::string>(kEffectNames.begin(), kEffectNames.end()); });
  m.def("surface_class_names",
        [] { return std::vector<std::string>(kSurfaceClassNames.begin(), kSurfaceClassNames.end()); });
  m.def(
      "refracted",
      [](const Eigen::Vector3d& direction, const Eigen::Vector3d& normal, double n_from, double n_to) {
        return refracted(direction.normalized(), normal.normalized(), n_from, n_to);
      },
      py::arg("direction"), py::arg("normal"), py::arg("n_from"), py::arg("n_to"),
      "Snell's law; normal points to where the ray comes from. None where it is totally reflected.");

  py::class_<WaterOptics>(m, "WaterOptics", "A water's coefficients [1/m], (3,) in the order red, green, blue.")
      .def(py::init([](const py::object& kd, const py::object& a, const py::object& b, double index) {
             WaterOptics water{as_bands(kd, "diffuse_attenuation"), as_bands(a, "absorption"),
                               as_bands(b, "scattering"), index};
             water.check();
             return water;
           }),
           py::arg("diffuse_attenuation"), py::arg("absorption"), py::arg("scattering"),
           py::arg("refractive_index") = 1.333)
      .def_static("jerlov", &jerlov_water, py::arg("type"),
                  "Of a Jerlov type (sources in water_optics.h). Raises ValueError for an unknown one.")
      .def_property_readonly("diffuse_attenuation",
                             [](const WaterOptics& w) { return w.diffuse_attenuation.matrix().eval(); })
      .def_property_readonly("absorption", [](const WaterOptics& w) { return w.absorption.matrix().eval(); })
      .def_property_readonly("scattering", [](const WaterOptics& w) { return w.scattering.matrix().eval(); })
      .def_property_readonly("beam_attenuation",
                             [](const WaterOptics& w) { return w.beam_attenuation().matrix().eval(); })
      .def_readonly("refractive_index", &WaterOptics::refractive_index);

  py::class_<Optics>(m, "Optics", "What light is like: the water, the sun, the wind on the surface, what drifts.")
      .def(py::init([](const WaterOptics& water, double elevation_rad, double azimuth_rad, double wind_m_s,
                       double wind_towards_rad, double particles_per_m3) {
             const Optics optics{water, {elevation_rad, azimuth_rad}, wind_m_s, wind_towards_rad, particles_per_m3};
             optics.check();
             return optics;
           }),
           py::arg("water"), py::arg("sun_elevation_rad"), py::arg("sun_azimuth_rad"), py::arg("wind_m_s"),
           py::arg("wind_towards_rad"), py::arg("particles_per_m3"))
      .def_readonly("water", &Optics::water)
      .def_property_readonly("to_sun_world", [](const Optics& o) { return daylight(o.sun).to_sun_world; })
      .def_property_readonly(
          "to_sun_below_world",
          [](const Optics& o) { return daylight_below(daylight(o.sun), o.water.refractive_index).to_sun_world; })
      .def(
          "level_irradiance_below",
          [](const Optics& o) {
            const DaylightBelow below = daylight_below(daylight(o.sun), o.water.refractive_index);
            return (below.beam_level + below.sky_level).matrix().eval();
          },
          "(3,) of the daylight just below a flat surface; 1 is the sun's outside the air.");
}

void bind_camera_parts(py::module_& m) {
  py::class_<Lens>(m, "Lens", "As OpenCV's and CameraInfo's plumb_bob; pixels; see lens.h for the equations.")
      .def(py::init([](int width, int height, double fx, double fy, double cx, double cy,
                       const std::array<double, 5>& distortion) {
             const auto& [k1, k2, p1, p2, k3] = distortion;
             return Lens{width, height, fx, fy, cx, cy, k1, k2, p1, p2, k3};
           }),
           py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"),
           py::arg("distortion") = std::array<double, 5>{}, "distortion: k1, k2, p1, p2, k3.");
  py::class_<Camera, std::shared_ptr<Camera>>(m, "Camera", "Lens and sensor. Raises ValueError that names the figure.")
      .def(py::init([](std::string name, const Lens& lens, double exposure, double full_well, double read_noise,
                       double vignetting, double wobble_rad) {
             const py::gil_scoped_release unlocked;  // tables of rays take a while
             return std::make_shared<Camera>(std::move(name), lens,
                                             ImageSensor{exposure, full_well, read_noise, vignetting, wobble_rad});
           }),
           py::arg("name"), py::arg("lens"), py::arg("exposure") = ImageSensor{}.exposure,
           py::arg("full_well") = ImageSensor{}.full_well, py::arg("read_noise") = ImageSensor{}.read_noise,
           py::arg("vignetting") = ImageSensor{}.vignetting, py::arg("wobble_rad") = ImageSensor{}.wobble_rad)
      .def_property_readonly("name", &Camera::name);
  m.def(
      "mounted",
      [](const py::object& position_m, const py::object& orientation_xyzw, const py::object& mount_position_m,
         const py::object& mount_orientation_xyzw) {
        const Pose pose = as_pose(position_m, orientation_xyzw, "carrier") *
                          as_pose(mount_position_m, mount_orientation_xyzw, "mount");
        return std::tuple(pose.position_m, Eigen::Vector4d(pose.orientation.coeffs()), pose.matrix());
      },
      py::arg("position_m"), py::arg("orientation_xyzw"), py::arg("mount_position_m"),
      py::arg("mount_orientation_xyzw"),
      "Pose of what is mounted on a carrier: position (3,), orientation (4,) as x, y, z, w, and both as (4, 4).");
  py::class_<Lamp>(m, "LampLight", "A spot lamp that shines along its x; irradiance 1 is taken as 1e5 lx.")
      .def(py::init([](const py::object& position_m, const py::object& orientation_xyzw, double flux_lm,
                       double half_angle_rad, double soft_share, const py::object& colour) {
             Lamp lamp{as_pose(position_m, orientation_xyzw, "lamp"), flux_lm, half_angle_rad, soft_share,
                       as_bands(colour, "lamp.colour")};
             lamp.check();
             return lamp;
           }),
           py::arg("position_m"), py::arg("orientation_xyzw"), py::arg("flux_lm"), py::arg("half_angle_rad"),
           py::arg("soft_share"), py::arg("colour"));
  py::class_<PictureArrays>(m, "Picture", "Read-only arrays of one pass, rows from the top; see picture.h.")
      .def_readonly("rgb", &PictureArrays::rgb, "(H, W, 3) uint8, sRGB; (0, W, 3) where geometry alone was asked for")
      .def_readonly("radiance", &PictureArrays::radiance, "(H, W, 3) float32 before exposure, where asked for")
      .def_readonly("depth_m", &PictureArrays::depth_m, "(H, W) float32 along the optical axis, inf = nothing")
      .def_readonly("normals_world", &PictureArrays::normals_world, "(H, W, 3) float32, 0 = nothing")
      .def_readonly("labels", &PictureArrays::labels, "(H, W) uint16, see CameraScene.label_names")
      .def_readonly("classes", &PictureArrays::classes, "(H, W) uint8, see surface_class_names()")
      .def_readonly("gain", &PictureArrays::gain, "exposure that made rgb of radiance")
      .def_property_readonly(
          "rays",
          [](const PictureArrays& p) -> py::typing::Dict<py::str, py::int_> {
            py::dict rays;
            rays["primary"] = p.cost.primary_rays;
            rays["onward"] = p.cost.onward_rays;
            rays["sun"] = p.cost.sun_rays;
            rays["lamp"] = p.cost.lamp_rays;
            rays["shaft"] = p.cost.shaft_rays;
            return rays;
          },
          "How many were cast, by kind.")
      .def_readonly("packets", &PictureArrays::packets,
                    "What was cast, as tools/bench/native/embree_bare_rays reads it")
      .def_property_readonly(
          "stage_s",
          [](const PictureArrays& p) -> py::typing::Dict<py::str, py::float_> {
            py::dict stages;
            for (std::size_t k = 0; k < kStageNames.size(); ++k) stages[kStageNames[k]] = p.cost.seconds[k];
            return stages;
          },
          "Seconds of all threads together by stage, where measured.");
}

}  // namespace

void bind_camera(py::module_& m) {
  bind_optics(m);
  bind_camera_parts(m);
  py::class_<CameraScene, std::shared_ptr<CameraScene>>(
      m, "CameraScene", "The world that feeds physics and rays, with looks; and the vehicles. A snapshot of the world.")
      .def(py::init([](const World& world, std::shared_ptr<RayScene> rays, std::uint64_t seed) {
             return std::make_shared<CameraScene>(world, std::move(rays), seed);
           }),
           py::arg("world"), py::arg("rays").none(false), py::arg("seed"))
      .def(
          "set_look",
          [](CameraScene& scene, Label label, const std::string& material_name, const std::string& surface_class,
             const py::object& colour, const py::object& image, const py::object& corners) {
            SurfaceLook look{material(material_name, colour_of(colour)), class_of(surface_class), nullptr};
            if (!image.is_none()) {
              const auto pixels = py::array_t<std::uint8_t, py::array::c_style>::ensure(image);
              require(pixels && pixels.ndim() == 3 && pixels.shape(2) == 3, "texture.image", "another shape",
                      "must be (H, W, 3) uint8");
              const auto places = as_array<float>(corners, "texture.corners", {-1, 3, 2});
              auto texture = std::make_shared<Texture>();
              texture->width = static_cast<int>(pixels.shape(1));
              texture->height = static_cast<int>(pixels.shape(0));
              texture->rgb.assign(pixels.data(), pixels.data() + pixels.size());
              texture->corners.assign(places.data(), places.data() + places.size());
              look.texture = std::move(texture);
            }
            scene.set_look(label, look);
          },
          py::arg("label"), py::arg("material"), py::arg("surface_class"), py::arg("colour") = py::none(),
          py::arg("texture_image") = py::none(), py::arg("texture_corners") = py::none(),
          "colour: (3,) albedo. texture_image: (H, W, 3) uint8 sRGB; texture_corners: (triangles, 3, 2), from the "
          "lower "
          "left. Raises ValueError.")
      .def(
          "set_ground",
          [](CameraScene& scene, const std::string& bed, const std::string& steep, const std::string& land) {
            scene.set_ground(material(bed), material(steep), material(land));
          },
          py::arg("bed"), py::arg("steep"), py::arg("land"))
      .def(
          "add_body",
          [](CameraScene& scene, std::string name, const py::object& vertices_body_m, const py::object& triangles,
             const std::string& material_name, const py::object& colour) {
            return scene.add_body(std::move(name),
                                  {as_points(vertices_body_m, "vertices_body_m"), as_triangles(triangles, "triangles")},
                                  {material(material_name, colour_of(colour)), SurfaceClass::kVehicle, nullptr});
          },
          py::arg("name"), py::arg("vertices_body_m"), py::arg("triangles"), py::arg("material"),
          py::arg("colour") = py::none(), "Returns the body's index.")
      .def_property_readonly("label_names", &CameraScene::label_names, "World.label_names, then the bodies'.")
      .def("render", &take, py::arg("camera"), py::arg("optics"), py::arg("position_m"), py::arg("orientation_xyzw"),
           py::arg("time_s"), py::arg("tick"), py::arg("effects"), py::arg("lamps") = std::vector<Lamp>{},
           py::arg("body_positions_m") = py::none(), py::arg("body_orientations_xyzw") = py::none(),
           py::arg("hidden_body") = py::none(), py::arg("geometry_only") = false, py::arg("keep_radiance") = false,
           py::arg("measure") = false, py::arg("record") = false, py::arg("threads") = 1,
           "One picture; the camera's frame is x ahead, y left, z up. effects: names of those that are on. "
           "body_positions_m: (n, 3), body_orientations_xyzw: (n, 4), of all bodies or none. Same bytes whatever the "
           "number of threads. Releases the GIL. Raises ValueError.");
}

}  // namespace uwsim::bindings
