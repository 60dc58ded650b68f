#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace uwsim {

/// The small waves that a breeze makes, too short to move a vehicle: they bend light only. A square tile of waves that
/// repeats every kTile_m, drawn from a seed, each wave running by omega^2 = g k + (0.074 N/m / rho) k^3.
/// Equal slope variance in each octave of wave number (the saturated range, Phillips 1958), cos^2 about the wind,
/// lengths from kTile_m down to 0.32 m. The slopes' variance is half of 0.003 + 0.00512 U (Cox and Munk 1954, J. Opt.
/// Soc. Am. 44:838, for a wind of U m/s at 12.5 m, up to 14 m/s): half, since the shorter ones are left out (assumed).
class Ripples {
 public:
  static constexpr int kCells = 128;
  static constexpr double kTile_m = 6.4;
  static constexpr int kLevels = 6;
  /// Depths of the levels are kFirstLevel_m 2^k.
  static constexpr double kFirstLevel_m = 0.5;

  /// Throws InvalidValue.
  Ripples(double wind_m_s, double wind_towards_rad, std::uint64_t seed);

  /// The surface and the light under it at one time.
  struct Moment {
    /// [cell y][cell x][slope x, slope y]
    std::vector<float> slopes;
    /// [cell y][cell x][level]: vertical light over its mean on a level plane, so that its mean is 1. Light that meets
    /// the surface at x is at x + d (1 - 1 / n) grad h at depth d (small slopes); each level sums where a lattice of
    /// such rays goes, so that folds, where several sheets of light lie over each other, come out bright. Blurred by
    /// the sun's own breadth.
    std::vector<float> caustics;
  };
  Moment at(double time_s, double refractive_index, int threads) const;

 private:
  static constexpr int kMost = 20;  // waves a tile along an axis
  struct Wave {
    double slope_x, slope_y, phase, omega_rad_s;
    int i, j;
  };
  void fill_slopes(double time_s, int threads, std::vector<float>& slopes) const;

  std::vector<Wave> waves_;  // i >= 0, sorted by i
};

}  // namespace uwsim
