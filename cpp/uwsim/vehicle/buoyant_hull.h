#pragma once

#include <Eigen/Core>

#include "uwsim/core/pose.h"
#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// The part of a hull that is under water.
struct Displacement {
  double volume_m3 = 0;
  Eigen::Vector3d centroid_world_m = Eigen::Vector3d::Zero();  ///< centre of buoyancy
};

/// A closed hull that displaces still water with its surface at z = 0.
///
/// Hydrostatic pressure integrated over the wetted surface gives F = rho g V, upward at the centroid of the submerged
/// volume V (Archimedes). V and its centroid are sums of signed tetrahedra over the triangles, each cut at the surface,
/// from a point on the surface: the cut face lies in a plane through that point and adds nothing, so the sum is exact
/// and continuous through the surface for any closed mesh.
class BuoyantHull {
 public:
  /// Throws InvalidValue unless the mesh is closed and winds outward.
  explicit BuoyantHull(TriangleMesh mesh_body);

  const TriangleMesh& mesh_body() const { return mesh_body_; }
  /// Of the whole hull, body frame.
  const SolidProperties& solid() const { return solid_; }
  /// No triangle work when the hull is wholly under or above the surface.
  Displacement displacement(const Pose& world_from_body) const;

 private:
  Displacement cut_at_surface(const Pose& world_from_body) const;

  TriangleMesh mesh_body_;
  SolidProperties solid_;
  Eigen::Vector3d middle_body_m_;  // of the bounding sphere
  double radius_m_ = 0;
};

}  // namespace uwsim
