#pragma once

#include <Eigen/Core>
#include <array>
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
  /// Halves edges until they are at most about `longest_edge_m` long or the mesh has 100,000 triangles.
  HullPressure(TriangleMesh mesh_body, double longest_edge_m);

  /// The integrals of -p n and of r x -p n over the wetted part. Each triangle is cut where its pressure head, assumed
  /// linear over it, is 0, and p is linear over the wet part. Below the surface, p is quadratic along edges that were
  /// halved: linear over edges of length h, a wave's share would be short by (k h)^2 / 12. The load that each vertex's
  /// pressure exerts on the surrounding triangles is tabulated, so only triangles that are cut are integrated
  /// individually.
  Load load(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body, const WaterField& water,
            double time_s) const;

 private:
  /// A group of triangles, which are examined one by one only if the water's surface cuts the group.
  struct Patch {
    std::size_t first_triangle, end_triangle, first_vertex, vertex_count;
  };

  /// The middle of a halved edge, and the load on the two triangles that shared the edge, before they were divided, due
  /// to the difference of 1 Pa at the middle from the mean of the ends: with p quadratic, less that with p linear over
  /// the parts.
  struct Middle {
    std::uint32_t vertex;
    std::array<std::uint32_t, 2> ends;
    Vector6d per_pascal = Vector6d::Zero();
  };

  void put_vertices();
  void add_to_table(std::uint32_t vertex, const Vector6d& per_pascal);
  void tabulate_linear();
  void tabulate_quadratic(const std::vector<Triangle>& undivided, std::vector<Middle> middles);
  void take_back_near_surface(std::span<const double> heads_m, std::span<const double> pressures_pa,
                              Vector6d& load) const;
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
  std::vector<Middle> middles_;
  double fade_m_ = 0;  // head over which the pressure becomes quadratic
};

}  // namespace uwsim
