#include "uwsim/camera/ripples.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <thread>

#include "uwsim/core/check.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

constexpr double kTau = 2 * std::numbers::pi;
constexpr double kGravity_m_s2 = 9.80665;
constexpr double kTension_m3_s2 = 7.4e-5;  // of clean water at 10 deg C over its density
constexpr double kSunRadius_rad = 0.00465;
constexpr int kCells = Ripples::kCells;
constexpr int kWrap = kCells - 1;
constexpr double kCell_m = Ripples::kTile_m / kCells;
constexpr int kFine = 2;  // rays a cell along an axis

using Grid = std::vector<float>;

float* slope_at(Grid& slopes, int x, int y) { return slopes.data() + 2 * (y * kCells + x); }
const float* slope_at(const Grid& slopes, int x, int y) {
  return slopes.data() + 2 * ((y & kWrap) * kCells + (x & kWrap));
}

/// Adds the light of one ray to the four cells around where it goes.
void add_light(Grid& light, float x, float y, float share) {
  const float floor_x = std::floor(x), floor_y = std::floor(y);
  const int i = static_cast<int>(floor_x) & kWrap, j = static_cast<int>(floor_y) & kWrap;
  const int i1 = (i + 1) & kWrap, j1 = (j + 1) & kWrap;
  const float u = x - floor_x, v = y - floor_y;
  light[j * kCells + i] += share * (1 - u) * (1 - v);
  light[j * kCells + i1] += share * u * (1 - v);
  light[j1 * kCells + i] += share * (1 - u) * v;
  light[j1 * kCells + i1] += share * u * v;
}

/// One pass of the kernel (w, 1 - 2 w, w) along each axis, round the tile's edges.
void blur(Grid& light, float w) {
  Grid other(light.size());
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const float* row = light.data() + y * kCells;
      other[y * kCells + x] = (1 - 2 * w) * row[x] + w * (row[(x - 1) & kWrap] + row[(x + 1) & kWrap]);
    }
  }
  for (int y = 0; y < kCells; ++y) {
    const float* above = other.data() + ((y - 1) & kWrap) * kCells;
    const float* here = other.data() + y * kCells;
    const float* below = other.data() + ((y + 1) & kWrap) * kCells;
    for (int x = 0; x < kCells; ++x) light[y * kCells + x] = (1 - 2 * w) * here[x] + w * (above[x] + below[x]);
  }
}

Grid caustic_level(const Grid& slopes, double depth_m, double bend) {
  Grid light(kCells * kCells, 0.0f);
  const auto reach = static_cast<float>(depth_m * bend / kCell_m);
  constexpr float kShare = 1.0f / (kFine * kFine);
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const float *a = slope_at(slopes, x, y), *b = slope_at(slopes, x + 1, y);
      const float *c = slope_at(slopes, x, y + 1), *d = slope_at(slopes, x + 1, y + 1);
      for (int sub = 0; sub < kFine * kFine; ++sub) {
        const float u = static_cast<float>(sub % kFine) / kFine, v = static_cast<float>(sub / kFine) / kFine;
        const float slope_x = (1 - v) * ((1 - u) * a[0] + u * b[0]) + v * ((1 - u) * c[0] + u * d[0]);
        const float slope_y = (1 - v) * ((1 - u) * a[1] + u * b[1]) + v * ((1 - u) * c[1] + u * d[1]);
        add_light(light, static_cast<float>(x) + u + reach * slope_x, static_cast<float>(y) + v + reach * slope_y,
                  kShare);
      }
    }
  }
  // A disc of radius r has the variance r^2 / 4 along each axis, a pass 2 w cells^2.
  const double sigma = 0.5 * kSunRadius_rad * depth_m / kCell_m;
  double variance = std::max(sigma * sigma, 0.15);  // the least hides the lattice of rays
  for (; variance > 0; variance -= 0.5) blur(light, static_cast<float>(0.5 * std::min(variance, 0.5)));
  return light;
}

}  // namespace

