#pragma once

#include "uwsim/core/lane_functions.h"
#include "uwsim/world/wave_sums.h"

// Compiled once for each instruction set, hence the anonymous namespace.
namespace uwsim {
namespace {

/// The decay of a block's waves with depth.
struct Decay {
  DoubleLanes up;
  DoubleLanes down{};  // the fraction due to the waves' reflection at the bed

  Decay(const WaveBlock& w, double z_m, double depth_m) {
    const DoubleLanes k = load_lanes(w.number_rad_m), deep = load_lanes(w.deep);
    up = deep * exponential(k * z_m);
    if (w.is_deep) return;
    const DoubleLanes share = deep * exponential(-k * (z_m + 2 * depth_m));
    down = deep < 1 ? share : DoubleLanes{};
  }
};

bool crests(const WaveBlock* waves, std::size_t count, double x_m, double y_m, double time_s, CrestBlock* crests,
            double& height_m) {
  DoubleLanes height{}, largest{};
  for (std::size_t n = 0; n < count; ++n) {
    const WaveBlock& w = waves[n];
    const DoubleLanes phase = load_lanes(w.number_x_rad_m) * x_m + load_lanes(w.number_y_rad_m) * y_m -
                              load_lanes(w.omega_rad_s) * time_s + load_lanes(w.phase_rad);
    const DoubleLanes size = phase < 0 ? -phase : phase;
    largest = size > largest ? size : largest;
    DoubleLanes sine, cosine;
    sine_and_cosine(phase, sine, cosine);
    const DoubleLanes amplitude = load_lanes(w.amplitude_m);
    store_lanes(amplitude * cosine, crests[n].cosine_m);
    store_lanes(amplitude * sine, crests[n].sine_m);
    height += amplitude * cosine;
  }
  height_m = sum_of_lanes(height);
  for (std::size_t lane = 0; lane < WaveBlock::kLanes; ++lane) {
    if (!(largest[lane] <= WaveSumKernels::kMostPhase_rad)) return false;
  }
  return true;
}

void motion(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, double z_m, double depth_m,
            WaveMotionSums& sums) {
  DoubleLanes velocity[3]{}, local[3]{}, surface[3]{}, xx{}, xy{}, yy{}, xz{}, yz{};
  for (std::size_t n = 0; n < count; ++n) {
    const WaveBlock& w = waves[n];
    const DoubleLanes c = load_lanes(crests[n].cosine_m), s = load_lanes(crests[n].sine_m);
    const DoubleLanes kx = load_lanes(w.number_x_rad_m), ky = load_lanes(w.number_y_rad_m),
                      omega = load_lanes(w.omega_rad_s);
    const Decay decay(w, z_m, depth_m);
    const DoubleLanes along = load_lanes(w.along_m_s) * (decay.up + decay.down);
    const DoubleLanes rise = load_lanes(w.rise_rad_s) * (decay.up - decay.down);
    const DoubleLanes along_c = along * c, along_s = along * s, rise_c = rise * c;
    velocity[0] += along_c * kx;
    velocity[1] += along_c * ky;
    velocity[2] += rise * s;
    local[0] += omega * (along_s * kx);
    local[1] += omega * (along_s * ky);
    local[2] -= omega * rise_c;
    surface[0] -= s * kx;
    surface[1] -= s * ky;
    surface[2] += s * omega;
    xx -= along_s * kx * kx;
    xy -= along_s * kx * ky;
    yy -= along_s * ky * ky;
    xz += rise_c * kx;
    yz += rise_c * ky;
  }
  for (int k = 0; k < 3; ++k) {
    sums.velocity_m_s[k] = sum_of_lanes(velocity[k]);
    sums.local_m_s2[k] = sum_of_lanes(local[k]);
    sums.surface[k] = sum_of_lanes(surface[k]);
  }
  const DoubleLanes* const gradient[] = {&xx, &xy, &yy, &xz, &yz};
  for (int k = 0; k < 5; ++k) sums.gradient[k] = sum_of_lanes(*gradient[k]);
}

/// A body much longer than a wave spans crests and troughs, which cancel. There the series do not converge: their
/// argument is limited to 1, and the integrals decrease in inverse proportion to what exceeds it.
inline DoubleLanes limited(DoubleLanes size) { return size > 1 ? 1 / size : DoubleLanes{} + 1; }

/// The mean of cos(k x) over an area, and the slope of the straight line nearest to sin(k x) over k: 1 - u^2 / 6 + u^4
/// / 120 and 1 - u^2 / 10 + u^4 / 280 over an interval from -u / k to u / k, whose second moment yields x = -u^2 / 6.
void surface(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const double* spread_m2,
             WaveSurfaceSums& sums) {
  DoubleLanes mean{}, slope_x{}, slope_y{};
  for (std::size_t n = 0; n < count; ++n) {
    const DoubleLanes kx = load_lanes(waves[n].number_x_rad_m), ky = load_lanes(waves[n].number_y_rad_m);
    const DoubleLanes size = 0.5 * (spread_m2[0] * kx * kx + 2 * spread_m2[1] * kx * ky + spread_m2[2] * ky * ky);
    const DoubleLanes share = limited(size), x = -share * size;
    mean += share * load_lanes(crests[n].cosine_m) * (1 + x + 0.3 * x * x);
    const DoubleLanes falls = share * load_lanes(crests[n].sine_m) * (1 + 0.6 * x + 9.0 / 70 * x * x);
    slope_x -= falls * kx;
    slope_y -= falls * ky;
  }
  sums = {sum_of_lanes(mean), sum_of_lanes(slope_x), sum_of_lanes(slope_y)};
}

/// The integral of the gradient of -(a + i b) exp(kappa r), and its moment, for kappa = (i k_x, i k_y, `number`): see
/// Waves::add_flow_over.
template <bool kWithVelocity>
struct GradientSums {
  DoubleLanes rate[3]{}, turning_rate[3]{}, velocity[3]{}, turning[3]{}, rise_x{}, rise_y{};

