#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/triangle_mesh.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/pressure_kernels.h"

namespace uwsim {

/// Integrates a spatially varying pressure over the wetted surface of a hull.
class HullPressure {
 public:
  struct Load {
    Eigen::Vector3d force_body_n = Eigen::Vector3d::Zero();
    Eigen::Vector3d moment_body_nm = Eigen::Vector3d::Zero();  ///< about the body's origin
  };

  HullPressure() = default;
  /// Halves edges longer than `longest_edge_m` until none is left or the mesh has 100,000 triangles.
  HullPressure(TriangleMesh mesh_body, double longest_edge_m);

  /// The integrals of -p n and of r x -p n over the wetted part. Each triangle is cut where its pressure head, assumed
  /// linear over it, is 0, and p is linear over the wet part. The load that each vertex's pressure exerts on the
  /// surrounding triangles is tabulated, so only triangles that are cut are integrated individually.
  Load load(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body, const WaterField& water,
            double time_s) const;

 private:
  /// A group of triangles, which are examined one by one only if the water's surface cuts the group.
  struct Patch {
    std::size_t first_triangle, end_triangle, first_vertex, vertex_count;
  };

  void put_vertices();
  void gather_patches();
  std::span<const std::uint32_t> vertices_of(const Patch& patch) const {
    return std::span(patch_vertices_).subspan(patch.first_vertex, patch.vertex_count);
  }
  void add_change_by_cut(std::size_t triangle, std::span<const double> heads_m, std::span<const double> pressures_pa,
                         Vector6d& load) const;

  TriangleMesh mesh_body_;
  std::vector<VertexBlock> blocks_;
  std::vector<Patch> patches_;
  std::vector<std::uint32_t> patch_vertices_;
  std::vector<Eigen::Vector3d> inward_areas_m2_;  // one per triangle
};

}  // namespace uwsim
