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

/// Hits of sixteen rays in float, as pointers to sixteen values each; normals of any length.
struct FloatHits {
  const float *normal_x, *normal_y, *normal_z;
  const float *direction_x, *direction_y, *direction_z;
};

/// The patches that sixteen rays cover; see AcousticMultibeam.
struct RayPatches {
  const float *length_m, *cosine;     ///< of the path, and of the incidence
  const float* gain;                  ///< share of the source's intensity that is scattered back at 1 m
  const float* lost;                  ///< factor by absorption, there and back
  const float *spacing_rad, *relief;  ///< angle between neighbouring rays; height of relief per metre of range
  float cell_m;
};

/// The fields of RayEcho for sixteen rays.
struct PatchEchoes {
  float *energy, *width_m, *point_m2;
};

/// Cells of noise under a footprint, four along each of two axes, as hash keys and weights, and the keys of four
/// independent fields of noise; see SpeckleField. Pointers to four values each.
struct NoiseCells {
  const std::uint32_t* row_keys;
  const float* row_weights;
  const std::uint32_t* column_keys;
  const float* column_weights;
  const std::uint32_t* field_keys;
};

/// Sixteen consecutive samples of a beam's water column; see AcousticMultibeam::record_water_column.
struct ColumnSamples {
  const float* echoes;    ///< power of the echoes in each sample, as a ratio of the source's intensity (16,)
  float noise;            ///< of the receiver, in each sample
  float system_ratio;     ///< of a lossless echo to the noise of an unsteered beam
  float first_m, step_m;  ///< range of the first sample's middle; from one sample to the next
  float water_m;          ///< range at which the beam leaves the water
  float volume;           ///< the water's echo at 1 m without losses; 0 if it returns none
  float lost;             ///< factor by absorption, there and back, half-way between the eighth sample and the ninth
  float rate;             ///< its logarithm, from one sample to the next; at most 0.04
  std::uint32_t key, second_key;  ///< of the beam's speckle
  std::uint32_t index;            ///< of the first sample
  std::uint32_t cells;            ///< range cells in a sample
  float level_db;                 ///< added to the result
};

/// Loops over sixteen beams or cells, compiled for one instruction set. All instruction sets produce the same bits.
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
  /// Computes the cosine of each ray's incidence.
  void (*incidence)(const FloatHits& hits, float* cosine);
  /// Computes the energy of each ray's echo and its extent in range.
  void (*patches)(const RayPatches& patches, const PatchEchoes& echoes);
  /// Computes, for each of the four fields, the sums over all pairs of a row and a column of the product of their
  /// weights and two independent noises (hashed_noise.h), `one` and `two` (4,).
  void (*noise)(const NoiseCells& cells, float* one, float* two);
  /// Computes levels (16,) of a water column, with speckle. The logarithm is that of `echoes`; levels are accurate to
  /// 1e-4 dB.
  void (*column)(const ColumnSamples& samples, float* level_db);
};

const BeamKernels& baseline_beam_kernels();
const BeamKernels& avx2_beam_kernels();
const BeamKernels& avx512_beam_kernels();
/// The kernels for the widest instruction set that this processor supports.
const BeamKernels& beam_kernels();

}  // namespace uwsim
