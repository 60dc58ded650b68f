#include <tuple>

#include "bindings/core/points.h"
#include "bindings/mapping/bind_map.h"
#include "bindings/mapping/binders.h"
#include "uwsim/mapping/distance_field.h"

namespace uwsim::bindings {
namespace {

constexpr std::size_t kGridVoxelsMax = 1'000'000'000;

std::vector<py::ssize_t> extents(const std::array<int, 3>& shape) { return {shape[0], shape[1], shape[2]}; }

std::vector<BodyPose> as_poses(const py::object& positions_world_m, const py::object& orientations_xyzw) {
  const auto positions = as_array<double>(positions_world_m, "positions_world_m", {-1, 3});
  const auto orientations = as_array<double>(orientations_xyzw, "orientations_xyzw", {positions.shape(0), 4});
  std::vector<BodyPose> poses;
  for (py::ssize_t i = 0; i < positions.shape(0); ++i) {
    poses.push_back({Eigen::Vector3d(positions.data(i, 0)), Eigen::Quaterniond(orientations.data(i, 0))});
  }
  return poses;
}

}  // namespace

void bind_map_planning(MapClass& map) {
  map.def(
         "states_in",
         [](const OccupancyMap& self, const py::object& low_world_m, const py::object& high_world_m) {
           const Eigen::Vector3d low = as_vector3(low_world_m, "box.low_world_m");
           const Eigen::Vector3d high = as_vector3(high_world_m, "box.high_world_m");
           StateGrid grid = without_gil([&] { return self.states_in(low, high, kGridVoxelsMax); });
           return std::make_tuple(move_out(std::move(grid.states), extents(grid.shape)), grid.low_centre_world_m);
         },
         py::arg("low_world_m"), py::arg("high_world_m"),
         "Return the states of the voxels whose centres are in a box, (nx, ny, nz) int8: 1 occupied, 0 free, -1\n"
         "unknown. Also return the centre of the first voxel, (3,). Raises ValueError. Releases the GIL.")
      .def(
          "spheres_blocked",
          [](const OccupancyMap& self, const py::object& centres_world_m, double radius_m, bool unknown_blocks) {
            const auto centres = as_array<double>(centres_world_m, "centres_world_m", {-1, 3});
            auto blocked =
                without_gil([&] { return self.spheres_blocked(span_of(centres), radius_m, unknown_blocks); });
            return move_out(std::move(blocked)).view("bool");
          },
          py::arg("centres_world_m"), py::arg("radius_m"), py::arg("unknown_blocks"),
          "Return whether spheres touch occupied (or unknown) voxels, (n,) bool. Raises ValueError. Releases the\n"
          "GIL.")
      .def(
          "bodies_blocked",
          [](const OccupancyMap& self, const py::object& points_body_m, const py::object& positions_world_m,
             const py::object& orientations_xyzw, bool unknown_blocks) {
            const auto points = as_array<double>(points_body_m, "points_body_m", {-1, 3});
            const std::vector<BodyPose> poses = as_poses(positions_world_m, orientations_xyzw);
            auto blocked = without_gil([&] { return self.bodies_blocked(span_of(points), poses, unknown_blocks); });
            return move_out(std::move(blocked)).view("bool");
          },
          py::arg("points_body_m"), py::arg("positions_world_m"), py::arg("orientations_xyzw"),
          py::arg("unknown_blocks"),
          "Return whether a body's points, (k, 3), are in occupied (or unknown) voxels in each pose, (n,) bool.\n"
          "positions_world_m: (n, 3). orientations_xyzw: (n, 4). Raises ValueError. Releases the GIL.")
      .def(
          "unknown_in_view_m3",
          [](const OccupancyMap& self, const py::object& positions_world_m, const py::object& orientations_xyzw,
             double horizontal_rad, double vertical_rad, double range_m) {
            const std::vector<BodyPose> poses = as_poses(positions_world_m, orientations_xyzw);
            const ViewPyramid view{horizontal_rad, vertical_rad, range_m};
            return move_out(without_gil([&] { return self.unknown_in_view_m3(poses, view); }));
          },
          py::arg("positions_world_m"), py::arg("orientations_xyzw"), py::arg("horizontal_rad"),
          py::arg("vertical_rad"), py::arg("range_m"),
          "Return the volume of unknown voxels that a sensor in each pose would see, (n,) float64. Raises\n"
          "ValueError. Releases the GIL.");
}

void bind_distance_field(py::module_& m) {
  py::class_<DistanceField>(m, "DistanceField",
                            "Distances to the nearest occupied voxel in a box of a map, by dynamicEDT3D.")
      .def(py::init([](const OccupancyMap& map, const py::object& low_world_m, const py::object& high_world_m,
                       double max_distance_m, bool unknown_is_occupied) {
             const Eigen::Vector3d low = as_vector3(low_world_m, "box.low_world_m");
             const Eigen::Vector3d high = as_vector3(high_world_m, "box.high_world_m");
             return without_gil([&] { return DistanceField(map, low, high, {max_distance_m, unknown_is_occupied}); });
           }),
           py::arg("map"), py::arg("low_world_m"), py::arg("high_world_m"), py::kw_only(), py::arg("max_distance_m"),
           py::arg("unknown_is_occupied"))
      .def(
          "update",
          [](DistanceField& self, const OccupancyMap& map) { return without_gil([&] { return self.update(map); }); },
          py::arg("map"), "Update the field from the map. Returns the number of voxels that changed. Releases the GIL.")
      .def(
          "distance_m",
          [](const DistanceField& self, const py::object& points_world_m) {
            const auto points = as_array<double>(points_world_m, "points_world_m", {-1, 3});
            return move_out(without_gil([&] { return self.distance_m(span_of(points)); }));
          },
          py::arg("points_world_m"), "Return the distances at points (n, 3): (n,) float32. Releases the GIL.")
      .def(
          "gradient",
          [](const DistanceField& self, const py::object& points_world_m) {
            const auto points = as_array<double>(points_world_m, "points_world_m", {-1, 3});
            return rows_out(without_gil([&] { return self.gradient(span_of(points)); }));
          },
          py::arg("points_world_m"), "Return the gradients at points (n, 3): (n, 3) float64. Releases the GIL.")
      .def("grid",
           [](const DistanceField& self) {
             return move_out(without_gil([&] { return self.grid(); }), extents(self.shape()));
           })
      .def_property_readonly("shape", &DistanceField::shape)
      .def_property_readonly("low_centre_world_m", [](const DistanceField& self) { return self.low_centre_world_m(); });
}

}  // namespace uwsim::bindings
