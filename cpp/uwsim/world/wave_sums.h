#pragma once

#include <cstddef>
#include <limits>

namespace uwsim {

/// Eight waves, one array per value; see Waves. Unused slots have zero amplitude.
struct alignas(64) WaveBlock {
  static constexpr std::size_t kLanes = 8;

  double amplitude_m[kLanes] = {};
  double omega_rad_s[kLanes] = {1, 1, 1, 1, 1, 1, 1, 1},
         period_s_rad[kLanes] = {1, 1, 1, 1, 1, 1, 1, 1};  ///< w and 1/w
  double number_rad_m[kLanes] = {1, 1, 1, 1, 1, 1, 1, 1};
  double number_x_rad_m[kLanes] = {}, number_y_rad_m[kLanes] = {}, phase_rad[kLanes] = {};
  double deep[kLanes] = {1, 1, 1, 1, 1, 1, 1, 1};  ///< weight of exp(k z) in cosh(k (z + h)) / cosh(k h)
  double rise_rad_s[kLanes] = {};                  ///< vertical velocity relative to pressure head: w / tanh(k h)
  double along_m_s[kLanes] = {};                   ///< horizontal velocity relative to head times wave number
  double mirror[kLanes] = {};  ///< weight of exp(-k z), due to the waves' reflection at the bed: deep exp(-2 k h)
  /// Upper bound of the wave numbers; infinity: unknown.
  double most_rad_m = std::numeric_limits<double>::infinity();
};

/// The waves of a block at a position and time: amplitude times cosine and sine of the phase.
struct alignas(64) CrestBlock {
  double cosine_m[WaveBlock::kLanes], sine_m[WaveBlock::kLanes];
};

/// Sums over waves at one position and time; see Waves::convective_under.
struct WaveMotionSums {
  double velocity_m_s[3];
  double surface[3];   ///< derivatives of the surface's height with respect to x, y and t
  double gradient[5];  ///< of the velocity: xx, xy, yy, xz, yz
  double local_m_s2[3];
};

/// The surface's height and its two slopes, averaged over an area.
struct WaveSurfaceSums {
  double mean_m, slope_x, slope_y;
};

/// A volume in waves; see Waves::add_flow_over.
struct WavesOnVolume {
  double z_m;      ///< the height at which linear theory is evaluated
  double stretch;  ///< the rate at which that height changes with the height of a point
  double volume_m3;
  double second_m5[3][3];  ///< the volume's second moment about its centroid
};

/// The integrals over a volume of the waves' velocity and of its local rate, and of the arm from the centroid times
/// each of these, all per unit of gravity.
struct WaveIntegrals {
  double velocity[3], turning[3], rate[3], turning_rate[3];
  double rise_gradient[2];  ///< of the derivatives of the rate's vertical component with respect to x and y
};

/// The loops over waves that need a sine or an exponential for each wave, compiled for each instruction set. All
/// versions produce the same bits. `count` is the number of blocks.
struct WaveSumKernels {
  static constexpr double kMostPhase_rad = 1e6;  ///< largest phase that can be reduced to within rounding

  /// Sets the crests and adds up their cosines. Returns false if a phase is too large.
  bool (*crests)(const WaveBlock* waves, std::size_t count, double x_m, double y_m, double time_s, CrestBlock* crests,
                 double& height_m);
  void (*motion)(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, double z_m, WaveMotionSums& sums);
  /// `spread_m2` is the second moment of the area, per unit area, about the position of the crests: xx, xy, yy.
  void (*surface)(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const double* spread_m2,
                  WaveSurfaceSums& sums);
  /// Computes all integrals but `rise_gradient`.
  void (*over)(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const WavesOnVolume& on,
               WaveIntegrals& integrals);
  /// Like `over`; also computes the motion at `on.z_m`, except `local_m_s2`.
  void (*over_with_motion)(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const WavesOnVolume& on,
                           WaveIntegrals& integrals, WaveMotionSums& sums);
  /// Computes all integrals but those of the velocity.
  void (*load)(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const WavesOnVolume& on,
               WaveIntegrals& integrals);
};

const WaveSumKernels& baseline_wave_sum_kernels();
const WaveSumKernels& avx2_wave_sum_kernels();
const WaveSumKernels& avx512_wave_sum_kernels();
/// The kernels for the widest instruction set that this processor supports.
const WaveSumKernels& wave_sum_kernels();

}  // namespace uwsim
