#include "uwsim/camera/ripples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "uwsim/camera/parts.h"
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
constexpr int kRays = kFine * kCells;

using Grid = std::vector<float>;

float* slope_at(Grid& slopes, int x, int y) { return slopes.data() + 2 * (y * kCells + x); }
const float* slope_at(const Grid& slopes, int x, int y) {
  return slopes.data() + 2 * ((y & kWrap) * kCells + (x & kWrap));
}

/// Slopes at a lattice of rays, kRays a side, between the nodes.
struct RaySlopes {
  Grid x, y;
};

void fill_ray_slopes(const Grid& slopes, int row, RaySlopes& rays) {
  const int y = row / kFine;
  const float v = static_cast<float>(row % kFine) / kFine;
  const auto between = [](const float* a, const float* b, float share, int part) {
    return (1 - share) * a[part] + share * b[part];
  };
  for (int x = 0; x < kCells; ++x) {
    const float *a = slope_at(slopes, x, y), *b = slope_at(slopes, x + 1, y);
    const float *c = slope_at(slopes, x, y + 1), *d = slope_at(slopes, x + 1, y + 1);
    for (int sub = 0; sub < kFine; ++sub) {
      const float u = static_cast<float>(sub) / kFine;
      const int at = row * kRays + x * kFine + sub;
      rays.x[at] = (1 - v) * between(a, b, u, 0) + v * between(c, d, u, 0);
      rays.y[at] = (1 - v) * between(a, b, u, 1) + v * between(c, d, u, 1);
    }
  }
}

int whole_below(float x) {
  const int whole = static_cast<int>(x);
  return whole - (static_cast<float>(whole) > x ? 1 : 0);
}

/// Where the rays of one row meet a level: shares of light for the four cells around each.
struct Landings {
  std::array<std::array<int, kRays>, 4> cell;
  std::array<std::array<float, kRays>, 4> share;

  void fill(const RaySlopes& rays, int row, float reach) {
    constexpr float kShare = 1.0f / (kFine * kFine), kStep = 1.0f / kFine;
    const float *slope_x = rays.x.data() + row * kRays, *slope_y = rays.y.data() + row * kRays;
    for (int k = 0; k < kRays; ++k) {
      const float x = static_cast<float>(k) * kStep + reach * slope_x[k];
      const float y = static_cast<float>(row) * kStep + reach * slope_y[k];
      const int i = whole_below(x), j = whole_below(y);
      const float u = x - static_cast<float>(i), v = y - static_cast<float>(j);
      const int left = i & kWrap, right = (i + 1) & kWrap;
      const int low = (j & kWrap) * kCells, high = ((j + 1) & kWrap) * kCells;
      cell[0][k] = low + left, share[0][k] = kShare * (1 - u) * (1 - v);
      cell[1][k] = low + right, share[1][k] = kShare * u * (1 - v);
      cell[2][k] = high + left, share[2][k] = kShare * (1 - u) * v;
      cell[3][k] = high + right, share[3][k] = kShare * u * v;
    }
  }
};

/// One pass of the kernel (w, 1 - 2 w, w) along each axis, round the tile's edges.
void blur(Grid& light, float w) {
  Grid other(light.size());
  const auto mixed = [w](float before, float here, float after) { return (1 - 2 * w) * here + w * (before + after); };
  for (int y = 0; y < kCells; ++y) {
    const float* row = light.data() + y * kCells;
    float* out = other.data() + y * kCells;
    for (int x = 1; x < kWrap; ++x) out[x] = mixed(row[x - 1], row[x], row[x + 1]);
    out[0] = mixed(row[kWrap], row[0], row[1]);
    out[kWrap] = mixed(row[kWrap - 1], row[kWrap], row[0]);
  }
  for (int y = 0; y < kCells; ++y) {
    const float* before = other.data() + ((y - 1) & kWrap) * kCells;
    const float* here = other.data() + y * kCells;
    const float* after = other.data() + ((y + 1) & kWrap) * kCells;
    for (int x = 0; x < kCells; ++x) light[y * kCells + x] = mixed(before[x], here[x], after[x]);
  }
}

Grid caustic_level(const RaySlopes& rays, double depth_m, double bend) {
  Grid light(kCells * kCells, 0.0f);
  const auto reach = static_cast<float>(depth_m * bend / kCell_m);
  std::array<Landings, 2> both;
  // Rows far from each other take turns, so that sums in one cell need not wait for each other.
  for (int row = 0; row < kRays / 2; ++row) {
    for (int half = 0; half < 2; ++half) both[half].fill(rays, row + half * (kRays / 2), reach);
    for (int k = 0; k < kRays; ++k) {
      for (int corner = 0; corner < 4; ++corner) {
        for (const Landings& one : both) light[one.cell[corner][k]] += one.share[corner][k];
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
void Ripples::fill_slopes(double time_s, int threads, std::vector<float>& slopes) const {
  using Turn = std::complex<double>;
  struct Column {
    Turn x, y;
  };
  slopes.assign(2 * kCells * kCells, 0.0f);
  std::array<Turn, kCells> turns;
  for (int x = 0; x < kCells; ++x) turns[x] = std::polar(1.0, kTau * x / kCells);
  // Row i holds the turns of i waves a tile.
  std::array<std::array<float, kCells>, kMost + 1> cosine, sine;
  for (int i = 0; i <= kMost; ++i) {
    for (int x = 0; x < kCells; ++x) {
      const Turn& turn = turns[(i * x) & kWrap];
      cosine[i][x] = static_cast<float>(turn.real()), sine[i][x] = static_cast<float>(turn.imag());
    }
  }
  std::vector<Turn> now;
  for (const Wave& w : waves_) now.push_back(std::polar(1.0, w.phase - std::fmod(w.omega_rad_s * time_s, kTau)));
  for_rows(kCells, threads, [&](int y, int) {
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
        row_x[x] += ax * cosine[i][x] - bx * sine[i][x];
        row_y[x] += ay * cosine[i][x] - by * sine[i][x];
      }
    }
    for (int x = 0; x < kCells; ++x) {
      slope_at(slopes, x, y)[0] = row_x[x];
      slope_at(slopes, x, y)[1] = row_y[x];
    }
  });
}

Ripples::Moment Ripples::at(double time_s, double refractive_index, int threads) const {
  Moment moment;
  fill_slopes(time_s, threads, moment.slopes);
  RaySlopes rays{Grid(kRays * kRays), Grid(kRays * kRays)};
  for (int row = 0; row < kRays; ++row) fill_ray_slopes(moment.slopes, row, rays);
  moment.caustics.resize(static_cast<std::size_t>(kCells) * kCells * kLevels);
  for_rows(kLevels, threads, [&](int level, int) {
    const Grid light = caustic_level(rays, kFirstLevel_m * std::exp2(level), 1 - 1 / refractive_index);
    for (std::size_t k = 0; k < light.size(); ++k) moment.caustics[k * kLevels + level] = light[k];
  });
  return moment;
}

}  // namespace uwsim
