#include "uwsim/camera/caustics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <memory>
#include <numbers>

#include "uwsim/camera/parallel_rows.h"
#include "uwsim/camera/particle_scattering.h"
#include "uwsim/camera/plane_transform.h"
#include "uwsim/camera/ripples.h"
#include "uwsim/core/built_when_used.h"
#include "uwsim/core/image_buffer.h"
#include "uwsim/core/recently_made.h"

namespace uwsim {
namespace {

constexpr double kSunRadius_rad = 0.00465;
constexpr double kNothingLeft = 16;  // exp(-16) of a pattern is not seen
constexpr int kCells = Ripples::kCells;
constexpr int kLevels = camera::kCausticLevels;
constexpr int kWrap = Ripples::kWrap;
constexpr double kCell_m = Ripples::kTile_m / kCells;
constexpr int kFine = 2;  // rays per cell along an axis
constexpr int kRays = kFine * kCells;

using Grid = std::vector<float>;

double path_m(int level) { return kFirstCausticLevel_m * std::exp2(level); }

/// Where the rays of a lattice of kRays x kRays arrive on a level plane, per metre along the beam, relative to a ray
/// through level water.
struct BentRays {
  ImageBuffer<float> x{kRays * kRays}, y{kRays * kRays};
};

/// Fills a row with slopes, interpolated between the nodes.
void fill_slopes(const Grid& slopes, int row, BentRays& rays) {
  const int y = row / kFine;
  const float v = static_cast<float>(row % kFine) / kFine;
  const float* const low = slopes.data() + 2 * y * kCells;
  const float* const high = slopes.data() + 2 * ((y + 1) & kWrap) * kCells;
  const auto mixed = [](float a, float b, float share) { return (1 - share) * a + share * b; };
  std::array<float, kCells + 1> below, above;  // at the nodes on both sides; the last repeats the first
  for (int part = 0; part < 2; ++part) {
    for (int x = 0; x < kCells; ++x) below[x] = low[2 * x + part], above[x] = high[2 * x + part];
    below[kCells] = below[0], above[kCells] = above[0];
    float* const out = (part == 0 ? rays.x : rays.y).data() + row * kRays;
    for (int x = 0; x < kCells; ++x) {
      for (int sub = 0; sub < kFine; ++sub) {
        const float u = static_cast<float>(sub) / kFine;
        out[x * kFine + sub] = mixed(mixed(below[x], below[x + 1], u), mixed(above[x], above[x + 1], u), v);
      }
    }
  }
}

/// Refracts a row's rays by its slopes (refraction.h, in float).
void refract(const FocusedSun& sun, int row, BentRays& rays) {
  const auto ratio = static_cast<float>(1 / sun.refractive_index);
  const auto sun_x = static_cast<float>(sun.to_sun_in_air.x()), sun_y = static_cast<float>(sun.to_sun_in_air.y());
  const auto sun_z = static_cast<float>(sun.cosine_in_air());
  const Eigen::Vector2f slant = sun.slant().cast<float>();
  const auto down = static_cast<float>(sun.cosine_in_water());
  float *const x = rays.x.data() + row * kRays, *const y = rays.y.data() + row * kRays;
  for (int k = 0; k < kRays; ++k) {
    const float up = 1 / std::sqrt(1 + x[k] * x[k] + y[k] * y[k]);  // of the surface's normal
    const float cosine = up * (sun_z - x[k] * sun_x - y[k] * sun_y);
    const float turn = up * (std::sqrt(1 - ratio * ratio * (1 - cosine * cosine)) - ratio * cosine);
    const float per_depth = down / (ratio * sun_z + turn);
    x[k] = per_depth * (turn * x[k] - ratio * sun_x) + down * slant.x();
    y[k] = per_depth * (turn * y[k] - ratio * sun_y) + down * slant.y();
  }
}

int floor_int(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

/// For each ray of one row: the cell that it reaches at a given level, and how its light is shared among that cell, the
/// one to its right, and the two above these.
using Shares = float __attribute__((vector_size(16)));
struct Landings {
  std::array<int, kRays> cell;
  std::array<std::array<float, kRays>, 4> share;

  void fill(const BentRays& rays, int row, float reach) {
    constexpr float kShare = 1.0f / (kFine * kFine), kStep = 1.0f / kFine;
    const float *bent_x = rays.x.data() + row * kRays, *bent_y = rays.y.data() + row * kRays;
    for (int k = 0; k < kRays; ++k) {
      const float x = static_cast<float>(k) * kStep + reach * bent_x[k];
      const float y = static_cast<float>(row) * kStep + reach * bent_y[k];
      const int i = floor_int(x), j = floor_int(y);
      const float u = x - static_cast<float>(i), v = y - static_cast<float>(j);
      cell[k] = (j & kWrap) * kCells + (i & kWrap);
      share[0][k] = kShare * (1 - u) * (1 - v);
      share[1][k] = kShare * u * (1 - v);
      share[2][k] = kShare * (1 - u) * v;
      share[3][k] = kShare * u * v;
    }
  }
};

using Complex = std::complex<float>;

/// The share of each wave of a tile that is left, for the waves (x, y) with x less than half of kCells. The shortest
/// have no direction, and none is left.
struct WavesLeft {
  static constexpr int kHalf = kCells / 2;
  std::array<float, static_cast<std::size_t>(kHalf* kCells)> share{};

  WavesLeft(double short_slope, const FocusedSun& sun, double path_m) {
    // A disc of radius r has the variance r^2 / 4 along each axis, and below Snell's window 1 / n of its level part.
    const double disc = 0.5 * kSunRadius_rad / sun.refractive_index, ruffled = sun.bend() * short_slope;
    const double path2 = path_m * path_m, disc2 = disc * disc * path2, all2 = disc2 + ruffled * ruffled * path2;
    constexpr double kFirst_per_m = 2 * std::numbers::pi / Ripples::kTile_m;
    constexpr double kLeast = 0.15 * kCell_m * kCell_m;  // smooths away the lattice of rays
    const Eigen::Vector2d slant = sun.slant();
    for (int y = 1 - kHalf; y < kHalf; ++y) {
      for (int x = 0; x < kHalf; ++x) {
        const Eigen::Vector2d wave = kFirst_per_m * Eigen::Vector2d(x, y), moved = moved_on_level(slant, wave);
        const double low = moved.dot(sun.to_sun_in_air), square = wave.squaredNorm(), along = wave.dot(slant);
        const double variance = std::max(all2 * moved.squaredNorm() - disc2 * low * low, kLeast * square);
        if (variance > 2 * kNothingLeft) continue;
        share[static_cast<std::size_t>((y & kWrap) * kHalf + x)] = static_cast<float>(
            std::exp(-0.5 * variance) * pattern_left(sun.scattering_per_m, std::sqrt(square + along * along), path_m));
      }
    }
  }

  float of(int x, int y) const {
    if (x == kHalf) return 0;
    return x < kHalf ? share[static_cast<std::size_t>(y * kHalf + x)]
                     : share[static_cast<std::size_t>(((kCells - y) & kWrap) * kHalf + kCells - x)];
  }
};

/// The spreading of a beam's light at each level, which does not change with the waves of the tile.
struct Spreading {
  double short_slope;
  FocusedSun sun;
  std::array<BuiltWhenUsed<WavesLeft>, kLevels> levels = {};

  const WavesLeft& at(int level) const {
    return levels[static_cast<std::size_t>(level)].get([&] { return WavesLeft(short_slope, sun, path_m(level)); });
  }
};

std::shared_ptr<const Spreading> spreading(double short_slope, const FocusedSun& sun) {
  static auto& made = *new RecentlyMade<Spreading>;  // never destroyed: other threads may still draw
  return made.find_or_make(
      true, [&](const Spreading& known) { return known.short_slope == short_slope && known.sun == sun; },
      [&] { return std::make_shared<const Spreading>(short_slope, sun); });
}

/// Spreads the light of two tiles, each of which repeats: together, as the real and the imaginary part of one.
void spread(Grid& one, const WavesLeft& of_one, Grid& two, const WavesLeft& of_two) {
  std::vector<Complex> both(one.size());
  for (std::size_t k = 0; k < both.size(); ++k) both[k] = {one[k], two[k]};
  transform_plane(both, kCells, kCells, false);
  std::vector<Complex> left(both.size());
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const auto at = static_cast<std::size_t>(y * kCells + x);
      const Complex here = both[at];
      const Complex there =
          std::conj(both[static_cast<std::size_t>(((kCells - y) & kWrap) * kCells + ((kCells - x) & kWrap))]);
      left[at] = 0.5f * of_one.of(x, y) * (here + there) + 0.5f * of_two.of(x, y) * (here - there);
    }
  }
  transform_plane(left, kCells, kCells, true);
  for (std::size_t k = 0; k < left.size(); ++k) {
    one[k] = std::max(left[k].real(), 0.0f), two[k] = std::max(left[k].imag(), 0.0f);
  }
}

Grid focused(const BentRays& rays, double path_m) {
  const auto reach = static_cast<float>(path_m / kCell_m);
  ImageBuffer<Shares> sums;
  sums.assign(kCells * kCells, Shares{});
  std::array<Landings, 4> distant;
  // Alternate between distant rows, so that an addition rarely waits for the previous one to the same cell.
  for (int row = 0; row < kRays / 4; ++row) {
    for (int part = 0; part < 4; ++part) distant[part].fill(rays, row + part * (kRays / 4), reach);
    for (int k = 0; k < kRays; ++k) {
      for (const Landings& one : distant) {
        sums[one.cell[k]] += Shares{one.share[0][k], one.share[1][k], one.share[2][k], one.share[3][k]};
      }
    }
  }
  Grid light(kCells * kCells);
  for (int y = 0; y < kCells; ++y) {
    const Shares *here = sums.data() + y * kCells, *below = sums.data() + ((y - 1) & kWrap) * kCells;
    for (int x = 0; x < kCells; ++x) {
      const int left = (x - 1) & kWrap;
      light[y * kCells + x] = here[x][0] + here[left][1] + below[x][2] + below[left][3];
    }
  }
  return light;
}

}  // namespace

