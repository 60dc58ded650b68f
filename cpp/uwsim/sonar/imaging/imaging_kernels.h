#pragma once

#include <cstddef>
#include <cstdint>

namespace uwsim {

/// Limits the extent of a patch, as a multiple of its range.
inline constexpr float kPatchStretch = 1.5f;

/// The arcs (RayArc) of sixteen rays, which may belong to several arcs: the arcs' axes in the world, the angles of
/// their cones, and the extent of their patches across the arc.
struct ArcFrames {
  alignas(64) float ahead[3][16], up[3][16], aside[3][16];
  alignas(64) float cos_aside[16], sin_aside[16], tan_half_width[16];
};

/// Cosines and sines of the angles of sixteen rays, and of both ends of the interval that each represents.
struct ArcAngles {
  const float *cosine, *sine, *lower_cosine, *lower_sine, *upper_cosine, *upper_sine;
};

/// Hits of sixteen rays; normals of any length.
struct ArcHits {
  const float *distance_m, *normal_x, *normal_y, *normal_z;
};

/// The rule by which a patch distributes its echo; see SurfaceEchoes.
struct PatchRule {
  float head_z_m, absorption_db_m, bin_m;
};

/// The patches of sixteen hits: the bins between which their echo is distributed, the cosine of the incidence (0 or
/// less where there is no echo: on the inside of a surface and above the water), and the two-way loss of energy by
/// spreading and absorption, per unit of scattered power and solid angle.
struct ArcPatches {
  float *near_bin, *far_bin, *cosine, *loss;
};

/// Rows of powers by range bin, in blocks of kBlockBins bins: the first block of every row, then the second block of
/// every row. Sums over rows thus read memory in order.
struct ProfileBlocks {
  const float* blocks;  ///< from the first of the rows to be read
  std::size_t rows;     ///< of each block
  std::size_t count;    ///< of blocks
};
inline constexpr std::size_t kBlockBins = 64;

/// The receiver of one beam; see ImagingReceiver.
struct ReceiverLanes {
  double source, noise;  ///< powers re 1 uPa^2
  int looks;
  std::uint64_t key, ping;
  std::uint32_t stream;
  std::uint32_t first_cell, cell_step;  ///< numbers of the cells
};

/// Loops of imaging sonars, compiled for one instruction set. All instruction sets produce the same bits.
struct ImagingKernels {
  /// Computes the directions of sixteen rays.
  void (*directions)(const ArcFrames& arcs, const ArcAngles& angles, float* x, float* y, float* z);
  /// Computes the patches of sixteen hits.
  void (*patches)(const ArcFrames& arcs, const ArcAngles& angles, const ArcHits& hits, const PatchRule& rule,
                  const ArcPatches& patches);
  /// Adds up to sixteen echoes to a profile, in their order. Each is spread evenly over an interval of bins; those
  /// without power, and those beyond the last bin, are skipped.
  void (*spread)(const double* power, const double* near_bin, const double* far_bin, std::size_t count,
                 std::size_t bins, double* profile);
  /// Stores a row of powers in the layout that sum_beams reads, see ProfileBlocks; the last block is filled with zeros.
  void (*store_row)(const double* row, std::size_t bins, std::size_t rows, float* blocks);
  /// Computes weighted sums of `count` rows, for up to four beams at once: sums[b][bin] is the sum of weights[3 step +
  /// k] times row b step + k, in the order of k. The weights are preceded and followed by 3 step zeros. `sums` has four
  /// rows of whole blocks. Sums are computed in float: they round to less than 1e-4 dB, and powers below 1e-38 vanish.
  void (*sum_beams)(const ProfileBlocks& profiles, const float* weights, std::size_t count, std::size_t step,
                    std::size_t beams, double* sums);
  /// Computes the weighted sum of several complex noises. The noise of cell k is a function of its key + k
  /// (hashed_noise.h).
  void (*noise)(const std::uint32_t* keys, const float* weights, std::size_t noises, std::size_t cells, float* row);
  /// Computes the weighted sum of `rows` successive rows of `count` values.
  void (*sum_rows)(const float* from, const float* weights, std::size_t rows, std::size_t count, float* sum);
  /// Converts the mean echo powers of a beam's bins to received powers and to levels, which include `gain_db`.
  /// `speckle`: complex, all looks of the first bin, then those of the next. The receiver's noise is drawn as in
  /// core/random.h, but in float: in every whole 32 bins, bins k and k + 16 share the words of the counter of bin k,
  /// and the logarithm is a series; levels are within 2e-5 dB of a computation in double.
  void (*receive)(const ReceiverLanes& receiver, const double* echo, const float* speckle, const float* gain_db,
                  std::size_t bins, double* received, float* level_db);
};

const ImagingKernels& baseline_imaging_kernels();
const ImagingKernels& avx2_imaging_kernels();
const ImagingKernels& avx512_imaging_kernels();
/// The kernels for the widest instruction set that this processor supports.
const ImagingKernels& imaging_kernels();

}  // namespace uwsim
