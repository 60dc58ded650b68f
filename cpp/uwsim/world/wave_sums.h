#pragma once

#include <cstddef>

namespace uwsim {

/// Sums over waves at one position and time; see Waves::motion_under.
struct WaveMotionSums {
  double velocity_m_s[3], local_m_s2[3];
  double surface[3];   ///< derivatives of the surface's height with respect to x, y and t
  double gradient[5];  ///< of the velocity: xx, xy, yy, xz, yz
};

/// A volume in waves; see Waves::add_flow_over.
struct WavesOnVolume {
  double z_m, depth_m;  ///< the height at which linear theory is evaluated, and the water's depth
  double volume_m3;
  double second_m5[3][3];  ///< the volume's second moment about its centroid
};

/// The integrals over a volume of the waves' velocity and of its local rate, and of the arm from the centroid times
/// each of these, all per unit of gravity.
struct WaveIntegrals {
  double velocity[3], turning[3], rate[3], turning_rate[3];
};

/// The loops over waves that need a sine or an exponential for each wave, compiled for each instruction set. All
/// versions produce the same bits. Waves are rows of eight values: amplitude, angular frequency, wave number, its x and
/// y components, phase, `deep` and `shallow` (see Waves). Crests are pairs, the amplitude times the cosine and sine of
/// the phase, with room for blocks of eight.
struct WaveSumKernels {
  static constexpr std::size_t kNumbers = 8;
  static constexpr double kMostPhase_rad = 1e6;  ///< largest phase that can be reduced to within rounding

  /// Sets the crests, zero in unused slots of the last block, and adds up the cosines. Returns false if a phase is too
  /// large.
  bool (*crests)(const double* waves, std::size_t count, double x_m, double y_m, double time_s, double* crests,
                 double& height_m);
  void (*motion)(const double* waves, std::size_t count, const double* crests, double z_m, double depth_m,
                 WaveMotionSums& sums);
  void (*over)(const double* waves, std::size_t count, const double* crests, const WavesOnVolume& on,
               WaveIntegrals& integrals);
};

const WaveSumKernels& baseline_wave_sum_kernels();
const WaveSumKernels& avx2_wave_sum_kernels();
const WaveSumKernels& avx512_wave_sum_kernels();
/// The kernels for the widest instruction set that this processor supports.
const WaveSumKernels& wave_sum_kernels();

}  // namespace uwsim