double pattern_left(double scattering_per_m, double wave_number_per_m, double path_m) {
  static const double in_beam = scattered_within(kBeamEdge_rad);
  const double lost = std::max(in_beam - kept_when_scattered(wave_number_per_m * path_m), 0.0);
  return std::exp(-scattering_per_m * path_m * lost);
}

std::vector<float> caustics_under(const std::vector<float>& slopes, double short_slope, const FocusedSun& sun,
                                  int first_level, int threads) {
  BentRays rays;
  for_rows(kRays, threads, [&](int row, int) {
    fill_slopes(slopes, row, rays);
    refract(sun, row, rays);
  });
  std::vector<float> caustics(static_cast<std::size_t>(kCells) * kCells * kLevels);
  const std::shared_ptr<const Spreading> spreads = spreading(short_slope, sun);
  static_assert(kLevels % 2 == 0);  // each level has the same partner, and so the same rounding
  for_rows(kLevels / 2 - first_level / 2, threads, [&](int pair, int) {
    const int upper = 2 * (first_level / 2 + pair), lower = upper + 1;
    Grid one = focused(rays, path_m(upper)), two = focused(rays, path_m(lower));
    spread(one, spreads->at(upper), two, spreads->at(lower));
    for (std::size_t k = 0; k < one.size(); ++k) {
      caustics[k * kLevels + lower] = two[k];
      caustics[k * kLevels + upper] = one[k];
    }
  });
  return caustics;
}

}  // namespace uwsim
