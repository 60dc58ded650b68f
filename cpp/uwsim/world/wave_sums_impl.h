#pragma once

#include "uwsim/core/lane_functions.h"
#include "uwsim/world/wave_sums.h"

// Compiled once for each instruction set, hence the anonymous namespace.
namespace uwsim {
namespace {

/// The waves of a block in kLanes of its lanes, from `first` on.
struct WaveLanes {
  const WaveBlock& block;
  std::size_t first;

  DoubleLanes amplitude() const { return load_lanes(block.amplitude_m + first); }
  DoubleLanes omega() const { return load_lanes(block.omega_rad_s + first); }
  DoubleLanes period() const { return load_lanes(block.period_s_rad + first); }
  DoubleLanes number() const { return load_lanes(block.number_rad_m + first); }
  DoubleLanes number_x() const { return load_lanes(block.number_x_rad_m + first); }
  DoubleLanes number_y() const { return load_lanes(block.number_y_rad_m + first); }
  DoubleLanes phase() const { return load_lanes(block.phase_rad + first); }
  DoubleLanes deep() const { return load_lanes(block.deep + first); }
  DoubleLanes rise() const { return load_lanes(block.rise_rad_s + first); }
  DoubleLanes along() const { return load_lanes(block.along_m_s + first); }
  DoubleLanes mirror() const { return load_lanes(block.mirror + first); }
};

/// Sums in kEight lanes.
struct alignas(64) LaneSums {
  double lanes[kEight];

  void store(DoubleLanes sum, std::size_t first) { store_lanes(sum, lanes + first); }
  double sum() const { return sum_of_eight(lanes); }
};

/// The decay of waves with depth, for the pressure and horizontal motion, and for vertical motion.
struct Decay {
  DoubleLanes level, upright;

  Decay() = default;
  Decay(const WaveLanes& w, double z_m) {
    DoubleLanes up, down;
    exponentials(w.number() * z_m, up, down);
    up *= w.deep();
    down *= w.mirror();
    level = up + down;
    upright = up - down;
  }
};

/// Calls visit(waves, decay, cosine, sine) for kLanes lanes, from `lane` on, of each block. The decays of several
/// blocks are computed before any is used: an exponential is a chain of dependent operations, and several of them take
/// little longer than one.
template <typename Visit>
void visit_blocks(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, double z_m, std::size_t lane,
                  const Visit& visit) {
  constexpr std::size_t kTogether = 8;
  Decay decays[kTogether];
  for (std::size_t first = 0; first < count; first += kTogether) {
    const std::size_t here = count - first < kTogether ? count - first : kTogether;
    for (std::size_t n = 0; n < here; ++n) decays[n] = Decay(WaveLanes{waves[first + n], lane}, z_m);
    for (std::size_t n = 0; n < here; ++n) {
      const CrestBlock& crest = crests[first + n];
      visit(WaveLanes{waves[first + n], lane}, decays[n], load_lanes(crest.cosine_m + lane),
            load_lanes(crest.sine_m + lane));
    }
  }
}

bool crests(const WaveBlock* waves, std::size_t count, double x_m, double y_m, double time_s, CrestBlock* crests,
            double& height_m) {
  LaneSums height;
  DoubleLanes largest{};
  for (std::size_t lane = 0; lane < kEight; lane += kLanes) {
    DoubleLanes sum{};
    for (std::size_t n = 0; n < count; ++n) {
      const WaveLanes w{waves[n], lane};
      const DoubleLanes phase = w.number_x() * x_m + w.number_y() * y_m - w.omega() * time_s + w.phase();
      const DoubleLanes size = phase < 0 ? -phase : phase;
      largest = size > largest ? size : largest;
      DoubleLanes sine, cosine;
      sine_and_cosine(phase, sine, cosine);
      const DoubleLanes amplitude = w.amplitude();
      store_lanes(amplitude * cosine, crests[n].cosine_m + lane);
      store_lanes(amplitude * sine, crests[n].sine_m + lane);
      sum += amplitude * cosine;
    }
    height.store(sum, lane);
  }
  height_m = height.sum();
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (!(largest[lane] <= WaveSumKernels::kMostPhase_rad)) return false;
  }
  return true;
}

struct MotionLaneSums {
  LaneSums velocity[3], local[3], surface[3], gradient[5];