  void add(const WaveBlock& w, const WavesOnVolume& on, DoubleLanes number, DoubleLanes a, DoubleLanes b) {
    const auto& second = on.second_m5;
    const DoubleLanes kx = load_lanes(w.number_x_rad_m), ky = load_lanes(w.number_y_rad_m);
    const DoubleLanes g0 = second[0][0] * kx + second[0][1] * ky, g1 = second[1][0] * kx + second[1][1] * ky,
                      g2 = second[2][0] * kx + second[2][1] * ky;
    const double h0 = second[0][2], h1 = second[1][2], h2 = second[2][2];
    const DoubleLanes k2 = number * number, level = kx * g0 + ky * g1;
    const DoubleLanes share = limited((0.5 / on.volume_m3) * (k2 * h2 + level)),
                      per_volume = share * (1 / on.volume_m3);
    const DoubleLanes x = per_volume * (0.5 * (k2 * h2 - level)), y = per_volume * (number * (kx * h0 + ky * h1));
    const DoubleLanes real = on.volume_m3 * share * (1 + x + (x * x - y * y) * (1.0 / 3));
    const DoubleLanes imaginary = on.volume_m3 * share * (y + 2.0 / 3 * x * y);
    const DoubleLanes turn_real = share * (1 + 0.65 * x), turn_imaginary = share * (0.65 * y);
    // The moment is that of a real and an imaginary part of kappa.
    const DoubleLanes even[3] = {k2 * h1 + g2 * ky, -(k2 * h0 + g2 * kx), ky * g0 * -1.0 + g1 * kx};
    const DoubleLanes odd[3] = {g1 - h2 * ky, h2 * kx - g0, h0 * ky - h1 * kx};
    const auto add_to = [&](DoubleLanes(&force)[3], DoubleLanes(&moment)[3], DoubleLanes p, DoubleLanes q,
                            DoubleLanes m, DoubleLanes n) {
      force[0] += q * kx;
      force[1] += q * ky;
      force[2] -= number * p;
      const DoubleLanes by = n * number;
      for (int k = 0; k < 3; ++k) moment[k] += by * odd[k] - m * even[k];
    };
    const DoubleLanes p = a * real - b * imaginary, q = a * imaginary + b * real;
    const DoubleLanes m = a * turn_real - b * turn_imaginary, n = a * turn_imaginary + b * turn_real;
    add_to(rate, turning_rate, p, q, m, n);
    // The velocity follows from the integral of the head over time, i eta / omega.
    if constexpr (kWithVelocity) {
      const DoubleLanes t = load_lanes(w.period_s_rad);
      add_to(velocity, turning, -t * q, t * p, -t * n, t * m);
    } else {
      rise_x += number * q * kx;
      rise_y += number * q * ky;
    }
  }
};

/// The local rate is minus the gradient of the pressure head, eta.
template <bool kWithVelocity>
void over(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const WavesOnVolume& on,
          WaveIntegrals& integrals) {
  GradientSums<kWithVelocity> sums;
  for (std::size_t n = 0; n < count; ++n) {
    const WaveBlock& w = waves[n];
    const DoubleLanes c = load_lanes(crests[n].cosine_m), s = load_lanes(crests[n].sine_m);
    const DoubleLanes number = on.stretch * load_lanes(w.number_rad_m);
    const Decay decay(w, on.z_m, on.depth_m);
    sums.add(w, on, number, decay.up * c, decay.up * s);
    if (!w.is_deep) sums.add(w, on, -number, decay.down * c, decay.down * s);
  }
  for (int k = 0; k < 3; ++k) {
    integrals.rate[k] = sum_of_lanes(sums.rate[k]);
    integrals.turning_rate[k] = sum_of_lanes(sums.turning_rate[k]);
    integrals.velocity[k] = sum_of_lanes(sums.velocity[k]);
    integrals.turning[k] = sum_of_lanes(sums.turning[k]);
  }
  integrals.rise_gradient[0] = sum_of_lanes(sums.rise_x);
  integrals.rise_gradient[1] = sum_of_lanes(sums.rise_y);
}

constexpr WaveSumKernels kSumKernels = {crests, motion, surface, over<true>, over<false>};

}  // namespace
}  // namespace uwsim
