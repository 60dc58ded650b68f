#include "uwsim/camera/ripples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "uwsim/camera/caustics.h"
#include "uwsim/camera/parallel_rows.h"
#include "uwsim/core/check.h"
#include "uwsim/core/random.h"
#include "uwsim/core/stream_name.h"

namespace uwsim {
namespace {

constexpr double kTau = 2 * std::numbers::pi;
constexpr double kGravity_m_s2 = 9.80665;
constexpr double kTension_m3_s2 = 7.4e-5;  // surface tension of clean water at 10 deg C divided by its density

}  // namespace

double longest_wind_wave_m(double wind_m_s, double fetch_m) {
  const double per_s = kGravity_m_s2 / wind_m_s, dimensionless_fetch = per_s * fetch_m / wind_m_s;
  const double peak_hz = per_s * std::max(3.5 * std::pow(dimensionless_fetch, -0.33), 0.13);
  return kGravity_m_s2 / (kTau * peak_hz * peak_hz);
}

Ripples::Ripples(double wind_m_s, double wind_towards_rad, double fetch_m, std::uint64_t seed) {
  require(wind_m_s >= 0 && wind_m_s <= 14, "optics.wind", wind_m_s, "must be in [0, 14] m/s");
  require(std::isfinite(wind_towards_rad), "optics.wind_towards", wind_towards_rad, "must be finite");
  require(fetch_m > 0, "optics.fetch_m", fetch_m, "must be positive");
  const RandomStream random(seed, stream_name("optics", "ripples"));
  double variance = 0;
  for (int i = 0; i <= kMostWaves; ++i) {
    for (int j = -kMostWaves; j <= kMostWaves; ++j) {
      const int square = i * i + j * j;
      if (square == 0 || square > kMostWaves * kMostWaves || (i == 0 && j < 0)) continue;
      const double k = kTau / kTile_m * std::sqrt(square);
      const double along = std::cos(std::atan2(j, i) - wind_towards_rad);
      const auto index = static_cast<std::uint32_t>(i * 64 + j + 32);
      // The slope variance of a wave is proportional to 1 / k^2 in the plane of wave vectors, so that each octave has
      // the same variance. Some waves run against the wind.
      const double slope =
          std::sqrt((along * along + 0.05) / square) * std::sqrt(-2 * std::log(random.uniform(0, index)));
      const double omega = std::sqrt(kGravity_m_s2 * k + kTension_m3_s2 * k * k * k);
      waves_.push_back({slope * i / std::sqrt(square), slope * j / std::sqrt(square), kTau * random.uniform(1, index),
                        along >= 0 ? omega : -omega, i, j});
      variance += 0.5 * slope * slope;
    }
  }
  const double half = wind_m_s > 0 ? 0.5 * (0.003 + 0.00512 * wind_m_s) : 0, scale = std::sqrt(half / variance);
  short_slope_ = std::sqrt(0.5 * half);
  for (Wave& wave : waves_) wave.slope_x *= scale, wave.slope_y *= scale;
  if (std::isinf(fetch_m) || wind_m_s == 0) return;
  const double longest_m = longest_wind_wave_m(wind_m_s, fetch_m);
  for (Wave& wave : waves_) {
    const double length_m = kTile_m / std::hypot(wave.i, wave.j), ratio = length_m / longest_m;
    const double left = std::exp(-0.625 * ratio * ratio);
    wave.slope_x *= left, wave.slope_y *= left;
  }
}

/// Sums the waves as products of a phasor along x and one along y: first over all waves with the same i, then over i.
void Ripples::fill_slopes(double time_s, int threads, std::vector<float>& slopes) const {
  using Phasor = std::complex<double>;
  struct Column {
    Phasor x, y;
  };
  slopes.assign(2 * kCells * kCells, 0.0f);
  std::array<Phasor, kCells> phasors;
  for (int x = 0; x < kCells; ++x) phasors[x] = std::polar(1.0, kTau * x / kCells);
  // Row i contains the phasors of i waves per tile.
  std::array<std::array<float, kCells>, kMostWaves + 1> cosine, sine;
  for (int i = 0; i <= kMostWaves; ++i) {
    for (int x = 0; x < kCells; ++x) {
      const Phasor& phasor = phasors[(i * x) & kWrap];
      cosine[i][x] = static_cast<float>(phasor.real()), sine[i][x] = static_cast<float>(phasor.imag());
    }
  }
  std::vector<Phasor> now;
  for (const Wave& w : waves_) now.push_back(std::polar(1.0, w.phase - std::fmod(w.omega_rad_s * time_s, kTau)));
  for_rows(kCells, threads, [&](int y, int) {
    std::array<Column, kMostWaves + 1> columns{};
    for (std::size_t k = 0; k < waves_.size();) {
      const int i = waves_[k].i;
      Column sum{};
      for (; k < waves_.size() && waves_[k].i == i; ++k) {
        const Wave& w = waves_[k];
        // std::complex's product checks for NaN, which takes longer than the product.
        const Phasor &a = now[k], &b = phasors[(w.j * y) & kWrap];
        const Phasor phasor(a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real());
        sum.x += w.slope_x * phasor;
        sum.y += w.slope_y * phasor;
      }
      columns[i] = sum;
    }
    std::array<float, kCells> row_x{}, row_y{};
    for (int i = 0; i <= kMostWaves; ++i) {
      const auto ax = static_cast<float>(columns[i].x.real()), bx = static_cast<float>(columns[i].x.imag());
      const auto ay = static_cast<float>(columns[i].y.real()), by = static_cast<float>(columns[i].y.imag());
      for (int x = 0; x < kCells; ++x) {
        row_x[x] += ax * cosine[i][x] - bx * sine[i][x];
        row_y[x] += ay * cosine[i][x] - by * sine[i][x];
      }
    }
    for (int x = 0; x < kCells; ++x) {
      float* const slope = slopes.data() + 2 * (y * kCells + x);
      slope[0] = row_x[x];
      slope[1] = row_y[x];
    }
  });
}

Ripples::Snapshot Ripples::at(double time_s, const FocusedSun& sun, int first_level, int threads) const {
  Snapshot snapshot;
  snapshot.first_level = first_level;
  fill_slopes(time_s, threads, snapshot.slopes);
  snapshot.caustics = caustics_under(snapshot.slopes, short_slope_, sun, first_level, threads);
  return snapshot;
}

}  // namespace uwsim
