#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "uwsim/core/triangle_mesh.h"
#include "uwsim/core/water_field.h"

namespace uwsim {

/// The water's surface over the part of a hull where from_m <= r_axis < to_m, body frame: the points where
/// up_body . r < level_m are wet. By default, all points are.
struct WaterPlane {
  Eigen::Index axis = 0;
  double from_m = -std::numeric_limits<double>::infinity(), to_m = std::numeric_limits<double>::infinity();
  Eigen::Vector3d up_body = Eigen::Vector3d::UnitZ();
  double level_m = std::numeric_limits<double>::infinity();
};

/// The part of a hull's surface that is under water, as triangles that wind outward, and the force of the water's
/// pressure on each, body frame.
///
/// The force is the pressure that acts on hulls, at the triangle's centroid, times its area, along the inward normal
/// (Kerner 2015, "Water interaction model for boats in video games", part 1). In still water of one density, where
/// pressure is linear, it is exact, and the sum is the weight of the displaced water (Archimedes) to rounding error,
/// since the pressure on the waterplane, which closes the surface, is 0. In waves it is accurate for triangles that are
/// short compared with them.
struct WetSurface {
  std::vector<double> corners_body_m;  ///< x, y and z of the three corners of each triangle
  std::vector<double> forces_body_n;   ///< x, y and z for each triangle
};

WetSurface cut_at_surface(const TriangleMesh& mesh_body, const std::vector<WaterPlane>& planes,
                          const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                          const WaterField& water, double time_s);

}  // namespace uwsim
