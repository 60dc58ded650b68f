#include <pybind11/eigen.h>

#include <utility>

#include "bindings/core/convert.h"
#include "bindings/core/gil.h"
#include "bindings/core/points.h"
#include "bindings/world/binders.h"
#include "uwsim/core/check.h"
#include "uwsim/world/surface_sampler.h"

namespace uwsim::bindings {
namespace {

constexpr std::int64_t kMostCellsASide = 512;  // memory holds one byte for each cell of a cube with this edge

SurfaceSampler make_sampler(const World& world, double resolution_m, const py::object& area_world_m,
                            const py::object& low_m, const py::object& high_m) {
  require(resolution_m > 0 && std::isfinite(resolution_m), "resolution_m", resolution_m, "must be finite and positive");
  const auto corners = as_array<double>(area_world_m, "area_world_m", {-1, 2});
  require(corners.shape(0) >= 3, "area_world_m.shape[0]", corners.shape(0), "must be at least 3");
  std::vector<Eigen::Vector2d> area;
  for (py::ssize_t k = 0; k < corners.shape(0); ++k) {
    area.emplace_back(corners.at(k, 0), corners.at(k, 1));
    require(area.back().allFinite(), "area_world_m", area.back().transpose(), "must be finite");
  }
  const Eigen::Vector3d low = as_vector3(low_m, "low_m"), high = as_vector3(high_m, "high_m");
  require(!low.hasNaN(), "low_m", low.transpose(), "must not be NaN");
  require(!high.hasNaN(), "high_m", high.transpose(), "must not be NaN");
  const GilReleased unlocked;
  return SurfaceSampler(world, resolution_m, std::move(area), Eigen::AlignedBox3d(low, high));
}

std::tuple<py::array_t<double>, py::array_t<std::int64_t>, py::array_t<std::int64_t>> sample(
    const SurfaceSampler& sampler, const GridCell& first, const GridCell& end) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require(end[axis] - first[axis] <= kMostCellsASide, "end", end[axis], "must be at most 512 voxels from first");
  }
  SurfaceSamples samples = without_gil([&] { return sampler.sample(first, end); });
  return {rows_out(std::move(samples.points_world_m)), move_out(std::move(samples.voxel_of_sample)),
          rows_out(std::move(samples.voxels))};
}

}  // namespace

void bind_surface_sampler(py::module_& m) {
  py::class_<SurfaceSampler>(m, "SurfaceSampler",
                             "Samples the parts of a world's terrain and solids that lie inside a polygon and a box.")
      .def(py::init(&make_sampler), py::arg("world"), py::arg("resolution_m"), py::arg("area_world_m"),
           py::arg("low_m"), py::arg("high_m"),
           "area_world_m: (k, 2), a simple polygon. low_m, high_m: (3,), the box, which may be infinite. Raises\n"
           "ValueError.")
      .def_property_readonly(
          "box_m",
          [](const SurfaceSampler& sampler) -> std::optional<std::pair<Eigen::Vector3d, Eigen::Vector3d>> {
            if (sampler.box_m().isEmpty()) return std::nullopt;
            return std::pair<Eigen::Vector3d, Eigen::Vector3d>(sampler.box_m().min(), sampler.box_m().max());
          },
          "Corners (3,) of a box that encloses all surface to be sampled; None if there is none.")
      .def_property_readonly("voxels_in_box", &SurfaceSampler::voxels_in_box,
                             "Approximate number of voxels in that box that the surface passes through.")
      .def("sample", &sample, py::arg("first"), py::arg("end"),
           "Sample the voxels floor(x / resolution_m) from first up to, but excluding, end: (3,) integers, at most\n"
           "512 per side. Returns points (n, 3) float64, sorted by voxel, at most one per octant of a voxel; the\n"
           "voxel of each point, (n,) int64; and the voxels (v, 3) int64, sorted. Releases the GIL. Raises\n"
           "ValueError.");
}

}  // namespace uwsim::bindings
