#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "uwsim/rays/ray_scene.h"
#include "uwsim/sonar/imaging/imaging_acoustics.h"
#include "uwsim/sonar/rippled_bed.h"
#include "uwsim/sonar/scatter_curve.h"

namespace uwsim {

/// A fan of rays from a head. The rays lie in a plane or, if `aside_rad` is not 0, on a cone at that angle to the
/// plane: direction(angle) = cos(aside) (cos(angle) ahead + sin(angle) up) + sin(aside) aside.
struct RayArc {
  Eigen::Vector3d ahead_world;
  Eigen::Vector3d up_world;
  Eigen::Vector3d aside_world;  ///< ahead, aside and up are orthogonal unit vectors
  double aside_rad = 0;
  double half_width_rad = 0;  ///< half the angle to the neighbouring arcs; a ray's patch extends this far across

  Eigen::Vector3d direction(double angle_rad) const;
};

/// The cosine and sine of an angle.
struct ArcTurn {
  float cosine, sine;

  ArcTurn(double angle_rad)  // NOLINT(google-explicit-constructor): another form of the angle
      : cosine(static_cast<float>(std::cos(angle_rad))), sine(static_cast<float>(std::sin(angle_rad))) {}
};

/// A ray of an arc and the interval of angles that it represents.
struct ArcRay {
  double angle_rad, lower_rad, upper_rad;
  double gain_sr;                ///< the beam's two-way power pattern times the solid angle that the ray represents
  ArcTurn middle, lower, upper;  ///< of the three angles
};

/// Rays at ascending angles; each represents the interval to the midpoints between it and its neighbours. gain_sr is 1.
std::vector<ArcRay> arc_rays(std::span<const double> angles_rad);

/// The rays of neighbouring arcs. There are one or several sets, all of the same size; successive arcs take turns in
/// them.
class ArcRaySets {
 public:
  /// The number of sets must divide SurfaceEchoes::kArcsTogether.
  explicit ArcRaySets(std::vector<std::vector<ArcRay>> sets);

  std::span<const ArcRay> of_arc(std::size_t arc) const { return sets_[arc % sets_.size()]; }
  std::size_t rays() const { return sets_.front().size(); }
  /// The cosines and sines of the rays' angles from ray `first` on, in the order of ArcTurn and of ArcRay; beyond the
  /// last ray, it is repeated up to a packet's size.
  const float* turns(std::size_t arc, std::size_t row, std::size_t first) const {
    return turns_.data() + (arc % sets_.size() * kRows + row) * stride_ + first;
  }
  static constexpr std::size_t kRows = 6;

 private:
  std::vector<std::vector<ArcRay>> sets_;
  std::size_t stride_;
  std::vector<float> turns_;
};

/// Mean echo power by range, separately for each surface. Used to label the cells of a picture.
class EchoesByLabel {
 public:
  explicit EchoesByLabel(std::size_t bins) : bins_(bins) {}

  /// The profile of a surface, initially zero.
  std::span<double> of(Label label);
  /// Adds the echoes of another object, multiplied by a weight.
  void add(double weight, const EchoesByLabel& other);
  /// The surface with the strongest echo in a bin; kNothing if none exceeds `least`.
  Label strongest(std::size_t bin, double least) const;

 private:
  struct Surface {
    Label label;
    std::vector<double> profile;
  };
  std::size_t bins_;
  std::vector<Surface> surfaces_;  // few: only the surfaces that the rays of one arc or beam hit
};

/// Echoes of surfaces along rays from a head, as mean power by range.
///
/// A ray of solid angle dO that hits a surface at range R and incidence i covers dA = R^2 dO / cos i. By Lambert's law
/// (Urick 1983, "Principles of Underwater Sound", ch. 8), this patch returns, relative to the source's power at 1 m,
///   R^-4 10^(-2 alpha R / 10) mu cos^2 i dA = mu cos i dO R^-2 10^(-2 alpha R / 10),
/// spread evenly over the ranges that the patch covers on the surface's tangent plane. Shadows need no separate model,
/// since no ray hits a hidden surface. Rays are cast in float, with errors of 1e-4 m (ray_scene.h). A seabed's
/// backscatter by angle replaces mu cos^2 i where a material has one; over ripples of sand, it is the mean of those at
/// the facets of a patch (RippledBed). Rays are straight and reflected once, unless
/// multipath is on (surface_ghosts.cpp). Surfaces above z = 0 return no echo, and a head above z = 0 receives none. The
/// inside of a surface returns no echo either, so a head in the ground or in a solid receives only noise.
class SurfaceEchoes {
 public:
  /// Keeps references to `scene` and `acoustics`.
  SurfaceEchoes(const RayScene& scene, const Eigen::Vector3d& head_world_m, const ImagingAcoustics& acoustics,
                double absorption_db_m);

  /// Adds the echoes of an arc to `profile`, one power per range bin, and to `by_label` unless it is null.
  void add(const RayArc& arc, std::span<const ArcRay> rays, std::span<double> profile,
           EchoesByLabel* by_label = nullptr) const;
  /// The same for neighbouring arcs: `profiles` has a row for each arc, and `by_label` has an entry for each arc or is
  /// empty. Eight arcs share packets, which Embree traverses faster than packets of a single arc.
  void add(std::span<const RayArc> arcs, const ArcRaySets& rays, std::span<double> profiles,
           std::span<EchoesByLabel> by_label) const;

  /// The number of arcs that share packets; see above.
  static constexpr std::size_t kArcsTogether = 8;

 private:
  template <std::size_t kArcs>
  void add_packets(std::span<const RayArc> arcs, const ArcRaySets& rays, std::span<double> profiles,
                   std::span<EchoesByLabel> by_label) const;
  void add_ghosts(const RayArc& arc, std::span<const ArcRay> rays, std::span<double> profile) const;
  /// The backscattering cross-section per unit area.
  double scattered(Label label, double cosine) const;
  /// The same per unit area across the ray.
  double reflected(Label label, double cosine) const;
  /// Distributes power evenly over an interval of bins.
  static void spread(double power, double near_bin, double far_bin, std::span<double> profile);

  const RayScene* scene_;
  Eigen::Vector3d head_world_m_;
  double range_max_m_, bin_m_;
  double absorption_db_m_;
  double solid_;                   // the Lambert coefficient mu for labels that strengths_ does not cover
  std::vector<double> strengths_;  // the Lambert coefficient mu by label
  const ImagingAcoustics* acoustics_;
  std::vector<ScatterCurve> curves_;   // by label; empty if no material has a seabed
  std::optional<RippledBed> ripples_;  // of the terrain
};

}  // namespace uwsim
