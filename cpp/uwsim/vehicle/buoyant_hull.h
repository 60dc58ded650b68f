#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/triangle_mesh.h"
#include "uwsim/core/volume_parts.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/hull_pressure.h"
#include "uwsim/vehicle/volume_moments.h"

namespace uwsim {

/// The part of a hull under a horizontal plane.
struct Displacement {
  double volume_m3 = 0;
  Eigen::Vector3d centroid_world_m = Eigen::Vector3d::Zero();
};

/// The force of the water's pressure on a hull, body frame; the moment is about the body's origin.
struct Buoyancy {
  double volume_m3 = 0;                                     ///< submerged volume; see BuoyantHull::level_m
  Eigen::Vector3d centre_body_m = Eigen::Vector3d::Zero();  ///< of the submerged volume
  Eigen::Vector3d force_body_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_body_nm = Eigen::Vector3d::Zero();
  VolumeFlow flow;  ///< over the whole hull, moved so that its centroid is at centre_body_m
};

/// A closed hull under the pressure of the surrounding water: buoyancy and wave excitation (Froude-Krylov).
///
/// Still water: the weight of the displaced water, the integral of rho(z) g dV, acts upward through its centroid
/// (Archimedes). The volume is a sum of signed tetrahedra over the triangles, each cut at the surface, and rho is
/// piecewise linear in depth. The result is exact for any closed mesh, and continuous through the surface. A hull that
/// is fully submerged in one layer, or completely dry, requires no work on triangles.
///
/// Waves: the integral of the pressure p over the wetted triangles, each cut where p falls to atmospheric pressure,
/// with p linear over triangles whose edges are at most a quarter of the hull's radius. For a hull deep enough below
/// the waves, force and moment follow from the acceleration of the displaced water instead (VolumeFlow). The two are
/// blended smoothly over one radius of depth.
class BuoyantHull {
 public:
  /// Throws InvalidValue unless the mesh is closed and winds outward.
  explicit BuoyantHull(TriangleMesh mesh_body);

  const TriangleMesh& mesh_body() const { return mesh_body_; }
  /// Volume, centroid and inertia of the whole hull, body frame.
  const SolidProperties& solid() const { return solid_; }
  /// The part below the plane z = level_m.
  Displacement displacement(const Pose& world_from_body, double level_m = 0) const;
  /// Height of the water's surface above the hull's middle. `buoyancy` treats the volume below it as submerged.
  double level_m(const Pose& world_from_body, const WaterField& water, double time_s) const;
  /// `world_from_body` is the rotation of the body located at `position_world_m`.
  Buoyancy buoyancy(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                    const WaterField& water, double time_s) const;

 private:
  struct Placed;

  VolumeMoments moments_below(const Placed& at, double level_m, bool with_second) const;
  Buoyancy in_still_water(const Placed& at, const WaterField& water, double surface_m) const;
  Buoyancy in_layers(const Placed& at, const WaterField& water, double surface_m, const VolumeMoments& wet) const;
  Buoyancy through_waves(const Placed& at, const WaterField& water, double time_s, double surface_m) const;
  Buoyancy below_waves(const Placed& at, const WaterField& water, double time_s, const VolumeFlow& flow) const;
  VolumeFlow flow_at(const Placed& at, const Eigen::Vector3d& centre_body_m, const WaterField& water,
                     double time_s) const;
  void cut_into_slices();

  TriangleMesh mesh_body_;
  SolidProperties solid_;
  VolumeParts parts_;
  Eigen::Vector3d middle_body_m_;  // of the bounding sphere
  Eigen::Vector3d half_size_m_;    // of the bounding box
  double radius_m_ = 0;
  CutVolume volume_;  // relative to the middle
  HullPressure pressure_;
};

}  // namespace uwsim