  void write(WaveMotionSums& sums) const {
    for (int k = 0; k < 3; ++k) {
      sums.velocity_m_s[k] = velocity[k].sum();
      sums.local_m_s2[k] = local[k].sum();
      sums.surface[k] = surface[k].sum();
    }
    for (int k = 0; k < 5; ++k) sums.gradient[k] = gradient[k].sum();
  }
};

template <bool kWithLocal>
struct MotionSums {
  DoubleLanes velocity[3]{}, local[3]{}, surface[3]{}, gradient[5]{};

  void add(const WaveLanes& w, const Decay& decay, DoubleLanes c, DoubleLanes s) {
    const DoubleLanes kx = w.number_x(), ky = w.number_y(), omega = w.omega();
    const DoubleLanes along = w.along() * decay.level, rise = w.rise() * decay.upright;
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

  void store(std::size_t lane, MotionLaneSums& sums) const {
    for (int k = 0; k < 3; ++k) {
      sums.velocity[k].store(velocity[k], lane);
      sums.local[k].store(local[k], lane);
      sums.surface[k].store(surface[k], lane);
    }
    for (int k = 0; k < 5; ++k) sums.gradient[k].store(gradient[k], lane);
  }
};

void motion(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, double z_m, WaveMotionSums& sums) {
  MotionLaneSums all;
  for (std::size_t lane = 0; lane < kEight; lane += kLanes) {
    MotionSums<true> lanes;
    visit_blocks(
        waves, count, crests, z_m, lane,
        [&](const WaveLanes& w, const Decay& decay, DoubleLanes c, DoubleLanes s) { lanes.add(w, decay, c, s); });
    lanes.store(lane, all);
  }
  all.write(sums);
}

/// A body much longer than a wave spans crests and troughs, which cancel. The series do not converge there, so their
/// argument is limited to 1, and the integrals decrease in inverse proportion to the excess.
inline DoubleLanes limited(DoubleLanes size) { return size > 1 ? 1 / size : DoubleLanes{} + 1; }

/// The mean of cos(k x) over an area, and the slope of the straight line nearest to sin(k x) over k: 1 - u^2 / 6 + u^4
/// / 120 and 1 - u^2 / 10 + u^4 / 280 over an interval from -u / k to u / k, whose second moment yields x = -u^2 / 6.
void surface(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const double* spread_m2,
             WaveSurfaceSums& sums) {
  LaneSums mean, slope_x, slope_y;
  for (std::size_t lane = 0; lane < kEight; lane += kLanes) {
    DoubleLanes m{}, along_x{}, along_y{};
    for (std::size_t n = 0; n < count; ++n) {
      const WaveLanes w{waves[n], lane};
      const DoubleLanes kx = w.number_x(), ky = w.number_y();
      const DoubleLanes size = 0.5 * (spread_m2[0] * kx * kx + 2 * spread_m2[1] * kx * ky + spread_m2[2] * ky * ky);
      const DoubleLanes share = limited(size), x = -share * size;
      m += share * load_lanes(crests[n].cosine_m + lane) * (1 + x + 0.3 * x * x);
      const DoubleLanes falls = share * load_lanes(crests[n].sine_m + lane) * (1 + 0.6 * x + 9.0 / 70 * x * x);
      along_x -= falls * kx;
      along_y -= falls * ky;
    }
    mean.store(m, lane);
    slope_x.store(along_x, lane);
    slope_y.store(along_y, lane);
  }
  sums = {mean.sum(), slope_x.sum(), slope_y.sum()};
}

/// The integral of the gradient of -eta exp(kappa . r), and its moment, for the sum of kappa = (i k_x, i k_y, k) and of
/// its mirror image (i k_x, i k_y, -k): see Waves::add_flow_over. Terms that are odd in k differ in sign between the
/// two.
struct GradientLaneSums {
  LaneSums rate[3], turning_rate[3], velocity[3], turning[3], rise_x, rise_y;

