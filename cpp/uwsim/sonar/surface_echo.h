#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "uwsim/sonar/imaging_acoustics.h"
#include "uwsim/world/ray_scene.h"

namespace uwsim {

/// Rays from a head in one plane, or on the cone `aside_rad` off it:
/// direction(angle) = cos(aside) (cos(angle) ahead + sin(angle) up) + sin(aside) aside.
struct RayArc {
  Eigen::Vector3d ahead_world;
  Eigen::Vector3d up_world;
  Eigen::Vector3d aside_world;  ///< ahead, aside and up: unit vectors at right angles
  double aside_rad = 0;
  double half_width_rad = 0;  ///< half the angle to the neighbouring arcs, for what a ray stands for across the arc

  Eigen::Vector3d direction(double angle_rad) const;
};

/// A ray of an arc and what it stands for: the angles from lower to upper.
struct ArcRay {
  double angle_rad, lower_rad, upper_rad;
  double gain_sr;  ///< the beam's two-way power pattern there times the solid angle that the ray stands for
};

/// Rays at these angles, which must rise; each reaches half way to its neighbours. gain_sr is left at 1.
std::vector<ArcRay> arc_rays(std::span<const double> angles_rad);

/// Echoes of surfaces along a head's rays, as mean power by range.
///
/// A ray of solid angle dO that meets a surface at range R under incidence i covers dA = R^2 dO / cos i. By Lambert's
/// law (Urick 1983, "Principles of Underwater Sound", ch. 8) that patch returns, over the source's power at 1 m,
///   R^-4 10^(-2 alpha R / 10) mu cos^2 i dA = mu cos i dO R^-2 10^(-2 alpha R / 10),
/// spread evenly over the ranges that the patch takes up on the surface's plane there. Shadows need no model: what is
/// hidden gets no ray. Straight rays, one bounce. There is no echo from above z = 0 (nor to a head there), and none
/// from a surface's inner side: a head within the ground or a solid hears nothing.
class SurfaceEchoes {
 public:
  SurfaceEchoes(const RayScene& scene, const Eigen::Vector3d& head_world_m, const ImagingAcoustics& acoustics,
                double absorption_db_m);

  /// Adds an arc's echoes to `profile`, a power a range bin.
  void add(const RayArc& arc, std::span<const ArcRay> rays, std::span<double> profile) const;

 private:
  void add_patch(const RayArc& arc, const ArcRay& patch, const Ray& ray, const RayHit& hit,
                 std::span<double> profile) const;

  const RayScene* scene_;
  Eigen::Vector3d head_world_m_;
  double range_max_m_, bin_m_;
  double absorption_db_m_;
  double solid_;                   // of labels past the last of strengths_
  std::vector<double> strengths_;  // Lambert's mu by label
};

}  // namespace uwsim
