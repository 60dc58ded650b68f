#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "uwsim/core/pose.h"
#include "uwsim/sonar/echo.h"

namespace uwsim {

/// Where the rays of an echo hit surfaces, in the fan's frame relative to the head.
struct EchoFootprint {
  Eigen::Vector3f middle_m;
  Eigen::Vector3f deviation_m;  ///< standard deviations
};

/// `directions`: (3, rays) of the beam, in the fan's frame.
EchoFootprint echo_footprint(std::span<const RayEcho> rays, const Eigen::Ref<const Eigen::Matrix3Xf>& directions);

/// Speckle from scatterers that are fixed in the world: a beam averages white noise over its footprint. Overlapping
/// beams share scatterers: for equal Gaussian footprints whose middles are d apart, the correlation of intensities is
/// exp(-d^2 / (4 sigma^2)), the square of their amplitudes' overlap, as speckle does (Goodman 2007, "Speckle Phenomena
/// in Optics", ch. 3). A ping from the same place hits the same scatterers.
///
/// The noise is hashed by cells of square lattices, whose sizes are the powers of two. Each footprint is covered by
/// linear B-splines on the two next sizes, along the fan's plane and across it, mixed so that the correlation has the
/// footprint's extent. Lattices are aligned with the fan to within 4 degrees and fixed in the world for headings that
/// round to the same value; from others the scatterers appear with random phases, as they do in water.
///
/// Not modelled: the change of speckle with the direction from which the same footprint is seen.
class SpeckleField {
 public:
  /// A key for each size of cells, 2^level, at level modulo 64.
  using LevelKeys = std::array<std::uint32_t, 64>;

  /// Different frequencies have different speckle.
  SpeckleField(std::uint64_t seed, double frequency_hz);

  /// The field for one ping; valid as long as the field.
  class View {
   public:
    /// Two independent standard normal draws for a footprint.
    std::array<double, 2> draws(const EchoFootprint& footprint) const;

   private:
    friend SpeckleField;
    const SpeckleField* field_;
    std::uint32_t key_;
    Eigen::Vector3d head_m_;  // in the lattices' frame
    Eigen::Matrix3d lattice_from_sonar_;
  };
  View view(const Pose& world_from_sonar) const;

 private:
  std::uint64_t key_;
  LevelKeys across_, within_;
};

}  // namespace uwsim