  void write(double volume_m3, WaveIntegrals& integrals) const {
    for (int k = 0; k < 3; ++k) {
      integrals.rate[k] = volume_m3 * rate[k].sum();
      integrals.turning_rate[k] = turning_rate[k].sum();
      integrals.velocity[k] = volume_m3 * velocity[k].sum();
      integrals.turning[k] = turning[k].sum();
    }
    integrals.rise_gradient[0] = volume_m3 * rise_x.sum();
    integrals.rise_gradient[1] = volume_m3 * rise_y.sum();
  }
};

template <bool kWithVelocity>
struct GradientSums {
  DoubleLanes rate[3]{}, turning_rate[3]{}, velocity[3]{}, turning[3]{}, rise_x{}, rise_y{};

  void add(const WaveLanes& w, const WavesOnVolume& on, const Decay& decay, DoubleLanes c, DoubleLanes s) {
    const auto& second = on.second_m5;
    const DoubleLanes number = on.stretch * w.number();
    const DoubleLanes kx = w.number_x(), ky = w.number_y();
    const DoubleLanes g0 = second[0][0] * kx + second[0][1] * ky, g1 = second[1][0] * kx + second[1][1] * ky,
                      g2 = second[2][0] * kx + second[2][1] * ky;
    const double h0 = second[0][2], h1 = second[1][2], h2 = second[2][2], half = 0.5 / on.volume_m3;
    const DoubleLanes k2 = number * number, level = kx * g0 + ky * g1;
    DoubleLanes share = DoubleLanes{} + 1;
    const double largest = half * w.block.most_rad_m * w.block.most_rad_m *
                           (on.stretch * on.stretch * second[2][2] + second[0][0] + second[1][1]);
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
      const DoubleLanes t = w.period(), by = t * number;
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

  void store(std::size_t lane, GradientLaneSums& sums) const {
    for (int k = 0; k < 3; ++k) {
      sums.rate[k].store(rate[k], lane);
      sums.turning_rate[k].store(turning_rate[k], lane);
      sums.velocity[k].store(velocity[k], lane);
      sums.turning[k].store(turning[k], lane);
    }
    sums.rise_x.store(rise_x, lane);
    sums.rise_y.store(rise_y, lane);
  }
};

/// The local rate is minus the gradient of the pressure head, eta.
template <bool kWithVelocity>
void over(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const WavesOnVolume& on,
          WaveIntegrals& integrals) {
  GradientLaneSums all;
  for (std::size_t lane = 0; lane < kEight; lane += kLanes) {
    GradientSums<kWithVelocity> lanes;
    visit_blocks(
        waves, count, crests, on.z_m, lane,
        [&](const WaveLanes& w, const Decay& decay, DoubleLanes c, DoubleLanes s) { lanes.add(w, on, decay, c, s); });
    lanes.store(lane, all);
  }
  all.write(on.volume_m3, integrals);
}

void over_with_motion(const WaveBlock* waves, std::size_t count, const CrestBlock* crests, const WavesOnVolume& on,
                      WaveIntegrals& integrals, WaveMotionSums& sums) {
  GradientLaneSums all;
  MotionLaneSums moved;
  for (std::size_t lane = 0; lane < kEight; lane += kLanes) {
    GradientSums<true> lanes;
    MotionSums<false> motion;
    visit_blocks(waves, count, crests, on.z_m, lane,
                 [&](const WaveLanes& w, const Decay& decay, DoubleLanes c, DoubleLanes s) {
                   lanes.add(w, on, decay, c, s);
                   motion.add(w, decay, c, s);
                 });
    lanes.store(lane, all);
    motion.store(lane, moved);
  }
  all.write(on.volume_m3, integrals);
  moved.write(sums);
}

constexpr WaveSumKernels kKernels = {crests, motion, surface, over<true>, over_with_motion, over<false>};

}  // namespace
}  // namespace uwsim
