#pragma once

#include "uwsim/core/lane_functions.h"
#include "uwsim/world/wave_sums.h"

// Compiled once for each instruction set, hence the anonymous namespace.
namespace uwsim {
namespace {

constexpr std::size_t kLanes = 8;

/// Eight waves. Unused slots have zero amplitude.
struct WaveBlock {
  DoubleLanes amplitude, omega, k, kx, ky, phase, deep, shallow;
  bool is_deep = true;  ///< whether all are deep-water waves

  /// Transposes the rows: swaps halves of rows, then quarters, then single values.
  WaveBlock(const double* waves, std::size_t count) {
    DoubleLanes rows[kLanes], halves[kLanes], quarters[kLanes];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      rows[lane] = lane < count ? load_lanes(waves + kLanes * lane) : DoubleLanes{0, 1, 1, 0, 0, 0, 1, 1};
    }
    for (std::size_t n = 0; n < 4; ++n) {
      halves[n] = mixed_lanes<0, 1, 2, 3, 8, 9, 10, 11>(rows[n], rows[n + 4]);
      halves[n + 4] = mixed_lanes<4, 5, 6, 7, 12, 13, 14, 15>(rows[n], rows[n + 4]);
    }
    for (std::size_t n = 0; n < 4; ++n) {
      const std::size_t one = n < 2 ? n : n + 2, other = one + 2;
      quarters[one] = mixed_lanes<0, 1, 8, 9, 4, 5, 12, 13>(halves[one], halves[other]);
      quarters[other] = mixed_lanes<2, 3, 10, 11, 6, 7, 14, 15>(halves[one], halves[other]);
    }
    DoubleLanes* const columns[] = {&amplitude, &omega, &k, &kx, &ky, &phase, &deep, &shallow};
    for (std::size_t n = 0; n < kLanes; n += 2) {
      *columns[n] = mixed_lanes<0, 8, 2, 10, 4, 12, 6, 14>(quarters[n], quarters[n + 1]);
      *columns[n + 1] = mixed_lanes<1, 9, 3, 11, 5, 13, 7, 15>(quarters[n], quarters[n + 1]);
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) is_deep = is_deep && deep[lane] == 1;
  }

  DoubleLanes up(double z_m) const { return deep * exponential(k * z_m); }
  /// The fraction due to the waves' reflection at the bed.
  DoubleLanes down(double z_m, double depth_m) const {
    if (is_deep) return DoubleLanes{};
    const DoubleLanes share = deep * exponential(-k * (z_m + 2 * depth_m));
    return deep < 1 ? share : DoubleLanes{};
  }
};

struct CrestBlock {
  DoubleLanes cosine, sine;

  explicit CrestBlock(const double* crests) {
    const DoubleLanes one = load_lanes(crests), other = load_lanes(crests + kLanes);
    cosine = mixed_lanes<0, 2, 4, 6, 8, 10, 12, 14>(one, other);
    sine = mixed_lanes<1, 3, 5, 7, 9, 11, 13, 15>(one, other);
  }
};

void store_crests(DoubleLanes cosine, DoubleLanes sine, double* crests) {
  store_lanes(mixed_lanes<0, 8, 1, 9, 2, 10, 3, 11>(cosine, sine), crests);
  store_lanes(mixed_lanes<4, 12, 5, 13, 6, 14, 7, 15>(cosine, sine), crests + kLanes);
}

/// Calls visit(block, first) for each block of eight waves.
template <typename Visit>
inline void visit_blocks(const double* waves, std::size_t count, const Visit& visit) {
  for (std::size_t first = 0; first < count; first += kLanes)
    visit(WaveBlock(waves + WaveSumKernels::kNumbers * first, count - first), first);
}

bool crests(const double* waves, std::size_t count, double x_m, double y_m, double time_s, double* crests,
            double& height_m) {
  DoubleLanes height{}, largest{};
  visit_blocks(waves, count, [&](const WaveBlock& w, std::size_t first) {
    const DoubleLanes phase = w.kx * x_m + w.ky * y_m - w.omega * time_s + w.phase;
    const DoubleLanes size = phase < 0 ? -phase : phase;
    largest = size > largest ? size : largest;
    DoubleLanes sine, cosine;
    sine_and_cosine(phase, sine, cosine);
    store_crests(w.amplitude * cosine, w.amplitude * sine, crests + 2 * first);
    height += w.amplitude * cosine;
  });
  height_m = sum_of_lanes(height);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (!(largest[lane] <= WaveSumKernels::kMostPhase_rad)) return false;
  }
  return true;
}

