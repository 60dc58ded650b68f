#pragma once

#include <cstddef>
#include <cstdint>

namespace uwsim {

/// Hits of sixteen beams, as pointers to sixteen values each.
struct BeamHits {
  const double *distance_m, *normal_x, *normal_y, *normal_z;
  const double *direction_x, *direction_y, *direction_z;
  const std::uint32_t* label;
  const float* strength_db;  ///< backscatter of the surface that was hit, at normal incidence
};

/// Which hits count as echoes, and their level.
struct EchoRule {
  double head_z_m;
  double range_max_m;      ///< hits at or beyond this do not count as echoes; 0 discards all
  double absorption_db_m;  ///< one way
};

/// Results of sixteen beams.
struct BeamEchoes {
  float *range_m, *incidence_rad, *intensity_db;
  std::uint16_t* label;
  std::uint8_t* valid;
};

/// Loops over sixteen beams, compiled for one instruction set. All instruction sets produce the same bits.
struct BeamKernels {
  /// Computes the beams' directions in the world from the head's x and y axes (3,) and the cosines and sines of the
  /// beam angles (16,).
  void (*directions)(const double* x_axis, const double* y_axis, const double* cosine, const double* sine,
                     double* direction_x, double* direction_y, double* direction_z);
  /// Computes the distances at which rays from a head at z <= 0 end: the maximum range, or the surface if it is nearer.
  void (*reach)(double head_z_m, double range_max_m, const double* direction_z, double* far_m);
  /// Converts underwater hits within range to echoes. Logarithm and arc tangent are float series that are accurate to
  /// 1e-6 (relative for the logarithm, in radians for the angle), so that compilers can vectorise the loop.
  void (*echoes)(const BeamHits& hits, const EchoRule& rule, const BeamEchoes& echoes);
  /// Computes the positions of the echoes in the sonar frame, (16, 3); NaN where the range is infinite.
  void (*points)(const double* distance_m, const double* cosine, const double* sine, const float* range_m,
                 float* points_sonar_m);
};

const BeamKernels& baseline_beam_kernels();
const BeamKernels& avx2_beam_kernels();
const BeamKernels& avx512_beam_kernels();
/// The kernels for the widest instruction set that this processor supports.
const BeamKernels& beam_kernels();

}  // namespace uwsim
