#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "uwsim/core/pose.h"

namespace uwsim {

using Triangle = std::array<std::uint32_t, 3>;
using Corners = std::array<Eigen::Vector3d, 3>;

/// Triangles wind counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<Triangle> triangles;
};

/// The closest point on a triangle (Ericson 2005, "Real-Time Collision Detection", 5.1.5); edges may have zero length.
Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Corners& triangle);

/// Volume, centroid and inertia of the solid inside a closed mesh.
struct SolidProperties {
  double volume_m3 = 0;
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  /// Inertia tensor about the centroid for a density of 1 kg/m^3 [m^5]; multiplied by the density, it is in kg m^2.
  Eigen::Matrix3d inertia_per_density_m5 = Eigen::Matrix3d::Zero();
};

/// Computes the properties as sums over signed tetrahedra from the origin (as Mirtich 1996, J. Graphics Tools 1(2), but
/// with the closed form for tetrahedra).
SolidProperties solid_properties(const TriangleMesh& mesh);

/// The winding number of a surface about a point: the sum of its triangles' solid angles over 4 pi (van Oosterom and
/// Strackee 1983, IEEE Trans. Biomed. Eng. 30(2)). 1 inside a closed mesh, 0 outside it; fractional for an open mesh.
double winding_number(const TriangleMesh& mesh, const Eigen::Vector3d& point_m);

/// Throws InvalidValue unless the mesh has triangles, finite vertices and indices in range.
void require_well_formed(const TriangleMesh& mesh, std::string_view path);

/// Like require_well_formed, but also throws InvalidValue unless the surface is closed and winds outward: every edge is
/// shared by exactly two triangles that run along it in opposite directions, and the volume is positive.
void require_closed(const TriangleMesh& mesh, std::string_view path);

}  // namespace uwsim
