#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/world/binders.h"
#include "uwsim/core/names.h"
#include "uwsim/world/world.h"

namespace uwsim::bindings {
namespace {

void set_terrain(World& world, const py::object& heights_m, double spacing_m, const py::object& origin_m) {
  const auto heights = as_array<float>(heights_m, "heights_m", {-1, -1});
  const auto origin = as_array<double>(origin_m, "origin_m", {2});
  world.set_terrain(Heightfield({heights.data(), heights.data() + heights.size()},
                                static_cast<std::size_t>(heights.shape(1)), static_cast<std::size_t>(heights.shape(0)),
                                spacing_m, {origin.at(0), origin.at(1)}));
}

py::array_t<double> height_at(const World& world, const py::object& xy_m) {
  const auto points = as_array<double>(xy_m, "xy_m", {-1, 2});
  std::vector<double> heights(static_cast<std::size_t>(points.shape(0)), std::numeric_limits<double>::quiet_NaN());
  if (world.terrain()) {
    for (py::ssize_t k = 0; k < points.shape(0); ++k) {
      heights[static_cast<std::size_t>(k)] = world.terrain()->height_at(points.at(k, 0), points.at(k, 1));
    }
  }
  return move_out(std::move(heights));
}

CoverRange as_range(const std::pair<double, double>& range) { return {range.first, range.second}; }

constexpr std::array<std::string_view, 3> kStanceNames = {"upright", "on_bed", "tumbled"};

Label add_cover(World& world, std::string name, const std::vector<std::pair<py::object, py::object>>& meshes,
                const std::string& stance, double sunk, double density_per_m2, const Pair& size_m, double size_exponent,
                const Pair& depth_m, const Pair& slope_rad, const Pair& from_solids_m, double patch_m,
                double patch_share, std::uint64_t seed, bool solid, double drag_coefficient, double leans_at_m_s) {
  CoverLayer layer;
  layer.name = std::move(name);
  for (const auto& [vertices, triangles] : meshes) {
    layer.meshes.push_back({as_points(vertices, "vertices_m"), as_triangles(triangles, "triangles")});
  }
  layer.stance = static_cast<CoverStance>(index_of("stance", stance, kStanceNames));
  layer.sunk = sunk;
  layer.density_per_m2 = density_per_m2;
  layer.size_m = as_range(size_m);
  layer.size_exponent = size_exponent;
  layer.depth_m = as_range(depth_m);
  layer.slope_rad = as_range(slope_rad);
  layer.from_solids_m = as_range(from_solids_m);
  layer.patch_m = patch_m;
  layer.patch_share = patch_share;
  layer.seed = seed;
  layer.solid = solid;
  layer.drag_coefficient = drag_coefficient;
  layer.leans_at_m_s = leans_at_m_s;
  return world.add_cover(std::move(layer));
}

std::vector<std::vector<TriangleMesh>> as_shapes(
    const std::vector<std::vector<std::pair<py::object, py::object>>>& shapes) {
  std::vector<std::vector<TriangleMesh>> all;
  for (const auto& phases : shapes) {
    std::vector<TriangleMesh>& meshes = all.emplace_back();
    for (const auto& [vertices, triangles] : phases)
      meshes.push_back({as_points(vertices, "vertices_m"), as_triangles(triangles, "triangles")});
  }
  return all;
}

void add_school(World& world, std::string name, std::size_t count,
                const std::vector<std::vector<std::pair<py::object, py::object>>>& shapes,
                const Eigen::Vector3d& position_m, double round_m, double speed_m_s, const Eigen::Vector3d& spread_m,
                double stroke_hz, double clear_m, std::uint64_t seed) {
  SchoolSpec spec{.name = std::move(name),
                  .count = count,
                  .shapes_m = {},
                  .home_world_m = position_m,
                  .round_m = round_m,
                  .speed_m_s = speed_m_s,
                  .spread_m = spread_m,
                  .stroke_hz = stroke_hz,
                  .clear_m = clear_m,
                  .seed = seed};
  spec.shapes_m = as_shapes(shapes);
  world.add_school(std::move(spec));
}

void add_plume(World& world, std::string name, std::size_t count,
               const std::vector<std::vector<std::pair<py::object, py::object>>>& shapes,
               const Eigen::Vector3d& source_m, double top_z_m, const Eigen::Vector3d& drift_m_s, std::uint64_t seed) {
  PlumeSpec spec;
  spec.name = std::move(name);
  spec.count = count;
  spec.shapes_m = as_shapes(shapes);
  spec.source_world_m = source_m;
  spec.top_z_m = top_z_m;
  spec.drift_m_s = drift_m_s;
  spec.seed = seed;
  world.add_plume(std::move(spec));
}

/// positions (n, 3), directions ahead (n, 3)
py::typing::Tuple<py::array_t<double>, py::array_t<double>> school_at(const World& world, std::size_t index,
                                                                      double time_s) {
  require(index < world.schools().size(), "school", index, "must be an index");
  const Swarm& school = *world.schools()[index];
  std::vector<Swimmer> fish(school.size());
  school.place(time_s, fish);
  std::vector<double> positions, ahead;
  for (const Swimmer& one : fish) {
    positions.insert(positions.end(), one.position_world_m.begin(), one.position_world_m.end());
    const Eigen::Vector3d along = one.velocity_world.normalized();
    ahead.insert(ahead.end(), along.begin(), along.end());
  }
  const auto rows = static_cast<py::ssize_t>(fish.size());
  return py::make_tuple(move_out(std::move(positions), {rows, 3}), move_out(std::move(ahead), {rows, 3}));
}

using SurfaceMesh = py::typing::Tuple<py::array_t<double>, py::array_t<std::uint32_t>, py::array_t<Label>>;

SurfaceMesh surface_mesh(const World& world, bool with_terrain) {
  std::vector<double> vertices;
  std::vector<std::uint32_t> triangles;
  std::vector<Label> labels;
  const auto add = [&](Label label, std::size_t vertex_count, auto vertex, std::size_t triangle_count, auto triangle) {
    const auto base = static_cast<std::uint32_t>(vertices.size() / 3);
    for (std::size_t k = 0; k < vertex_count; ++k) {
      const Eigen::Vector3d v = vertex(k);
      vertices.insert(vertices.end(), v.begin(), v.end());
    }
    for (std::size_t k = 0; k < triangle_count; ++k) {
      for (const std::uint32_t index : triangle(k)) triangles.push_back(base + index);
    }
    labels.insert(labels.end(), triangle_count, label);
  };
  if (const auto& terrain = world.terrain(); terrain && with_terrain) {
    add(
        kTerrain, terrain->nx() * terrain->ny(), [&](std::size_t k) { return terrain->vertex(k); },
        terrain->triangle_count(), [&](std::size_t k) { return terrain->triangle(k); });
  }
  Label label = kTerrain;
  for (const auto& solid : world.solids()) {
    const TriangleMesh& mesh = solid->mesh_world;
    add(
        ++label, mesh.vertices_m.size(), [&](std::size_t k) { return mesh.vertices_m[k]; }, mesh.triangles.size(),
        [&](std::size_t k) { return mesh.triangles[k]; });
  }
  const auto vertex_rows = static_cast<py::ssize_t>(vertices.size() / 3);
  const auto triangle_rows = static_cast<py::ssize_t>(labels.size());
  return py::make_tuple(move_out(std::move(vertices), {vertex_rows, 3}),
                        move_out(std::move(triangles), {triangle_rows, 3}), move_out(std::move(labels)));
}

std::string described(const World& world) {
  std::string terrain = "no terrain";
  if (world.terrain()) {
    const Eigen::Vector2d size_m = world.terrain()->far_corner_m() - world.terrain()->origin_m();
    terrain = "terrain of " + printed(size_m.x()) + " x " + printed(size_m.y()) + " m";
  }
  return "<World: " + terrain + ", " + std::to_string(world.solids().size()) + " solids>";
}

}  // namespace

void bind_world(py::module_& m) {
  bind_water(m);

  py::class_<RoundShape>(m, "RoundShape",
                         "A sphere or a straight piece of round pipe, on which ray hits are exact, without facets.")
      .def_static(
          "sphere",
          [](const py::object& centre, double radius_m) {
            return sphere(as_vector3(centre, "centre_world_m"), radius_m);
          },
          py::arg("centre_world_m"), py::arg("radius_m"),
          "Return a sphere about centre_world_m (3,). Raises ValueError.")
      .def_static(
          "cylinder",
          [](const py::object& start, const py::object& end, double radius_m) {
            return cylinder(as_vector3(start, "start_world_m"), as_vector3(end, "end_world_m"), radius_m);
          },
          py::arg("start_world_m"), py::arg("end_world_m"), py::arg("radius_m"),
          "Return a cylinder between two points (3,) on its axis, with flat caps. Raises ValueError.")
      .def_static(
          "pipe",
          [](const py::object& line, double radius_m) { return pipe(as_points(line, "line_world_m"), radius_m); },
          py::arg("line_world_m"), py::arg("radius_m"),
          "Return pieces of pipe along a line (n, 3), with caps at both ends and mitred bends. Raises ValueError.")
      .def_readonly("radius_m", &RoundShape::radius_m);

  py::class_<World, std::shared_ptr<World>> world(
      m, "World", "The world that dynamics and rays share. ENU, z up, water surface at z = 0.");
  world.def(py::init<>())
      .def_readwrite("water", &World::water)
      .def(
          "with_water",
          [](const World& world, const Water& water) {
            auto other = std::make_shared<World>(world);
            other->water = water;
            return other;
          },
          py::arg("water"), "Return a world in different water that shares this world's terrain and solids.")
      .def("set_terrain", &set_terrain, py::arg("heights_m"), py::arg("spacing_m"), py::arg("origin_m"),
           "Set the terrain. heights_m: (ny, nx) float32, where heights_m[j, i] is z at (x0 + i spacing, y0 + j\n"
           "spacing). origin_m: (x0, y0). Raises ValueError for wrong shapes, non-finite heights or an invalid\n"
           "spacing.")
      .def(
          "add_solid",
          [](World& world, std::string name, const py::object& vertices_world_m, const py::object& triangles,
             std::vector<RoundShape> shapes) {
            return world.add_solid(
                std::move(name),
                {as_points(vertices_world_m, "vertices_world_m"), as_triangles(triangles, "triangles")},
                std::move(shapes));
          },
          py::arg("name"), py::arg("vertices_world_m"), py::arg("triangles"),
          py::arg("shapes") = std::vector<RoundShape>(),
          "Add a solid and return its label. vertices_world_m: (n, 3) float64; triangles: (m, 3) indices. shapes:\n"
          "rays hit these instead of the mesh, which is then used for contacts and as the reference surface.\n"
          "Raises ValueError.")
      .def_property_readonly("label_names", &World::label_names,
                             "Names by label: nothing, terrain, then the names of the solids and the layers of cover.")
      .def(
          "solid_around",
          [](const World& world, const Eigen::Vector3d& point_world_m) -> std::optional<std::string> {
            const Solid* const solid = world.solid_around(point_world_m);
            return solid ? std::optional(solid->name) : std::nullopt;
          },
          py::arg("point_world_m"), "Return the name of a closed solid that encloses the point (3,), or None.")
      .def_property_readonly(
          "lowest_m",
          [](const World& w) { return w.terrain() ? static_cast<double>(w.terrain()->lowest_m()) : -HUGE_VAL; },
          "Height of the terrain's lowest point; -inf without terrain.")
      .def("height_at", &height_at, py::arg("xy_m"),
           "Return the height (n,) float64 of the terrain at positions (n, 2); NaN outside.")
      .def_property_readonly(
          "terrain_extent_m",
          [](const World& world) {
            require(world.terrain() != nullptr, "world.terrain", "none", "must be set");
            const Eigen::Vector2d near = world.terrain()->origin_m(), far = world.terrain()->far_corner_m();
            return py::make_tuple(near.x(), near.y(), far.x(), far.y());
          },
          "(x0, y0, x1, y1) [m]")
      .def_property_readonly(
          "highest_m",
          [](const World& w) { return w.terrain() ? static_cast<double>(w.terrain()->highest_m()) : -HUGE_VAL; },
          "Height of the terrain's highest point; -inf without terrain.")
      .def("__repr__", &described)
      .def("surface_mesh", &surface_mesh, py::arg("with_terrain") = true,
           "Return (vertices_world_m (n, 3) float64, triangles (m, 3) uint32, labels (m,) uint16) of the terrain,\n"
           "if requested, and of all solids.");
  def_add_cover(
      world, &add_cover,
      "Add a layer of pieces on the terrain and return its label; solids must be added before. meshes: pairs\n"
      "(vertices (n, 3), triangles (m, 3)) with the origin on the bed and the largest extent 1. stance:\n"
      "upright, on_bed or tumbled. The other values are as in CoverLayer (cpp/uwsim/world/cover.h). Raises\n"
      "ValueError.");
  def_add_school(
      world, &add_school,
      "Add a school of fish. shapes: for each size, the meshes (vertices (n, 3), triangles (m, 3)) of a fish in each\n"
      "phase of a stroke, x ahead and z up. The other values are as in SchoolSpec (cpp/uwsim/world/school.h). Raises\n"
      "ValueError.");
  def_add_plume(
      world, &add_plume,
      "Add a plume of bubbles after all schools. shapes: for each part of the way up, the meshes (vertices (n, 3),\n"
      "triangles (m, 3)) that a cluster may have there. source_m: where it begins. top_z_m: where it ends. drift_m_s:\n"
      "of the water. Raises ValueError.");
  world.def("school_at", &school_at, py::arg("school"), py::arg("time_s"),
            "Return where the fish of a school are at a time: positions (n, 3) [m] and unit vectors ahead (n, 3).\n"
            "Raises ValueError.");
  bind_fixed_world(m);
  bind_surface_sampler(m);
}

}  // namespace uwsim::bindings
