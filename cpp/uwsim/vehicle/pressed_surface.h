#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/triangle_mesh.h"
#include "uwsim/core/water_field.h"

namespace uwsim {

/// A hull's skin under pressure that varies from place to place.
class PressedSurface {
 public:
  struct Load {
    Eigen::Vector3d force_body_n = Eigen::Vector3d::Zero();
    Eigen::Vector3d moment_body_nm = Eigen::Vector3d::Zero();  ///< about the body's origin
  };

  PressedSurface() = default;
  /// Edges longer than `longest_edge_m` are halved until none is left, or the mesh has 100 000 triangles.
  PressedSurface(TriangleMesh mesh_body, double longest_edge_m);

  /// The integral of -p n and of r x -p n over the wetted part, each triangle cut where its pressure head, taken as
  /// linear over it, is 0; p is linear over what is wet. What a vertex' pressure does to the triangles round it is
  /// tabled, so that only the triangles that are cut are worked out.
  Load load(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body, const WaterField& water,
            double time_s) const;

 private:
  TriangleMesh mesh_body_;
  std::vector<Load> per_pascal_;  // of each vertex
};

}  // namespace uwsim
