#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/camera/caustics.h"
#include "uwsim/camera/kernels/view.h"

namespace uwsim {

/// The length [m] of the waves that carry most of a wind's energy after it has blown over `fetch_m` of water: their
/// frequency is 3.5 (g / U) (g F / U^2)^-0.33, at least the 0.13 g / U of a sea that grows no more (Hasselmann et al.
/// 1973, JONSWAP; Pierson and Moskowitz 1964), in deep water.
double longest_wind_wave_m(double wind_m_s, double fetch_m);

/// The small waves of a breeze, which are too short to move a vehicle and only bend light. A square tile of waves that
/// repeats every kTile_m, drawn from a seed; each wave propagates by omega^2 = g k + (0.074 N/m / rho) k^3. Slope
/// variance is equal in each octave of wave number (the saturated range, Phillips 1958), with cos^2 spreading about the
/// wind and lengths from kTile_m down to 0.32 m. The slopes' variance is half of 0.003 + 0.00512 U (Cox and Munk 1954,
/// J. Opt. Soc. Am. 44:838, for a wind of U m/s at 12.5 m, up to 14 m/s): half, because shorter waves, which have the
/// other half, only spread the light that these focus (this factor is assumed). Where a fetch is given, waves that have
/// not grown over it are absent: the variance at length L falls by exp(-1.25 (L / Lp)^2), with Lp of
/// longest_wind_wave_m (JONSWAP's spectrum without its peak enhancement), and the shorter ones stay.
class Ripples {
 public:
  static constexpr int kCells = camera::kRippleCells;
  static constexpr int kWrap = kCells - 1;  ///< a mask
  static constexpr double kTile_m = 6.4;

  /// fetch_m: infinite where waves come from afar. Throws InvalidValue.
  Ripples(double wind_m_s, double wind_towards_rad, double fetch_m, std::uint64_t seed);

  /// The surface and the light under it at one time.
  struct Snapshot {
    std::vector<float> slopes;    ///< [cell y][cell x][slope x, slope y]
    std::vector<float> caustics;  ///< see caustics.h
    int first_level;              ///< the first level of the caustics that was computed
  };
  Snapshot at(double time_s, const FocusedSun& sun, int first_level, int threads) const;

 private:
  static constexpr int kMostWaves = 20;  // largest number of waves per tile along an axis
  struct Wave {
    double slope_x, slope_y, phase, omega_rad_s;
    int i, j;  // waves per tile along x and y
  };
  void fill_slopes(double time_s, int threads, std::vector<float>& slopes) const;

  std::vector<Wave> waves_;  // i >= 0, sorted by i
  double short_slope_ = 0;   // standard deviation along each axis of the slopes of shorter waves
};

static_assert(static_cast<float>(Ripples::kTile_m) == camera::kRippleTile_m);

}  // namespace uwsim
