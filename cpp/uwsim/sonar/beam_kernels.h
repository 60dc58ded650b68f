#pragma once

#include <cstddef>
#include <cstdint>

namespace uwsim {

/// Sixteen beams' hits, as pointers to sixteen numbers each.
struct BeamHits {
  const double *distance_m, *normal_x, *normal_y, *normal_z;
  const double *direction_x, *direction_y, *direction_z;
  const std::uint32_t* label;
};

/// What counts as an echo, and how strong it is.
struct EchoRule {
  double head_z_m;
  double range_max_m;      ///< at or past it is none; nothing is heard at all where this is 0
  double strength_db;      ///< of the bottom, at right angles
  double absorption_db_m;  ///< one way
};

/// Sixteen beams' results.
struct BeamEchoes {
  float *range_m, *incidence_rad, *intensity_db;
  std::uint16_t* label;
  std::uint8_t* valid;
};

/// The loops over sixteen beams, compiled for one width of vector unit. All widths give the same bits.
struct BeamKernels {
  /// Beams' directions in the world: mixtures of the head's x and y axes (3,), by (16,) cosines and sines.
  void (*directions)(const double* x_axis, const double* y_axis, const double* ahead, const double* aside,
                     double* direction_x, double* direction_y, double* direction_z);
  /// How far rays from a head at z <= 0 are worth following: to the range's end, or to the surface.
  void (*reach)(double head_z_m, double range_max_m, const double* direction_z, double* far_m);
  /// Turns hits into echoes: those under water and within range count. Logarithm and arc tangent are series in float,
  /// within 1e-6 of the true value (of the logarithm's size; radian), so that compilers vectorise the loop.
  void (*echoes)(const BeamHits& hits, const EchoRule& rule, const BeamEchoes& echoes);
  /// Where the echoes are in the sonar frame, (16, 3); NaN where the range is infinite.
  void (*points)(const double* distance_m, const double* ahead, const double* aside, const float* range_m,
                 float* points_sonar_m);
};

const BeamKernels& baseline_beam_kernels();
const BeamKernels& avx2_beam_kernels();
const BeamKernels& avx512_beam_kernels();
/// The widest of these that this processor runs.
const BeamKernels& beam_kernels();

}  // namespace uwsim
