#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/image_buffer.h"
#include "uwsim/core/pose.h"
#include "uwsim/core/random.h"
#include "uwsim/sonar/imaging/beam_pattern.h"
#include "uwsim/sonar/imaging/imaging_acoustics.h"
#include "uwsim/sonar/simplex_nodes.h"

namespace uwsim {

/// Speckle of an imaging sonar at a pose: a complex amplitude for each beam, range bin and look, with unit mean power.
///
/// Scatterers lie at bearings that are fixed in the world, with independent complex Gaussian amplitudes in each bin and
/// look. A beam sums these amplitudes, weighted by its pattern. A ping from the same pose therefore repeats its
/// speckle, and the correlation of two beams, of one ping or of several pings from a turning head, is the
/// autocorrelation of the pattern. The scatterers' amplitudes change as the array moves by half its length
/// (moving_array.h), and as its z axis tilts by the beam's width out of the bearings' plane.
///
/// Bearings are measured about the sonar's +z and corrected for the twist of its orientation about the vertical, so
/// that they are fixed in the world. Not modelled: scatterers that pass from bin to bin as the array moves, where a bin
/// is shorter than half of the array.
class FanSpeckle {
 public:
  using Amplitude = std::complex<float>;

  /// The sonar's resolution. The array's length follows from the pattern.
  struct Beam {
    const BeamPattern& pattern;  ///< by bearing
    double tilt_width_rad;       ///< out of the bearings' plane
  };

  /// For beams at bearings from `low_rad` to `high_rad`.
  FanSpeckle(const Beam& beam, const ImagingAcoustics& acoustics, const RandomStream& random,
             const Pose& world_from_sonar, double low_rad, double high_rad, int threads = 1);

  /// The amplitudes of a beam: all looks of the first bin, then those of the next; empty without looks. Valid until the
  /// next call with the same `row`.
  std::span<const Amplitude> of_beam(double bearing_rad, std::vector<Amplitude>& row) const;

 private:
  void fill(std::size_t scatterer, const SimplexNodes<5>& nodes);

  const BeamPattern* pattern_;
  std::size_t cells_;  // bins times looks
  int around_;         // number of scatterers' bearings in a full turn
  double spacing_rad_, reach_rad_;
  double twist_rad_;
  int first_;                          // index of the first of the scatterers' bearings
  ImageBuffer<Amplitude> amplitudes_;  // (bearings, cells)
};

}  // namespace uwsim
