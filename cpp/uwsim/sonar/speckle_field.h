#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "uwsim/acoustics/sonar_equation.h"
#include "uwsim/core/pose.h"
#include "uwsim/sonar/echo.h"
#include "uwsim/sonar/simplex_nodes.h"

namespace uwsim {

/// The region where the rays of an echo hit surfaces, in the fan's frame, relative to the head.
struct EchoFootprint {
  Eigen::Vector3f middle_m;
  Eigen::Vector3f deviation_m;  ///< standard deviations
};

/// `directions`: (3, rays) of the beam, in the fan's frame.
EchoFootprint echo_footprint(std::span<const RayEcho> rays, const Eigen::Ref<const Eigen::Matrix3Xf>& directions);

/// Speckle from scatterers that are fixed in the world: a beam averages white noise over its footprint. Overlapping
/// beams share scatterers. For equal Gaussian footprints whose centres are d apart, the correlation of intensities is
/// exp(-d^2 / (4 sigma^2)), the square of their amplitudes' overlap, as for real speckle (Goodman 2007, "Speckle
/// Phenomena in Optics", ch. 3). Pings from the same place hit the same scatterers.
///
/// The whole field changes as the head moves (moving_array.h): along the fan's plane by half the receiver's length,
/// across it by half the transmitter's. Motion along the beams counts as motion by the longer of the two (assumed).
///
/// The noise is hashed by cells of square lattices whose sizes are powers of two. Each footprint is covered by linear
/// B-splines on the two nearest sizes, along the fan's plane and across it, mixed so that the correlation has the
/// footprint's extent. Lattices are aligned with the fan to within 4 degrees and are fixed in the world for headings
/// that round to the same value; from other headings, the scatterers have independent random phases, as in real water.
class SpeckleField {
 public:
  /// One key per cell size 2^level, at index level modulo 64.
  using LevelKeys = std::array<std::uint32_t, 64>;

  /// Different frequencies have different speckle.
  SpeckleField(std::uint64_t seed, const SonarParameters& parameters);

  /// The field as seen by one ping; valid during the lifetime of the field.
  class View {
   public:
    /// Two independent standard normal draws for a footprint.
    std::array<double, 2> draws(const EchoFootprint& footprint) const;

   private:
    friend SpeckleField;
    const SpeckleField* field_;
    SimplexNodes<3> nodes_;   // at the head's position
    Eigen::Vector3d head_m_;  // in the lattices' frame
    Eigen::Matrix3d lattice_from_sonar_;
  };
  View view(const Pose& world_from_sonar) const;

 private:
  std::uint64_t key_;
  LevelKeys across_, within_;
  Eigen::Vector3d nodes_m_;  // units of the head's position, along the lattices' axes
};

}  // namespace uwsim
