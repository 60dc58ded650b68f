#include <algorithm>
#include <limits>
#include <memory>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "uwsim/core/parallel.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim::bindings {
namespace {

struct RayHits {
  py::array_t<float> ranges_m;
  py::array_t<float> normals_world;
  py::array_t<Label> labels;
};

RayHits cast(const RayScene& scene, const py::object& origins_m, const py::object& directions_world,
             double max_range_m) {
  require(max_range_m > 0, "max_range_m", max_range_m, "must be positive");
  const auto origins = as_points(origins_m, "origins_m");
  const auto directions = as_points(directions_world, "directions");
  const bool shared = origins.size() == 1;
  require(shared || origins.size() == directions.size(), "origins_m.shape[0]", origins.size(),
          "must be 1 or the number of directions");
  const std::size_t n = directions.size();
  std::vector<float> ranges(n), normals(3 * n);
  std::vector<Label> labels(n);
  {
    const py::gil_scoped_release unlocked;
    std::vector<Ray> rays(n);
    std::vector<RayHit> hits(n);
    for (std::size_t k = 0; k < n; ++k) {
      require(!directions[k].isZero(0), "directions", 0, "must not be zero");
      rays[k] = {origins[shared ? 0 : k], directions[k].stableNormalized()};
    }
    scene.cast(rays, max_range_m, hits, usable_threads());
    for (std::size_t k = 0; k < n; ++k) {
      ranges[k] = static_cast<float>(hits[k].distance_m);
      std::copy_n(hits[k].normal_world.data(), 3, normals.begin() + static_cast<std::ptrdiff_t>(3 * k));
      labels[k] = hits[k].label;
    }
  }
  const auto rows = static_cast<py::ssize_t>(n);
  return {move_out(std::move(ranges)), move_out(std::move(normals), {rows, 3}), move_out(std::move(labels))};
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
    const py::gil_scoped_release unlocked;
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

py::array_t<double> distance(const RayScene& scene, const py::object& points_m) {
  const auto points = as_points(points_m, "points_m");
  std::vector<double> distances(points.size());
  {
    const py::gil_scoped_release unlocked;
    scene.distance(points, distances, usable_threads());
  }
  return move_out(std::move(distances));
}

}  // namespace

void bind_rays(py::module_& m) {
  py::class_<RayHits>(m, "RayHits")
      .def_readonly("ranges_m", &RayHits::ranges_m, "(n,) float32; inf where nothing was hit within range")
      .def_readonly("normals_world", &RayHits::normals_world, "(n, 3) float32, unit; zero where nothing was hit")
      .def_readonly("labels", &RayHits::labels, "(n,) uint16, see World.label_names");

  py::class_<RayScene, std::shared_ptr<RayScene>>(
      m, "RayScene", "The world's surfaces, prepared for rays (Embree). A snapshot: solids added later are not in it.")
      .def(py::init([](World world) {  // a copy: other threads may add to the original meanwhile
             const py::gil_scoped_release unlocked;
             return std::make_shared<RayScene>(world);
           }),
           py::arg("world"))
      .def("cast", &cast, py::arg("origins_m"), py::arg("directions"), py::arg("max_range_m"),
           "origins_m: (n, 3) or (1, 3); directions: (n, 3), of any length but zero. Returns RayHits. Raises "
           "ValueError.")
      .def("visible", &visible, py::arg("origin_m"), py::arg("points_m"), py::arg("tolerance_m") = 1e-3,
           "(n,) bool: seen from origin_m (3,), no surface lies more than tolerance_m before the point.")
      .def("distance_m", &distance, py::arg("points_m"),
           "(n, 3) -> (n,) float64, the distance to the nearest triangle, exact to double rounding.");
}

}  // namespace uwsim::bindings
