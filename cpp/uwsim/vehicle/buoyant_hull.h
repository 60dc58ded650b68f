#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/triangle_mesh.h"
#include "uwsim/core/volume_parts.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/volume_moments.h"
#include "uwsim/vehicle/wet_surface.h"

namespace uwsim {

/// The part of a hull under a horizontal plane.
struct Displacement {
  double volume_m3 = 0;
  Eigen::Vector3d centroid_world_m = Eigen::Vector3d::Zero();
};

/// The force of the water's pressure on a hull, body frame; the moment is about the body's origin.
struct Buoyancy {
  double volume_m3 = 0;                                     ///< submerged volume
  Eigen::Vector3d centre_body_m = Eigen::Vector3d::Zero();  ///< of the submerged volume
  Eigen::Vector3d force_body_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_body_nm = Eigen::Vector3d::Zero();
  VolumeFlow flow;  ///< over the whole hull, moved so that its centroid is at centre_body_m
};

/// The water around a hull in a step, found at the first place and time for which it is needed: that at the others
/// follows to first order.
struct NearbyWater {
  std::optional<NearbyFlow> flow;
  std::size_t division = 0;                     ///< into the slices of `cuts`
  std::array<std::optional<PlaneCut>, 8> cuts;  ///< of slices by the surface of waves
};

/// Returns true if parts of the water around a hull need to be found only once in a step.
inline bool is_kept_in_a_step(const WaterField& water) { return water.flows_smoothly() || !water.surface_is_flat(); }

/// A closed hull under the pressure of the surrounding water: buoyancy and wave excitation (Froude-Krylov).
///
/// Still water: the weight of the displaced water, the integral of rho(z) g dV, acts upward through its centroid
/// (Archimedes). The volume is a sum of signed tetrahedra over the triangles, each cut at the surface, and rho is
/// piecewise linear in depth. The result is exact for any closed mesh, and continuous through the surface. A hull that
/// is fully submerged in one layer, or completely dry, requires no work on triangles.
///
/// Waves: the integral of -grad p over the wet volume, which equals the integral of the pressure p over the wetted
/// surface, since p is 0 at the water's surface (Gauss). When the hull first meets waves, it is cut along its longest
/// side into slices that are short compared with the waves (WaterField::division_of). Each slice is cut by the plane
/// that has the mean height and slopes of the surface over it. To first order in the waves' steepness, the error is
/// that of approximating the surface by planes: 1 % of a wave's load if slices are a quarter of the wave's length. For
/// a hull deep enough below the waves, force and moment follow from the acceleration of the displaced water instead
/// (VolumeFlow), which includes the second-order part of the pressure. The two are blended smoothly over one radius of
/// depth. In a step, each slice is cut once, and followed to first order (PlaneCut) while its plane remains near.
class BuoyantHull {
 public:
  /// Throws InvalidValue unless the mesh is closed and winds outward. `division`: that of all waves, an index of
  /// VolumeParts::slices; by default the one that they require.
  explicit BuoyantHull(TriangleMesh mesh_body, std::optional<std::size_t> division = std::nullopt);

  const TriangleMesh& mesh_body() const { return mesh_body_; }
  std::optional<std::size_t> division() const { return division_; }
  /// Volume, centroid and inertia of the whole hull, body frame.
  const SolidProperties& solid() const { return solid_; }
  /// The part below the plane z = level_m.
  Displacement displacement(const Pose& world_from_body, double level_m = 0) const;
  /// The volume that `buoyancy` treats as submerged [m^3].
  double submerged_volume_m3(const Pose& world_from_body, const WaterField& water, double time_s) const;
  /// The triangles that are under water: the hull's own, cut by the planes by which `buoyancy` cuts its volume.
  WetSurface wet_surface(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                         const WaterField& water, double time_s) const;
  /// `world_from_body` is the rotation of the body located at `position_world_m`.
  /// `nearby`: where to keep what other poses in the same step need; may be null.
  Buoyancy buoyancy(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                    const WaterField& water, double time_s, NearbyWater* nearby = nullptr) const;

 private:
  struct Placed;
  struct Cut;
  struct DisplacedMass;

  /// A part of the hull between two planes at right angles to its longest side. `volume` is relative to the middle of
  /// its bounding box.
  struct Slice {
    Eigen::Vector3d middle_body_m = Eigen::Vector3d::Zero(), half_size_m = Eigen::Vector3d::Zero();
    double radius_m = 0;
    CutVolume volume;

    Slice() = default;
    Slice(TriangleMesh mesh, double pitch);
  };

  /// As in VolumeParts, for waves.
  struct Slices {
    std::once_flag are_cut;
    VolumeParts parts;
    std::array<std::vector<Slice>, 4> divisions;
  };

  Buoyancy in_still_water(const Placed& at, const WaterField& water, double surface_m) const;
  Buoyancy below_flat_surface(const Placed& at, const WaterField& water, double time_s, NearbyWater* nearby) const;
  std::optional<DisplacedMass> mass_across_bends(const Placed& at, const WaterField& water,
                                                 const DensityLayer& top) const;
  DisplacedMass mass_in_layers(const Cut& at, const WaterField& water, double surface_m,
                               const VolumeMoments& wet) const;
  WaterSurface surface_over(const Placed& at, const Slice& slice, const VolumePart& part, const WaterField& water,
                            double time_s) const;
  std::vector<WaterPlane> water_planes(const Placed& at, const WaterField& water, double time_s) const;
  template <typename Visit>
  void visit_wet_slices(const Placed& at, const WaterField& water, double time_s, const WaterSurface& over_hull,
                        NearbyWater* nearby, const Visit& visit) const;
  Buoyancy through_waves(const Placed& at, const WaterField& water, double time_s, const WaterSurface& over_hull,
                         NearbyWater* nearby) const;
  Buoyancy below_waves(const Placed& at, const WaterField& water, double time_s, const VolumeFlow& flow) const;
  VolumeFlow flow_at(const Placed& at, const Eigen::Vector3d& centre_body_m, const WaterField& water, double time_s,
                     NearbyWater* nearby) const;
  /// The hull's slices for waves; the first call cuts them.
  const Slices& in_slices() const;
  void cut_into_slices(Slices& slices) const;

  TriangleMesh mesh_body_;
  std::optional<std::size_t> division_;
  SolidProperties solid_;
  VolumeParts parts_;  // without slices; for a flat surface
  Slice whole_;
  std::shared_ptr<Slices> slices_;
};

}  // namespace uwsim