void motion(const double* waves, std::size_t count, const double* crests, double z_m, double depth_m,
            WaveMotionSums& sums) {
  DoubleLanes velocity[3]{}, local[3]{}, surface[3]{}, xx{}, xy{}, yy{}, xz{}, yz{};
  visit_blocks(waves, count, [&](const WaveBlock& w, std::size_t first) {
    const auto [c, s] = CrestBlock(crests + 2 * first);
    const DoubleLanes up = w.up(z_m), down = w.down(z_m, depth_m), speed = w.omega * w.shallow;
    const DoubleLanes along = speed * (up + down) / w.k;  // over k, along the heading
    const DoubleLanes rise = speed * (up - down);
    const DoubleLanes along_c = along * c, along_s = along * s, rise_c = rise * c;
    velocity[0] += along_c * w.kx;
    velocity[1] += along_c * w.ky;
    velocity[2] += rise * s;
    local[0] += w.omega * (along_s * w.kx);
    local[1] += w.omega * (along_s * w.ky);
    local[2] -= w.omega * rise_c;
    surface[0] -= s * w.kx;
    surface[1] -= s * w.ky;
    surface[2] += s * w.omega;
    xx -= along_s * w.kx * w.kx;
    xy -= along_s * w.kx * w.ky;
    yy -= along_s * w.ky * w.ky;
    xz += rise_c * w.kx;
    yz += rise_c * w.ky;
  });
  for (int k = 0; k < 3; ++k) {
    sums.velocity_m_s[k] = sum_of_lanes(velocity[k]);
    sums.local_m_s2[k] = sum_of_lanes(local[k]);
    sums.surface[k] = sum_of_lanes(surface[k]);
  }
  const DoubleLanes* const gradient[] = {&xx, &xy, &yy, &xz, &yz};
  for (int k = 0; k < 5; ++k) sums.gradient[k] = sum_of_lanes(*gradient[k]);
}

/// The integral of the gradient of -(a + i b) exp(kappa r), and its moment, for kappa = (i k_x, i k_y, `number`): see
/// Waves::add_flow_over. A volume much longer than a wave spans crests and troughs, which cancel. There the series does
/// not converge: its argument is limited to 1, and the integrals decrease in inverse proportion to what exceeds it.
struct GradientSums {
  DoubleLanes force[3]{}, moment[3]{};

  void add(const WaveBlock& w, const WavesOnVolume& on, DoubleLanes number, DoubleLanes a, DoubleLanes b) {
    const auto& second = on.second_m5;
    const DoubleLanes g0 = second[0][0] * w.kx + second[0][1] * w.ky, g1 = second[1][0] * w.kx + second[1][1] * w.ky,
                      g2 = second[2][0] * w.kx + second[2][1] * w.ky;
    const double h0 = second[0][2], h1 = second[1][2], h2 = second[2][2];
    const DoubleLanes k2 = number * number, level = w.kx * g0 + w.ky * g1;
    const DoubleLanes size = (0.5 / on.volume_m3) * (k2 * h2 + level);
    const DoubleLanes share = size > 1 ? 1 / size : DoubleLanes{} + 1, per_volume = share / on.volume_m3;
    const DoubleLanes x = per_volume * (0.5 * (k2 * h2 - level)), y = per_volume * (number * (w.kx * h0 + w.ky * h1));
    const DoubleLanes real = on.volume_m3 * share * (1 + x + (x * x - y * y) / 3);
    const DoubleLanes imaginary = on.volume_m3 * share * (y + 2.0 / 3 * x * y);
    const DoubleLanes p = a * real - b * imaginary, q = a * imaginary + b * real;
    force[0] += q * w.kx;
    force[1] += q * w.ky;
    force[2] -= number * p;
    const DoubleLanes turn_real = share * (1 + 0.65 * x), turn_imaginary = share * (0.65 * y);
    const DoubleLanes am = a * turn_real - b * turn_imaginary, bn = (a * turn_imaginary + b * turn_real) * number;
    moment[0] -= am * (k2 * h1 + g2 * w.ky) - bn * (g1 - h2 * w.ky);
    moment[1] -= -am * (k2 * h0 + g2 * w.kx) + bn * (g0 - h2 * w.kx);
    moment[2] -= -am * (g0 * w.ky - g1 * w.kx) - bn * (h0 * w.ky - h1 * w.kx);
  }
};

/// The local rate is minus the gradient of the pressure head, eta; the velocity follows from the integral of the head
/// over time, i eta / omega.
void over(const double* waves, std::size_t count, const double* crests, const WavesOnVolume& on,
          WaveIntegrals& integrals) {
  GradientSums head, potential;
  visit_blocks(waves, count, [&](const WaveBlock& w, std::size_t first) {
    const auto [c, s] = CrestBlock(crests + 2 * first);
    const auto add = [&](DoubleLanes number, DoubleLanes share) {
      const DoubleLanes a = share * c, b = share * s;
      head.add(w, on, number, a, b);
      potential.add(w, on, number, -b / w.omega, a / w.omega);
    };
    add(w.k, w.up(on.z_m));
    if (!w.is_deep) add(-w.k, w.down(on.z_m, on.depth_m));
  });
  for (int k = 0; k < 3; ++k) {
    integrals.velocity[k] = sum_of_lanes(potential.force[k]);
    integrals.turning[k] = sum_of_lanes(potential.moment[k]);
    integrals.rate[k] = sum_of_lanes(head.force[k]);
    integrals.turning_rate[k] = sum_of_lanes(head.moment[k]);
  }
}

constexpr WaveSumKernels kSumKernels = {crests, motion, over};

}  // namespace
}  // namespace uwsim
