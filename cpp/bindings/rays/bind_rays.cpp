#include <pybind11/eigen.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/gil.h"
#include "bindings/core/points.h"
#include "uwsim/core/parallel.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/rays/surface_voxels.h"
#include "uwsim/rays/visibility.h"
#include "uwsim/rays/voxel_scene.h"

namespace uwsim::bindings {
namespace {

constexpr std::size_t kRaysAtOnce = 4096;

struct RayHits {
  py::array_t<float> ranges_m;
  py::array_t<float> normals_world;
  py::array_t<Label> labels;
};

/// Casts rays as for pictures: Embree's hits in float, for sixteen rays at a time, relative to the origin of the first
/// ray.
void cast_for_picture(const RayScene& scene, std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits) {
  for (std::size_t first = 0; first < rays.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, rays.size() - first);
    const Eigen::Vector3d anchor = rays[first].origin_world_m;
    RayPacket packet{};
    for (std::size_t k = 0; k < count; ++k) {
      const Eigen::Vector3f from = (rays[first + k].origin_world_m - anchor).cast<float>();
      const Eigen::Vector3f along = rays[first + k].direction_world.cast<float>();
      packet.origin_x[k] = from.x(), packet.origin_y[k] = from.y(), packet.origin_z[k] = from.z();
      packet.direction_x[k] = along.x(), packet.direction_y[k] = along.y(), packet.direction_z[k] = along.z();
      packet.far_m[k] = static_cast<float>(max_range_m);
      packet.active[k] = -1;
    }
    HitPacket met;
    scene.cast(anchor, packet, met, RayOrder::kCoherent);
    for (std::size_t k = 0; k < count; ++k) {
      const bool hit = std::isfinite(met.distance_m[k]);
      const Eigen::Vector3f normal(met.normal_x[k], met.normal_y[k], met.normal_z[k]);
      hits[first + k] = {met.distance_m[k], hit ? normal.stableNormalized().eval() : Eigen::Vector3f::Zero().eval(),
                         static_cast<Label>(met.label[k])};
    }
  }
}

/// Casts rays from origins (n, 3) or (1, 3) along directions (n, 3). Calls cast(rays, hits) for batches of rays, on all
/// threads.
template <typename Cast>
RayHits cast_rays(const py::object& origins_m, const py::object& directions_world, double max_range_m,
                  const Cast& cast) {
  require(max_range_m > 0, "max_range_m", max_range_m, "must be positive");
  const auto origins = as_array<double>(origins_m, "origins_m", {-1, 3});
  const auto directions = as_array<double>(directions_world, "directions", {-1, 3});
  const bool shared = origins.shape(0) == 1;
  require(shared || origins.shape(0) == directions.shape(0), "origins_m.shape[0]", origins.shape(0),
          "must be 1 or the number of directions");
  const auto n = static_cast<std::size_t>(directions.shape(0));
  const double *from = origins.data(), *along = directions.data();
  std::vector<float> ranges(n), normals(3 * n);
  std::vector<Label> labels(n);
  without_gil([&] {
    parallel_batches(n, kRaysAtOnce, usable_threads(), [&](std::size_t first, std::size_t last, std::size_t) {
      std::vector<Ray> rays(last - first);
      std::vector<RayHit> hits(last - first);
      for (std::size_t k = first; k < last; ++k) {
        const Eigen::Vector3d origin(from + (shared ? 0 : 3 * k)), direction(along + 3 * k);
        require(origin.allFinite(), "origins_m", origin.transpose(), "must be finite");
        require(direction.allFinite(), "directions", direction.transpose(), "must be finite");
        require(!direction.isZero(0), "directions", 0, "must not be zero");
        rays[k - first] = {origin, direction.stableNormalized()};
      }
      cast(std::span<const Ray>(rays), std::span<RayHit>(hits));
      for (std::size_t k = first; k < last; ++k) {
        const RayHit& hit = hits[k - first];
        ranges[k] = static_cast<float>(hit.distance_m);
        std::copy_n(hit.normal_world.data(), 3, &normals[3 * k]);
        labels[k] = hit.label;
      }
    });
    return 0;
  });
  const auto rows = static_cast<py::ssize_t>(n);
  return {move_out(std::move(ranges)), move_out(std::move(normals), {rows, 3}), move_out(std::move(labels))};
}

RayHits cast(const RayScene& scene, const py::object& origins_m, const py::object& directions_world, double max_range_m,
             bool exact) {
  return cast_rays(origins_m, directions_world, max_range_m, [&](std::span<const Ray> rays, std::span<RayHit> hits) {
    exact ? scene.cast(rays, max_range_m, hits) : cast_for_picture(scene, rays, max_range_m, hits);
  });
}

RayHits cast_at_voxels(const VoxelScene& scene, const py::object& origins_m, const py::object& directions_world,
                       double max_range_m) {
  return cast_rays(origins_m, directions_world, max_range_m, [&](std::span<const Ray> rays, std::span<RayHit> hits) {
    for (std::size_t k = 0; k < rays.size(); ++k) hits[k] = scene.cast(rays[k], max_range_m);
  });
}

py::array_t<bool> visible(const RayScene& scene, const py::object& origin_m, const py::object& points_m,
                          double tolerance_m) {
  const Eigen::Vector3d origin = as_vector3(origin_m, "origin_m");
  require(origin.allFinite(), "origin_m", origin.transpose(), "must be finite");
  require(tolerance_m >= 0, "tolerance_m", tolerance_m, "must not be negative");
  const auto points = as_points(points_m, "points_m");
  py::array_t<bool> seen(static_cast<py::ssize_t>(points.size()));
  bool* out = seen.mutable_data();
  {
    const GilReleased unlocked;
    std::vector<Ray> rays(points.size());
    std::vector<RayHit> hits(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector3d to_point = points[k] - origin;
      rays[k] = {origin, to_point.isZero(0) ? Eigen::Vector3d::UnitZ().eval() : to_point.stableNormalized().eval()};
    }
    scene.cast(rays, std::numeric_limits<float>::max(), hits, usable_threads());
    for (std::size_t k = 0; k < points.size(); ++k) {
      out[k] = hits[k].distance_m + tolerance_m >= (points[k] - origin).norm();
    }
  }
  return seen;
}

py::array_t<bool> seen(const RayScene& scene, const py::object& viewpoints_m, const py::object& points_m,
                       const py::object& group_of_point, std::size_t group_count, double range_m, double tolerance_m) {
  require(range_m > 0, "range_m", range_m, "must be positive");
  require(tolerance_m >= 0, "tolerance_m", tolerance_m, "must not be negative");
  const auto viewpoints = as_points(viewpoints_m, "viewpoints_m");
  const auto points = as_points(points_m, "points_m");
  const auto group_of = as_array<std::int64_t>(group_of_point, "group_of_point", {-1});
  require(group_of.shape(0) == static_cast<py::ssize_t>(points.size()), "group_of_point.shape[0]", group_of.shape(0),
          "must be the number of points");
  const std::int64_t* group = group_of.data();
  std::vector<std::uint8_t> out;
  {
    const GilReleased unlocked;
    std::vector<std::size_t> first(group_count + 1, 0);
    for (std::size_t k = 0; k < points.size(); ++k) {
      require(group[k] >= 0 && group[k] < static_cast<std::int64_t>(group_count), "group_of_point", group[k],
              "must be below group_count");
      require(k == 0 || group[k - 1] <= group[k], "group_of_point", group[k], "must be sorted");
      ++first[static_cast<std::size_t>(group[k]) + 1];
    }
    for (std::size_t k = 0; k < group_count; ++k) first[k + 1] += first[k];
    out = seen_groups(scene, viewpoints, {points, first}, range_m, tolerance_m, usable_threads());
  }
  return move_out(std::move(out)).attr("view")("bool").cast<py::array_t<bool>>();
}

py::array_t<double> distance(const RayScene& scene, const py::object& points_m) {
  const auto points = as_points(points_m, "points_m");
  std::vector<double> distances(points.size());
  {
    const GilReleased unlocked;
    scene.distance(points, distances, usable_threads());
  }
  return move_out(std::move(distances));
}

using CoverArrays =
    py::typing::Tuple<py::array_t<double>, py::array_t<double>, py::array_t<Label>, py::array_t<std::uint32_t>>;

CoverArrays cover_in(const RayScene& scene, const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m) {
  const std::vector<PlacedPiece> pieces = without_gil([&] { return scene.cover_in({low_m, high_m}); });
  std::vector<double> positions, sizes;
  std::vector<Label> labels;
  std::vector<std::uint32_t> numbers;
  for (const PlacedPiece& piece : pieces) {
    positions.insert(positions.end(), piece.position_world_m.begin(), piece.position_world_m.end());
    sizes.push_back(piece.size_m);
    labels.push_back(piece.label);
    numbers.push_back(piece.number);
  }
  return py::make_tuple(move_out(std::move(positions), {static_cast<py::ssize_t>(pieces.size()), 3}),
                        move_out(std::move(sizes)), move_out(std::move(labels)), move_out(std::move(numbers)));
}

std::unique_ptr<SurfaceVoxels> make_surface_voxels(const RayScene& scene, double resolution_m) {
  require(resolution_m > 0 && std::isfinite(resolution_m), "resolution_m", resolution_m, "must be finite and positive");
  return std::make_unique<SurfaceVoxels>(scene, resolution_m);
}

py::array_t<double> voxel_distances(SurfaceVoxels& voxels, const py::object& packed_keys) {
  const auto keys = as_array<std::int64_t>(packed_keys, "voxels", {-1});
  std::vector<double> distances(static_cast<std::size_t>(keys.size()));
  {
    const GilReleased unlocked;
    voxels.distances(span_of(keys), distances, usable_threads());
  }
  return move_out(std::move(distances));
}

py::array_t<bool> hold_surface(const SurfaceVoxels& voxels, const py::object& packed_keys,
                               const py::object& distances_m) {
  const auto keys = as_array<std::int64_t>(packed_keys, "voxels", {-1});
  const auto distances = as_array<double>(distances_m, "distances_m", {-1});
  require(distances.size() == keys.size(), "distances_m.shape[0]", distances.size(), "must be the number of voxels");
  std::vector<std::uint8_t> hold(static_cast<std::size_t>(keys.size()));
  {
    const GilReleased unlocked;
    voxels.hold_surface(span_of(keys), span_of(distances), hold, usable_threads());
  }
  return move_out(std::move(hold)).attr("view")("bool").cast<py::array_t<bool>>();
}

void bind_surface_voxels(py::module_& m) {
  py::class_<SurfaceVoxels>(
      m, "SurfaceVoxels",
      "Determines the distances of voxel centres from the true surface, and whether the surface passes through\n"
      "the voxels. Results are cached, so that a map can be scored while it grows.")
      .def(py::init(&make_surface_voxels), py::arg("rays"), py::arg("resolution_m"),
           "rays: RayScene of the world. Voxels are floor(x / resolution_m) on each axis. Raises ValueError.")
      .def_property_readonly("resolution_m", &SurfaceVoxels::resolution_m)
      .def("__len__", &SurfaceVoxels::known, "The number of voxels that have been examined.")
      .def(
          "look_at",
          [](SurfaceVoxels& voxels, const py::object& points_world_m) {
            const auto points = as_point_rows(points_world_m, "points_world_m");
            const GilReleased unlocked;
            voxels.look_at(span_of(points));
          },
          py::arg("points_world_m"),
          "Examine the voxels that contain points (n, 3), in advance of `distances_m`. Releases the GIL. Raises\n"
          "ValueError.")
      .def("distances_m", &voxel_distances, py::arg("voxels"),
           "Return the distances from voxel centres to the nearest triangle, (n,) float64, exact to double\n"
           "rounding. voxels: (n,) int64, packed as by uwsim.mapping.voxel_keys. Voxels that have already been\n"
           "examined take less time. Uses all threads. Releases the GIL. Raises ValueError.")
      .def("hold_surface", &hold_surface, py::arg("voxels"), py::arg("distances_m"),
           "Return whether the surface passes through voxels, or within 1 mm of them, (n,) bool, given their\n"
           "distances (n,). Uses all threads. Releases the GIL. Raises ValueError.");
}

}  // namespace

