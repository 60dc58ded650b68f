#pragma once

#include <cstring>
#include <tuple>

#include "uwsim/core/double_lanes.h"
#include "uwsim/world/wave_kernels.h"

// Compiled once for each instruction set, hence the anonymous namespace.
namespace uwsim {
namespace {

/// Powers k^n / n!, n = 0 .. kOrder.
template <int kOrder>
struct Powers {
  DoubleLanes of[kOrder + 1];

  explicit Powers(DoubleLanes k) {
    of[0] = DoubleLanes{} + 1;
    for (int n = 1; n <= kOrder; ++n) of[n] = of[n - 1] * k / static_cast<double>(n);
  }
};

/// `kHighestZ` is the order in z: 0 for waves at z = 0.
template <int kOrder, int kHighestZ>
void fit(const WaveTerms* terms, std::size_t count, WavePolynomial& polynomial) {
  DoubleLanes sums[std::tuple_size_v<WavePolynomial>];
  std::memset(sums, 0, sizeof sums);
  for (std::size_t n = 0; n < count; ++n) {
    const Powers<kOrder> x(load_lanes(terms[n].number_x_rad_m)), y(load_lanes(terms[n].number_y_rad_m));
    const Powers<kHighestZ> z(load_lanes(terms[n].decay_rad_m));
    const DoubleLanes real = load_lanes(terms[n].real), imaginary = load_lanes(terms[n].imaginary);
    const DoubleLanes parts[4] = {real, -imaginary, -real, imaginary};  // the real part of (real + i imaginary) i^n
    DoubleLanes* sum = sums;
    for (int c = kHighestZ; c >= 0; --c) {
      for (int b = kOrder - c; b >= 0; --b) {
        const DoubleLanes share = z.of[c] * y.of[b];
        for (int a = kOrder - c - b; a >= 0; --a) *sum++ += parts[(a + b) % 4] * (share * x.of[a]);
      }
    }
  }
  for (std::size_t k = 0; k < polynomial.size(); ++k) polynomial[k] = sum_of_lanes(sums[k]);
}

/// The coefficient of z^c at (x, y), by Horner's rule. Advances `coefficient` to the next term.
template <int kDegree>
inline DoubleLanes plane_at(DoubleLanes x, DoubleLanes y, const double*& coefficient) {
  DoubleLanes sum{};
#pragma GCC unroll 16
  for (int b = kDegree; b >= 0; --b) {
    DoubleLanes row = DoubleLanes{} + *coefficient++;
#pragma GCC unroll 16
    for (int a = kDegree - b; a > 0; --a) row = row * x + *coefficient++;
    sum = sum * y + row;
  }
  return sum;
}

template <int kOrder, int kDegree = 0>
inline DoubleLanes volume_at(DoubleLanes x, DoubleLanes y, DoubleLanes z, DoubleLanes sum, const double* coefficient) {
  const DoubleLanes next = sum * z + plane_at<kDegree>(x, y, coefficient);
  if constexpr (kDegree == kOrder) {
    return next;
  } else {
    return volume_at<kOrder, kDegree + 1>(x, y, z, next, coefficient);
  }
}

/// Processes eight points at a time, padding unused slots. Waves::stretched defines where linear theory is evaluated.
template <int kOrder>
void heads(const WavePatch& patch, const double* points_m, std::size_t count, double* heads_m) {
  for (std::size_t n = 0; n < count; n += kWaveLanes) {
    const std::size_t used = count - n < kWaveLanes ? count - n : kWaveLanes;
    DoubleLanes px, py, pz;
    if (used == kWaveLanes) {
      load_points(points_m + 3 * n, px, py, pz);
    } else {
      double last[3 * kWaveLanes];
      for (std::size_t k = 0; k < 3 * kWaveLanes; ++k) last[k] = points_m[3 * n + (k < 3 * used ? k : k % 3)];
      load_points(last, px, py, pz);
    }
    const DoubleLanes x = px - patch.centre_x_m, y = py - patch.centre_y_m;
    const double* coefficient = patch.surface.data();
    const DoubleLanes top = plane_at<kOrder>(x, y, coefficient);
    const DoubleLanes trough = -patch.troughs * top;
    const DoubleLanes deep = trough > patch.stretched_m ? trough : DoubleLanes{} + patch.stretched_m;
    const DoubleLanes layer = deep < patch.depth_m ? deep : DoubleLanes{} + patch.depth_m;
    const DoubleLanes stretched = layer / (layer + top) * (pz - top);
    const DoubleLanes as_it_is = pz > -patch.depth_m ? pz : DoubleLanes{} - patch.depth_m;
    const DoubleLanes z = (pz <= -layer ? as_it_is : stretched) - patch.centre_z_m;
    const DoubleLanes head = volume_at<kOrder>(x, y, z, DoubleLanes{}, patch.below.data());
    const DoubleLanes out = (pz >= top ? top : head) - pz;
    std::memcpy(heads_m + n, &out, used * sizeof(double));
  }
}

template <int kOrder>
constexpr WaveKernels::Order kOfOrder = {fit<kOrder, kOrder>, fit<kOrder, 0>, heads<kOrder>};

constexpr WaveKernels kKernels = {
    {kOfOrder<2>, kOfOrder<3>, kOfOrder<4>, kOfOrder<5>, kOfOrder<6>, kOfOrder<7>, kOfOrder<8>, kOfOrder<9>}};

}  // namespace
}  // namespace uwsim
