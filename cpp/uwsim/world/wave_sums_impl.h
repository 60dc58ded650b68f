#pragma once

#include "uwsim/core/lane_functions.h"
#include "uwsim/world/wave_sums.h"

// Compiled once for each instruction set, hence the anonymous namespace.
namespace uwsim {
namespace {

/// The decay of a block's waves with depth, for the pressure and horizontal motion, and for vertical motion.
struct Decay {
  DoubleLanes level, upright;

  Decay() = default;
  Decay(const WaveBlock& w, double z_m) {
    DoubleLanes up, down;
    exponentials(load_lanes(w.number_rad_m) * z_m, up, down);
    up *= load_lanes(w.deep);
    down *= load_lanes(w.mirror);
    level = up + down;
    upright = up - down;
  }
};

/// Calls visit(block, decay, cosine, sine) for each block. The decays of several blocks are computed before any is
/// used: an exponential is a chain of dependent operations, and several of them take little longer than one.
template <typename Visit>
void visit_blocks(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, double z_m, const Visit& visit) {
  constexpr std::size_t kTogether = 8;
  Decay decays[kTogether];
  for (std::size_t first = 0; first < count; first += kTogether) {
    const std::size_t here = count - first < kTogether ? count - first : kTogether;
    for (std::size_t n = 0; n < here; ++n) decays[n] = Decay(waves[first + n], z_m);
    for (std::size_t n = 0; n < here; ++n) {
      const CrestBlock& crest = crests[first + n];
      visit(waves[first + n], decays[n], load_lanes(crest.cosine_m), load_lanes(crest.sine_m));
    }
  }
}

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

template <bool kWithLocal>
struct MotionSums {
  DoubleLanes velocity[3]{}, local[3]{}, surface[3]{}, gradient[5]{};

  void add(const WaveBlock& w, const Decay& decay, DoubleLanes c, DoubleLanes s) {
    const DoubleLanes kx = load_lanes(w.number_x_rad_m), ky = load_lanes(w.number_y_rad_m),
                      omega = load_lanes(w.omega_rad_s);
    const DoubleLanes along = load_lanes(w.along_m_s) * decay.level, rise = load_lanes(w.rise_rad_s) * decay.upright;
    const DoubleLanes along_c = along * c, along_s = along * s, rise_c = rise * c;
    const DoubleLanes along_x = along_s * kx, along_y = along_s * ky;
    velocity[0] += along_c * kx;
    velocity[1] += along_c * ky;
    velocity[2] += rise * s;
    if constexpr (kWithLocal) {
      local[0] += omega * along_x;
      local[1] += omega * along_y;
      local[2] -= omega * rise_c;
    }
    surface[0] -= s * kx;
    surface[1] -= s * ky;
    surface[2] += s * omega;
    gradient[0] -= along_x * kx;
    gradient[1] -= along_x * ky;
    gradient[2] -= along_y * ky;
    gradient[3] += rise_c * kx;
    gradient[4] += rise_c * ky;
  }

  void store(WaveMotionSums& sums) const {
    for (int k = 0; k < 3; ++k) {
      sums.velocity_m_s[k] = sum_of_lanes(velocity[k]);
      sums.local_m_s2[k] = sum_of_lanes(local[k]);
      sums.surface[k] = sum_of_lanes(surface[k]);
    }
    for (int k = 0; k < 5; ++k) sums.gradient[k] = sum_of_lanes(gradient[k]);
  }
};

void motion(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, double z_m, WaveMotionSums& sums) {
  MotionSums<true> lanes;
  visit_blocks(waves, count, crests, z_m, [&](const WaveBlock& w, const Decay& decay, DoubleLanes c, DoubleLanes s) {
    lanes.add(w, decay, c, s);
  });
  lanes.store(sums);
}

/// A body much longer than a wave spans crests and troughs, which cancel. The series do not converge there, so their
/// argument is limited to 1, and the integrals decrease in inverse proportion to the excess.
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

/// The integral of the gradient of -eta exp(kappa . r), and its moment, for the sum of kappa = (i k_x, i k_y, k) and of
/// its mirror image (i k_x, i k_y, -k): see Waves::add_flow_over. Terms that are odd in k differ in sign between the
/// two.
template <bool kWithVelocity>
struct GradientSums {
  DoubleLanes rate[3]{}, turning_rate[3]{}, velocity[3]{}, turning[3]{}, rise_x{}, rise_y{};

