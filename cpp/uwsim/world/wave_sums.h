#pragma once

#include <cstddef>

namespace uwsim {

/// Sums over waves at a place and a time: see Waves::motion_under.
struct WaveMotionSums {
  double velocity_m_s[3], local_m_s2[3];
  double surface[3];   ///< the surface's height by x, y and t
  double gradient[5];  ///< of the velocity: xx, xy, yy, xz, yz
};

/// The sums that the load of waves on a volume depends on: see Waves::load.
struct WavesOnVolume {
  double z_m, depth_m;  ///< where linear theory is evaluated, and the water's depth
  double volume_m3;
  double second_m5[3][3];  ///< the volume's second moment about its centroid
};

/// The loops over waves with a sine or an exponential for each, compiled for each instruction set. All give the same
/// bits. Waves are rows of eight numbers: amplitude, angular frequency, wave number, its x and y, phase, `deep` and
/// `shallow` (see Waves). Crests are pairs, amplitude times cosine and sine of the phase, with room for blocks of
/// eight.
struct WaveSumKernels {
  static constexpr std::size_t kNumbers = 8;
  static constexpr double kMostPhase_rad = 1e6;  ///< largest phase that is reduced to within rounding

  /// Sets the crests, zero in unused places of the last block, and adds up the cosines. Returns false if a phase is too
  /// large.
  bool (*crests)(const double* waves, std::size_t count, double x_m, double y_m, double time_s, double* crests,
                 double& height_m);
  void (*motion)(const double* waves, std::size_t count, const double* crests, double z_m, double depth_m,
                 WaveMotionSums& sums);
  /// Per unit of gravity: force and moment, x y z each.
  void (*load)(const double* waves, std::size_t count, const double* crests, const WavesOnVolume& on, double* force,
               double* moment);
};

const WaveSumKernels& baseline_wave_sum_kernels();
const WaveSumKernels& avx2_wave_sum_kernels();
const WaveSumKernels& avx512_wave_sum_kernels();
/// The kernels for the widest instruction set of this processor.
const WaveSumKernels& wave_sum_kernels();

}  // namespace uwsim