void bind_rays(py::module_& m) {
  py::class_<RayHits>(m, "RayHits")
      .def_readonly("ranges_m", &RayHits::ranges_m, "(n,) float32; inf if nothing was hit within range")
      .def_readonly("normals_world", &RayHits::normals_world, "(n, 3) float32, unit; zero if nothing was hit")
      .def_readonly("labels", &RayHits::labels, "(n,) uint16, see World.label_names; vehicles follow");

  py::class_<RayScene, std::shared_ptr<RayScene>>(
      m, "RayScene",
      "The world's surfaces, prepared for rays (Embree). A snapshot: solids added later are not included.\n"
      "Vehicles are included only in the scene returned by Simulation.scene_around.")
      .def(py::init([](World world) {  // a copy, since other threads may add to the original meanwhile
             const GilReleased unlocked;
             return std::make_shared<RayScene>(world);
           }),
           py::arg("world"))
      .def(
          "prepare", [](const RayScene& scene) { without_gil([&] { scene.prepare(); }); },
          "Build Embree's trees of the fixed surfaces, unless they exist. Without this call, the first ray builds "
          "them.\n"
          "Raises ValueError if there is not enough memory.")
      .def("cast", &cast, py::arg("origins_m"), py::arg("directions"), py::arg("max_range_m"), py::arg("exact") = true,
           "Cast rays. origins_m: (n, 3) or (1, 3); directions: (n, 3), of any nonzero length. exact: False for\n"
           "pictures: in float and faster, with errors in distance of about 1e-4 m. Returns RayHits. Raises\n"
           "ValueError.")
      .def("visible", &visible, py::arg("origin_m"), py::arg("points_m"), py::arg("tolerance_m") = 1e-3,
           "Return whether points are visible from origin_m (3,), with no surface more than tolerance_m in front\n"
           "of them, (n,) bool.")
      .def("seen_groups", &seen, py::arg("viewpoints_m"), py::arg("points_m"), py::arg("group_of_point"),
           py::arg("group_count"), py::arg("range_m"), py::arg("tolerance_m") = 1e-3,
           "Return, for each group, whether one of its points is visible from one of viewpoints_m (v, 3): within\n"
           "range_m, with no surface more than tolerance_m in front of it, (group_count,) bool. points_m: (n, 3);\n"
           "group_of_point: (n,), sorted. Raises ValueError.")
      .def("__repr__",
           [](const RayScene& scene) {
             return std::string("<RayScene: surfaces ") + (scene.terrain() ? "with" : "without") + " terrain>";
           })
      .def("cover_in", &cover_in, py::arg("low_m"), py::arg("high_m"),
           "Return the pieces of cover whose origins lie between two corners (2,) of an area: positions_world_m\n"
           "(n, 3), sizes_m (n,), labels (n,) and numbers (n,), as in Picture.pieces. Releases the GIL.")
      .def("distance_m", &distance, py::arg("points_m"),
           "Return the distances (n,) float64 from points (n, 3) to the nearest triangle, exact to double rounding.");

  py::class_<VoxelScene>(
      m, "VoxelScene",
      "Cubes, such as a map's occupied voxels, prepared for the rays of pictures. The cubes lie at multiples\n"
      "of edge_m.")
      .def(py::init([](const py::object& centres_world_m, double edge_m) {
             const auto centres = as_points(centres_world_m, "centres_world_m");
             return without_gil([&] { return std::make_unique<VoxelScene>(centres, edge_m); });
           }),
           py::arg("centres_world_m"), py::arg("edge_m"),
           "centres_world_m: (n, 3), less than 2^17 cubes apart. Raises ValueError.")
      .def("cast", &cast_at_voxels, py::arg("origins_m"), py::arg("directions"), py::arg("max_range_m"),
           "Like RayScene.cast; labels are 0. A ray that starts inside a cube hits it at distance 0.");
  bind_surface_voxels(m);
}

}  // namespace uwsim::bindings