  void add(const WaveBlock& w, const WavesOnVolume& on, const Decay& decay, DoubleLanes c, DoubleLanes s) {
    const auto& second = on.second_m5;
    const DoubleLanes number = on.stretch * load_lanes(w.number_rad_m);
    const DoubleLanes kx = load_lanes(w.number_x_rad_m), ky = load_lanes(w.number_y_rad_m);
    const DoubleLanes g0 = second[0][0] * kx + second[0][1] * ky, g1 = second[1][0] * kx + second[1][1] * ky,
                      g2 = second[2][0] * kx + second[2][1] * ky;
    const double h0 = second[0][2], h1 = second[1][2], h2 = second[2][2], half = 0.5 / on.volume_m3;
    const DoubleLanes k2 = number * number, level = kx * g0 + ky * g1;
    DoubleLanes share = DoubleLanes{} + 1;
    const double largest =
        half * w.most_rad_m * w.most_rad_m * (on.stretch * on.stretch * second[2][2] + second[0][0] + second[1][1]);
    if (!(largest < 0.999)) share = limited(half * (k2 * h2 + level));
    const DoubleLanes x = share * (half * (k2 * h2 - level)), y = share * ((2 * half) * (number * (kx * h0 + ky * h1)));
    const DoubleLanes real = share * (1 + x + (x * x - y * y) * (1.0 / 3)), imaginary = share * (y + 2.0 / 3 * x * y);
    const DoubleLanes turn_real = share * (1 + 0.65 * x), turn_imaginary = share * (0.65 * y);
    // The moment is that of a real and an imaginary part of kappa.
    const DoubleLanes even[3] = {k2 * h1 + g2 * ky, -(k2 * h0 + g2 * kx), g1 * kx - ky * g0};
    const DoubleLanes odd[3] = {g1 - h2 * ky, h2 * kx - g0, h0 * ky - h1 * kx};
    const DoubleLanes a = decay.upright * c, b = decay.level * s;
    const DoubleLanes mirrored_a = decay.level * c, mirrored_b = decay.upright * s;
    const DoubleLanes mirrored_q = mirrored_a * imaginary + mirrored_b * real;
    add_to(rate, turning_rate, kx, ky, a * imaginary + b * real, number * (a * real - b * imaginary),
           number * (mirrored_a * turn_imaginary + mirrored_b * turn_real), odd,
           mirrored_a * turn_real - mirrored_b * turn_imaginary, even);
    // The velocity follows from the integral of the head over time, i eta / omega.
    if constexpr (kWithVelocity) {
      const DoubleLanes t = load_lanes(w.period_s_rad), by = t * number;
      add_to(velocity, turning, kx, ky, t * (mirrored_a * real - mirrored_b * imaginary), -(by * mirrored_q),
             by * (a * turn_real - b * turn_imaginary), odd, -(t * (a * turn_imaginary + b * turn_real)), even);
    } else {
      rise_x += number * mirrored_q * kx;
      rise_y += number * mirrored_q * ky;
    }
  }

  static void add_to(DoubleLanes (&force)[3], DoubleLanes (&moment)[3], DoubleLanes kx, DoubleLanes ky,
                     DoubleLanes level, DoubleLanes down, DoubleLanes by, const DoubleLanes (&odd)[3], DoubleLanes less,
                     const DoubleLanes (&even)[3]) {
    force[0] += level * kx;
    force[1] += level * ky;
    force[2] -= down;
    for (int k = 0; k < 3; ++k) moment[k] += by * odd[k] - less * even[k];
  }

  void store(double volume_m3, WaveIntegrals& integrals) const {
    for (int k = 0; k < 3; ++k) {
      integrals.rate[k] = volume_m3 * sum_of_lanes(rate[k]);
      integrals.turning_rate[k] = sum_of_lanes(turning_rate[k]);
      integrals.velocity[k] = volume_m3 * sum_of_lanes(velocity[k]);
      integrals.turning[k] = sum_of_lanes(turning[k]);
    }
    integrals.rise_gradient[0] = volume_m3 * sum_of_lanes(rise_x);
    integrals.rise_gradient[1] = volume_m3 * sum_of_lanes(rise_y);
  }
};

/// The local rate is minus the gradient of the pressure head, eta.
template <bool kWithVelocity>
void over(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const WavesOnVolume& on,
          WaveIntegrals& integrals) {
  GradientSums<kWithVelocity> lanes;
  visit_blocks(waves, count, crests, on.z_m, [&](const WaveBlock& w, const Decay& decay, DoubleLanes c, DoubleLanes s) {
    lanes.add(w, on, decay, c, s);
  });
  lanes.store(on.volume_m3, integrals);
}

void over_with_motion(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const WavesOnVolume& on,
                      WaveIntegrals& integrals, WaveMotionSums& sums) {
  GradientSums<true> lanes;
  MotionSums<false> motion;
  visit_blocks(waves, count, crests, on.z_m, [&](const WaveBlock& w, const Decay& decay, DoubleLanes c, DoubleLanes s) {
    lanes.add(w, on, decay, c, s);
    motion.add(w, decay, c, s);
  });
  lanes.store(on.volume_m3, integrals);
  motion.store(sums);
}

constexpr WaveSumKernels kKernels = {crests, motion, surface, over<true>, over_with_motion, over<false>};

}  // namespace
}  // namespace uwsim