Ripples::Ripples(double wind_m_s, double wind_towards_rad, std::uint64_t seed) {
  require(wind_m_s >= 0 && wind_m_s <= 14, "optics.wind", wind_m_s, "must be in [0, 14] m/s");
  require(std::isfinite(wind_towards_rad), "optics.wind_towards", wind_towards_rad, "must be finite");
  const RandomStream random(seed, "optics/ripples");
  double variance = 0;
  for (int i = 0; i <= kMost; ++i) {
    for (int j = -kMost; j <= kMost; ++j) {
      const int square = i * i + j * j;
      if (square == 0 || square > kMost * kMost || (i == 0 && j < 0)) continue;
      const double k = kTau / kTile_m * std::sqrt(square);
      const double along = std::cos(std::atan2(j, i) - wind_towards_rad);
      const auto index = static_cast<std::uint32_t>(i * 64 + j + 32);
      // Slope variance a wave ~ 1 / k^2 of the plane: equal in each octave. A little runs against the wind.
      const double slope =
          std::sqrt((along * along + 0.05) / square) * std::sqrt(-2 * std::log(random.uniform(0, index)));
      const double omega = std::sqrt(kGravity_m_s2 * k + kTension_m3_s2 * k * k * k);
      waves_.push_back({slope * i / std::sqrt(square), slope * j / std::sqrt(square), kTau * random.uniform(1, index),
                        along >= 0 ? omega : -omega, i, j});
      variance += 0.5 * slope * slope;
    }
  }
  const double scale = wind_m_s > 0 ? std::sqrt(0.5 * (0.003 + 0.00512 * wind_m_s) / variance) : 0;
  for (Wave& wave : waves_) wave.slope_x *= scale, wave.slope_y *= scale;
}

/// Sums of waves as products of a turn along x and one along y: first over the waves of each i in a row, then over i.
void Ripples::fill_slopes(double time_s, std::vector<float>& slopes) const {
  using Turn = std::complex<double>;
  struct Column {
    Turn x, y;
  };
  slopes.assign(2 * kCells * kCells, 0.0f);
  std::array<Turn, kCells> turns;
  for (int x = 0; x < kCells; ++x) turns[x] = std::polar(1.0, kTau * x / kCells);
  std::vector<Turn> now;
  for (const Wave& w : waves_) now.push_back(std::polar(1.0, w.phase - std::fmod(w.omega_rad_s * time_s, kTau)));
  for (int y = 0; y < kCells; ++y) {
    std::array<Column, kMost + 1> columns{};
    for (std::size_t k = 0; k < waves_.size(); ++k) {
      const Wave& w = waves_[k];
      const Turn turn = now[k] * turns[(w.j * y) & kWrap];
      columns[w.i].x += w.slope_x * turn;
      columns[w.i].y += w.slope_y * turn;
    }
    std::array<float, kCells> row_x{}, row_y{};
    for (int i = 0; i <= kMost; ++i) {
      const auto ax = static_cast<float>(columns[i].x.real()), bx = static_cast<float>(columns[i].x.imag());
      const auto ay = static_cast<float>(columns[i].y.real()), by = static_cast<float>(columns[i].y.imag());
      for (int x = 0; x < kCells; ++x) {
        const Turn& turn = turns[(i * x) & kWrap];
        const auto c = static_cast<float>(turn.real()), s = static_cast<float>(turn.imag());
        row_x[x] += ax * c - bx * s;
        row_y[x] += ay * c - by * s;
      }
    }
    for (int x = 0; x < kCells; ++x) {
      slope_at(slopes, x, y)[0] = row_x[x];
      slope_at(slopes, x, y)[1] = row_y[x];
    }
  }
}

Ripples::Moment Ripples::at(double time_s, double refractive_index, int threads) const {
  Moment moment;
  fill_slopes(time_s, moment.slopes);
  moment.caustics.resize(static_cast<std::size_t>(kCells) * kCells * kLevels);
  const auto work = [&](int first, int step) {
    for (int level = first; level < kLevels; level += step) {
      const Grid light = caustic_level(moment.slopes, kFirstLevel_m * std::exp2(level), 1 - 1 / refractive_index);
      for (std::size_t k = 0; k < light.size(); ++k) moment.caustics[k * kLevels + level] = light[k];
    }
  };
  std::vector<std::jthread> others;
  const int parts = std::clamp(threads, 1, kLevels);
  for (int part = 1; part < parts; ++part) others.emplace_back(work, part, parts);
  work(0, parts);
  others.clear();
  return moment;
}

}  // namespace uwsim
