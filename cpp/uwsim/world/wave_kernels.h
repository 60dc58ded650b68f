#pragma once

#include <array>
#include <cstddef>

namespace uwsim {

inline constexpr std::size_t kWaveLanes = 8;
inline constexpr int kLowestWaveOrder = 2, kHighestWaveOrder = 9;

/// Eight waves, each the real part of (real + i imaginary) exp(i k_x x + i k_y y + k_z z), with positions relative to a
/// centre. Unused slots are 0.
struct alignas(64) WaveTerms {
  double real[kWaveLanes], imaginary[kWaveLanes];
  double number_x_rad_m[kWaveLanes], number_y_rad_m[kWaveLanes], decay_rad_m[kWaveLanes];
};

/// The sum of many waves over a patch that is small compared with their lengths, as a Taylor polynomial of total degree
/// n. Each point then costs one polynomial, instead of a sine and an exponential for each wave. At distance r from the
/// centre, the remainder is at most the sum over waves of a (k r)^(n + 1) / (n + 1)!, where a is the wave's largest
/// amplitude in the patch. The coefficients of x^a y^b z^c are in descending order of c, then b, then a.
using WavePolynomial = std::array<double, 220>;

/// The sea over a patch.
struct WavePatch {
  double centre_x_m, centre_y_m, centre_z_m;  ///< z: the height at which linear theory is evaluated for the centre
  double stretched_m, troughs, depth_m;       ///< parameters of the stretched layer: see Waves
  WavePolynomial surface;                     ///< the surface's height; only terms with c = 0, in x and y
  WavePolynomial below;                       ///< the waves' pressure head
};

/// The loops over waves and points, compiled for each instruction set. All versions produce the same bits.
struct WaveKernels {
  struct Order {
    /// Fits the polynomial of a sum of waves.
    void (*fit)(const WaveTerms* terms, std::size_t count, WavePolynomial& polynomial);
    /// Fits the polynomial at z = 0.
    void (*fit_flat)(const WaveTerms* terms, std::size_t count, WavePolynomial& polynomial);
    /// Computes the pressure heads at points, x y z for each.
    void (*heads)(const WavePatch& patch, const double* points_m, std::size_t count, double* heads_m);
  };
  std::array<Order, kHighestWaveOrder - kLowestWaveOrder + 1> orders;

  const Order& of_order(int order) const { return orders[static_cast<std::size_t>(order - kLowestWaveOrder)]; }
};

const WaveKernels& baseline_wave_kernels();
const WaveKernels& avx2_wave_kernels();
const WaveKernels& avx512_wave_kernels();
/// The widest of these kernels that this processor supports.
const WaveKernels& wave_kernels();

}  // namespace uwsim
