#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/triangle_mesh.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/pressed_surface.h"
#include "uwsim/vehicle/volume_moments.h"

namespace uwsim {

/// The part of a hull that lies under a level.
struct Displacement {
  double volume_m3 = 0;
  Eigen::Vector3d centroid_world_m = Eigen::Vector3d::Zero();
};

/// What the water does to a hull by its pressure, body frame; the moment about the body's origin.
struct Buoyancy {
  double volume_m3 = 0;  ///< under water; under waves: under the height over the hull
  Eigen::Vector3d centre_body_m = Eigen::Vector3d::Zero();  ///< of that volume
  Eigen::Vector3d force_body_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_body_nm = Eigen::Vector3d::Zero();
};

/// A closed hull under the pressure of the water round it.
///
/// Still water: the weight of the displaced water, the integral of rho(z) g dV, up through its centroid (Archimedes).
/// The volume is a sum of signed tetrahedra over the triangles, each cut at the surface, and rho is linear in layers:
/// exact for any closed mesh, and continuous through the surface. A hull wholly under water and within one layer, or
/// wholly dry, costs no triangle work.
/// Waves: the integral of p over the wetted triangles, each cut where the pressure falls to the atmosphere's, p linear
/// over triangles no longer than a quarter of the hull's radius. A hull wholly under the waves takes the closed form of
/// its second moments instead (relative error about (k r)^4 / 100 for wave number k and radius r); between the two,
/// over one radius of depth, they are mixed smoothly.
class BuoyantHull {
 public:
  /// Throws InvalidValue unless the mesh is closed and winds outward.
  explicit BuoyantHull(TriangleMesh mesh_body);

  const TriangleMesh& mesh_body() const { return mesh_body_; }
  /// Of the whole hull, body frame.
  const SolidProperties& solid() const { return solid_; }
  /// Under the plane z = level_m.
  Displacement displacement(const Pose& world_from_body, double level_m = 0) const;
  /// Height of the water over the hull's middle, under which is what `buoyancy` counts as its volume.
  double level_m(const Pose& world_from_body, const WaterField& water, double time_s) const;
  /// `world_from_body` is the rotation of the body at `position_world_m`.
  Buoyancy buoyancy(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                    const WaterField& water, double time_s) const;

 private:
  struct Placed;

  VolumeMoments moments_below(const Placed& at, double level_m, bool with_second) const;
  Buoyancy resting(const Placed& at, const WaterField& water, double surface_m) const;
  Buoyancy layered(const Placed& at, const WaterField& water, double surface_m, const VolumeMoments& wet) const;
  Buoyancy under_waves(const Placed& at, const WaterField& water, double time_s) const;
  Buoyancy below_waves(const Placed& at, const WaterField& water, double time_s) const;

  TriangleMesh mesh_body_;
  SolidProperties solid_;
  Eigen::Matrix3d second_moment_body_m5_;  // about the centroid
  Eigen::Vector3d middle_body_m_;          // of the bounding sphere
  Eigen::Vector3d half_size_m_;            // of the bounding box
  double radius_m_ = 0;
  CutVolume volume_;  // about the middle
  PressedSurface surface_;
};

}  // namespace uwsim
