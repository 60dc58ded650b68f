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
/// look. A beam adds them up, weighted by its pattern's amplitude. So a ping from the same pose repeats its speckle,
/// and two beams correlate by the autocorrelation of the pattern, of one ping or of several from a turning head. The
/// scatterers' amplitudes change as the array moves by half its length (moving_array.h), and as its z axis tilts by the
/// beam's width about the bearings' plane.
///
/// Bearings are about the sonar's +z; one that turns about it by the twist of its orientation about the vertical keeps
/// its bearings in the world. Not modelled: that scatterers move from bin to bin as the array moves by a bin, where
/// that is less than half of its length.
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

  /// The amplitudes of a beam: all looks of the first bin, then of the next; empty without looks. Valid until the next
  /// call with the same `row`.
  std::span<const Amplitude> of_beam(double bearing_rad, std::vector<Amplitude>& row) const;

 private:
  void fill(std::size_t scatterer, const SimplexNodes<5>& nodes);

  const BeamPattern* pattern_;
  std::size_t cells_;  // bins times looks
  int around_;         // bearings of scatterers in a full turn
  double spacing_rad_, reach_rad_;
  double twist_rad_;
  int first_;                          // of the scatterers' bearings
  ImageBuffer<Amplitude> amplitudes_;  // (bearings, cells)
};

}  // namespace uwsim
