#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bindings/camera/bands.h"
#include "bindings/camera/binders.h"
#include "bindings/camera/picture_arrays.h"
#include "bindings/core/convert.h"
#include "uwsim/camera/prepared_view.h"
#include "uwsim/camera/renderer.h"
#include "uwsim/camera/ripples.h"
#include "uwsim/core/names.h"

namespace uwsim::bindings {
namespace {

camera::Material as_material(const std::string& name, const py::object& colour) {
  return colour.is_none() ? material(name) : material(name, as_bands(colour, "material.colour"));
}

Effects as_effects(const std::vector<std::string>& names) {
  Effects effects = Effects::none();
  for (const std::string& name : names) effects.set(static_cast<Effect>(index_of("effects", name, kEffectNames)), true);
  return effects;
}

std::optional<TextureImage> as_texture(const py::object& image, const py::object& corners, const py::object& normals) {
  if (image.is_none()) return std::nullopt;
  const auto pixels = py::array_t<std::uint8_t, py::array::c_style>::ensure(image);
  require(pixels && pixels.ndim() == 3, "texture.image", "another shape", "must be (H, W, 3) or (H, W, 8) uint8");
  const auto places = as_array<float>(corners, "texture.corners", {-1, 3, 2});
  TextureImage texture;
  texture.width = static_cast<int>(pixels.shape(1));
  texture.height = static_cast<int>(pixels.shape(0));
  texture.bands = static_cast<int>(pixels.shape(2));
  texture.pixels.assign(pixels.data(), pixels.data() + pixels.size());
  texture.corners.assign(places.data(), places.data() + places.size());
  if (normals.is_none()) return texture;
  const auto units = as_array<float>(normals, "texture.normals", {-1, 3, 3});
  texture.normals.assign(units.data(), units.data() + units.size());
  return texture;
}

py::array_t<float> ripple_slopes(const CameraScene& scene, const Optics& optics, double time_s, int threads) {
  require(std::isfinite(time_s), "time_s", time_s, "must be finite");
  require(threads >= 1 && threads <= 1024, "threads", threads, "must be in [1, 1024]");
  const auto found = without_gil([&] {
    return scene.ripples(optics.wind_m_s, optics.wind_towards_rad, optics.fetch_m, time_s, focused_sun(optics),
                         camera::kCausticLevels - 2, threads);
  });
  py::array_t<float> slopes({Ripples::kCells, Ripples::kCells, 2});
  std::copy(found->slopes.begin(), found->slopes.end(), slopes.mutable_data());
  return slopes;
}

PictureArrays render_picture(const CameraScene& scene, const Camera& camera, const Optics& optics,
                             const py::object& position_m, const py::object& orientation_xyzw, double time_s,
                             std::uint64_t tick, const std::vector<std::string>& effects, std::vector<SpotLamp> lamps,
                             const py::object& vehicle_positions_m, const py::object& vehicle_orientations_xyzw,
                             std::optional<std::size_t> hidden_vehicle, bool geometry_only, bool keep_radiance,
                             bool record, const Vector6d& velocity_camera, int threads, bool colours_only) {
  PictureRequest request;
  request.world_from_camera = as_pose(position_m, orientation_xyzw, "camera");
  require(std::isfinite(time_s), "time_s", time_s, "must be finite");
  require(velocity_camera.allFinite(), "velocity_camera", velocity_camera.transpose(), "must be finite");
  request.velocity_camera = velocity_camera;
  request.time_s = time_s;
  request.tick = tick;
  request.effects = as_effects(effects);
  request.lamps = std::move(lamps);
  if (!vehicle_positions_m.is_none()) {
    request.world_from_vehicles = as_poses(vehicle_positions_m, vehicle_orientations_xyzw, "vehicles");
  }
  request.hidden_vehicle = hidden_vehicle;
  request.geometry_only = geometry_only;
  request.colours_only = colours_only;
  request.keep_radiance = keep_radiance;
  require(threads >= 1 && threads <= 1024, "threads", threads, "must be in [1, 1024]");
  request.threads = threads;
  RayRecord packets;
  if (record) request.record = &packets;
  Picture picture = without_gil([&] { return render(scene, camera, optics, request); });
  return {std::move(picture), packets};
}

/// A lamp that is mounted on a vehicle, given by its index; the lamp's pose is that on the vehicle.
using MountedLamp = std::pair<std::size_t, SpotLamp>;

/// Pictures in colour of several scenes, each with its own camera.
py::array_t<std::uint8_t> render_many(
    const std::vector<std::optional<std::shared_ptr<CameraScene>>>& scenes,
    const std::vector<std::shared_ptr<Camera>>& cameras, const std::vector<Optics>& optics,
    const py::object& positions_m, const py::object& orientations_xyzw, const std::vector<std::uint64_t>& times_ns,
    const std::vector<std::string>& effects, const std::vector<std::vector<MountedLamp>>& lamps,
    const py::object& vehicle_positions_m, const py::object& vehicle_orientations_xyzw,
    std::optional<std::size_t> hidden_vehicle, const py::object& velocities_camera, int threads) {
  const std::size_t count = scenes.size();
  const auto n = static_cast<py::ssize_t>(count);
  for (const auto& [name, size] : {std::pair{"cameras", cameras.size()},
                                   {"optics", optics.size()},
                                   {"times_ns", times_ns.size()},
                                   {"lamps", lamps.size()}}) {
    require(size == count, std::string(name) + ".size", size, "must equal the number of scenes");
  }
  const auto carried = as_array<double>(vehicle_positions_m, "vehicle_positions_m", {n, -1, 3});
  const py::ssize_t vehicles = carried.shape(1);
  const auto turned = as_array<double>(vehicle_orientations_xyzw, "vehicle_orientations_xyzw", {n, vehicles, 4});
  const auto velocities = as_array<double>(velocities_camera, "velocities_camera", {n, 6});
  const std::vector<Pose> poses = as_poses(positions_m, orientations_xyzw, "cameras");
  require(poses.size() == count, "positions_m.size", poses.size(), "must equal the number of scenes");
  require(threads >= 1 && threads <= 1024, "threads", threads, "must be in [1, 1024]");
  const Effects on = as_effects(effects);
  std::vector<PictureJob> jobs(count);
  for (std::size_t k = 0; k < count; ++k) {
    require(cameras[k] != nullptr, "cameras[" + std::to_string(k) + "]", "none", "must be a camera");
    jobs[k] = {scenes[k] ? scenes[k]->get() : nullptr, cameras[k].get(), &optics[k], {}};
    const auto row = static_cast<py::ssize_t>(k);
    PictureRequest& request = jobs[k].request;
    request.world_from_camera = poses[k];
    request.velocity_camera = Vector6d::Map(velocities.data(row));
    require(request.velocity_camera.allFinite(), "velocities_camera", request.velocity_camera.transpose(),
            "must be finite");
    request.time_s = static_cast<double>(times_ns[k]) * 1e-9;
    request.tick = times_ns[k];
    request.effects = on;
    for (py::ssize_t v = 0; v < vehicles; ++v) {
      const double* const q = turned.data(row, v);
      request.world_from_vehicles.push_back(
          checked_pose(Eigen::Vector3d::Map(carried.data(row, v)), {q[3], q[0], q[1], q[2]}, "vehicles"));
    }
    for (const auto& [vehicle, lamp] : lamps[k]) {
      SpotLamp placed = lamp;
      const Pose pose = request.world_from_vehicles.at(vehicle) * lamp.world_from_lamp;
      placed.world_from_lamp = checked_pose(pose.position_m, pose.orientation, "lamp");
      request.lamps.push_back(placed);
    }
    request.hidden_vehicle = hidden_vehicle;
  }
  const py::ssize_t height = count == 0 ? 0 : cameras[0]->lens().height;
  const py::ssize_t width = count == 0 ? 0 : cameras[0]->lens().width;
  py::array_t<std::uint8_t> pictures({n, height, width, py::ssize_t{3}});
  const std::span<std::uint8_t> out(pictures.mutable_data(), static_cast<std::size_t>(pictures.size()));
  without_gil([&] {
    render_colours(jobs, threads, out);
    return 0;
  });
  return pictures;
}

void bind_names(py::module_& m) {
  m.def("material_names", &material_names, "Return the names of the materials.");
  m.def(
      "effect_names", [] { return std::vector<std::string>(kEffectNames.begin(), kEffectNames.end()); },
      "Return the names of the effects.");
  m.def(
      "surface_class_names",
      [] { return std::vector<std::string>(kSurfaceClassNames.begin(), kSurfaceClassNames.end()); },
      "Return the names of the surface classes, indexed by the numbers in Picture.classes.");
}

}  // namespace

void bind_camera_scene(py::module_& m) {
  bind_names(m);
  py::class_<CameraScene, std::shared_ptr<CameraScene>>(
      m, "CameraScene", "A snapshot of the world with its materials and textures, plus vehicles.")
      .def(py::init([](const World& world, std::shared_ptr<RayScene> rays, std::uint64_t seed) {
             return std::make_shared<CameraScene>(world, std::move(rays), seed);
           }),
           py::arg("world"), py::arg("rays").none(false), py::arg("seed"))
      .def(
          "with_water",
          [](const CameraScene& scene, const Water& water, std::uint64_t seed) {
            return std::make_shared<CameraScene>(scene, water, seed);
          },
          py::arg("water"), py::arg("seed"),
          "Return a scene with the same surfaces in different water, with a different seed.")
      .def(
          "set_appearance",
          [](CameraScene& scene, Label label, const std::string& material_name, const std::string& surface_class,
             const py::object& colour, const py::object& image, const py::object& corners, const py::object& normals) {
            const auto kind = static_cast<SurfaceClass>(index_of("class", surface_class, kSurfaceClassNames));
            scene.set_appearance(label,
                                 {as_material(material_name, colour), kind, as_texture(image, corners, normals)});
          },
          py::arg("label"), py::arg("material"), py::arg("surface_class"), py::arg("colour") = py::none(),
          py::arg("texture_image") = py::none(), py::arg("texture_corners") = py::none(),
          py::arg("texture_normals") = py::none(),
          "Set a solid's appearance. colour: (3,) albedo. texture_image: (H, W, 3) uint8 sRGB, or (H, W, 8) with "
          "normal,\n"
          "roughness and metalness of glTF 2.0; texture_corners: (triangles, 3, 2), from the lower left;\n"
          "texture_normals: (triangles, 3, 3), unit vectors along the first edge, across it and along the triangle's\n"
          "normal. Raises ValueError.")
      .def(
          "set_cover_appearance",
          [](CameraScene& scene, Label label, const std::string& material_name, const std::string& surface_class,
             const py::object& colour, const py::object& image, const py::object& corners, const py::object& normals) {
            scene.set_cover_appearance(label, as_material(material_name, colour), surface_class,
                                       as_texture(image, corners, normals));
          },
          py::arg("label"), py::arg("material"), py::arg("surface_class"), py::arg("colour") = py::none(),
          py::arg("texture_image") = py::none(), py::arg("texture_corners") = py::none(),
          py::arg("texture_normals") = py::none(),
          "Set the appearance of a layer of cover, as set_appearance; a new surface_class is added to class_names.\n"
          "Raises ValueError.")
      .def(
          "set_ground",
          [](CameraScene& scene, const std::string& bed, const std::string& steep, const std::string& land) {
            scene.set_ground(material(bed), material(steep), material(land));
          },
          py::arg("bed"), py::arg("steep"), py::arg("land"),
          "Set the terrain's materials: under water, where it is steep, and above water. Raises ValueError.")
      .def("set_ripples", &CameraScene::set_ripples, py::arg("across_rad"),
           "Set the direction across ripples of sand, from x to y.")
      .def("show_detail", &CameraScene::show_detail,
           "Show relief and patterns of fixed surfaces down to the footprint of a pixel.")
      .def(
          "add_vehicle",
          [](CameraScene& scene, std::string name, const py::object& vertices_body_m, const py::object& triangles,
             const std::string& material_name, const py::object& colour, const py::object& image,
             const py::object& corners, const py::object& normals, const std::string& surface_class) {
            const auto kind = static_cast<SurfaceClass>(index_of("class", surface_class, kSurfaceClassNames));
            return scene.add_vehicle(
                std::move(name), {as_points(vertices_body_m, "vertices_body_m"), as_triangles(triangles, "triangles")},
                {as_material(material_name, colour), kind, as_texture(image, corners, normals)});
          },
          py::arg("name"), py::arg("vertices_body_m"), py::arg("triangles"), py::arg("material"),
          py::arg("colour") = py::none(), py::arg("texture_image") = py::none(),
          py::arg("texture_corners") = py::none(), py::arg("texture_normals") = py::none(),
          py::arg("surface_class") = "vehicle",
          "Add a hull, vertices (n, 3) and triangles (m, 3), and return the vehicle's index. texture: as for\n"
          "set_appearance. Raises ValueError.")
      .def(
          "add_school",
          [](CameraScene& scene, const std::string& material_name, const std::string& surface_class,
             const py::object& colour) { scene.add_school(as_material(material_name, colour), surface_class); },
          py::arg("material"), py::arg("surface_class"), py::arg("colour") = py::none(),
          "Add the appearance of the world's next school of fish, after all vehicles. Raises ValueError.")
      .def_property_readonly(
          "classes_by_label",
          [](const CameraScene& scene) {
            const std::vector<std::uint8_t> classes = scene.classes_by_label();
            return std::vector<int>(classes.begin(), classes.end());
          },
          "The class of each label, as an index into class_names.")
      .def_property_readonly("class_names", &CameraScene::class_names,
                             "surface_class_names(), followed by the classes of cover.")
      .def_property_readonly("label_names", &CameraScene::label_names, "World.label_names, followed by the vehicles.")
      .def("ripple_slopes", &ripple_slopes, py::arg("optics"), py::arg("time_s"), py::arg("threads") = 1,
           "Return the slopes (n, n, 2) along x and y of the ripples of the wind at a time, by row along y and column\n"
           "along x, on a square of 6.4 m that repeats from the world's origin.")
      .def("render", &render_picture, py::arg("camera"), py::arg("optics"), py::arg("position_m"),
           py::arg("orientation_xyzw"), py::arg("time_s"), py::arg("tick"), py::arg("effects"),
           py::arg("lamps") = std::vector<SpotLamp>{}, py::arg("vehicle_positions_m") = py::none(),
           py::arg("vehicle_orientations_xyzw") = py::none(), py::arg("hidden_vehicle") = py::none(),
           py::arg("geometry_only") = false, py::arg("keep_radiance") = false, py::arg("record") = false,
           py::arg("velocity_camera") = Vector6d(Vector6d::Zero()), py::arg("threads") = 1,
           py::arg("colours_only") = false,
           "Render one picture; the camera's frame is x ahead, y left, z up. effects: names of the effects that are\n"
           "on. vehicle_positions_m (n, 3), vehicle_orientations_xyzw (n, 4): for all vehicles or none.\n"
           "velocity_camera: (6,), in the camera's frame [m/s, rad/s]. The bytes do not depend on the number of\n"
           "threads. Releases the GIL. Raises ValueError.");
  m.def("render_many", &render_many, py::arg("scenes"), py::arg("cameras"), py::arg("optics"), py::arg("positions_m"),
        py::arg("orientations_xyzw"), py::arg("times_ns"), py::arg("effects"), py::arg("lamps"),
        py::arg("vehicle_positions_m"), py::arg("vehicle_orientations_xyzw"), py::arg("hidden_vehicle"),
        py::arg("velocities_camera"), py::arg("threads"),
        "Render one picture of each of n scenes, (n, H, W, 3) uint8, like CameraScene.render, several at a time.\n"
        "scenes: None for a black picture. cameras: all with pictures of the same size. positions_m (n, 3),\n"
        "orientations_xyzw (n, 4) and velocities_camera (n, 6) of the cameras. lamps: for each scene, the lamps\n"
        "that are on, as (vehicle, lamp with its pose on that vehicle). vehicle_positions_m (n, v, 3),\n"
        "vehicle_orientations_xyzw (n, v, 4): of all vehicles. Releases the GIL. Raises ValueError.");
}

}  // namespace uwsim::bindings
