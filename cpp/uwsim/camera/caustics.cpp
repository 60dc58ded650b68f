#include "uwsim/camera/caustics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

#include "uwsim/camera/parallel_rows.h"
#include "uwsim/camera/plane_transform.h"
#include "uwsim/camera/ripples.h"
#include "uwsim/core/image_buffer.h"

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

/// Slopes at a lattice of kRays x kRays rays, interpolated between the nodes.
struct RaySlopes {
  ImageBuffer<float> x{kRays * kRays}, y{kRays * kRays};
};

void fill_ray_slopes(const Grid& slopes, int row, RaySlopes& rays) {
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

  void fill(const RaySlopes& rays, int row, float reach) {
    constexpr float kShare = 1.0f / (kFine * kFine), kStep = 1.0f / kFine;
    const float *slope_x = rays.x.data() + row * kRays, *slope_y = rays.y.data() + row * kRays;
    for (int k = 0; k < kRays; ++k) {
      const float x = static_cast<float>(k) * kStep + reach * slope_x[k];
      const float y = static_cast<float>(row) * kStep + reach * slope_y[k];
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

/// The share of each wave of a tile that is left, for the waves (x, y) with x and y from 0 to half of kCells.
struct WavesLeft {
  static constexpr int kSide = kCells / 2 + 1;
  std::array<float, static_cast<std::size_t>(kSide* kSide)> share;

  WavesLeft(double short_slope, const FocusWater& water, double depth_m) {
    // A disc of radius r has the variance r^2 / 4 along each axis. The least variance smooths away the lattice of rays.
    const double sun = 0.5 * kSunRadius_rad, ruffled = (1 - 1 / water.refractive_index) * short_slope;
    const double variance = std::max((sun * sun + ruffled * ruffled) * depth_m * depth_m, 0.15 * kCell_m * kCell_m);
    constexpr double kFirst_per_m = 2 * std::numbers::pi / Ripples::kTile_m;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x <= y; ++x) {
        const double k = kFirst_per_m * std::sqrt(x * x + y * y), spread = 0.5 * variance * k * k;
        at(x, y) = at(y, x) =
            spread > kNothingLeft ? 0 : static_cast<float>(std::exp(-spread) * pattern_left(water, k, depth_m));
      }
    }
  }

  float& at(int x, int y) { return share[static_cast<std::size_t>(y * kSide + x)]; }
  float of(int x, int y) const {
    return share[static_cast<std::size_t>(std::min(y, kCells - y) * kSide + std::min(x, kCells - x))];
  }
};

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

Grid focused(const RaySlopes& rays, double bend, double depth_m) {
  const auto reach = static_cast<float>(depth_m * bend / kCell_m);
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

double pattern_left(const FocusWater& water, double wave_number_per_m, double path_m) {
  const double x = water.scattering_rad * wave_number_per_m * path_m;
  const double kept = x > 1e-6 ? -std::expm1(-x) / x : 1 - 0.5 * x;
  return std::exp(-water.scattering_per_m * path_m * (1 - kept));
}

std::vector<float> caustics_under(const std::vector<float>& slopes, double short_slope, const FocusWater& water,
                                  int first_level, int threads) {
  RaySlopes rays;
  for_rows(kRays, threads, [&](int row, int) { fill_ray_slopes(slopes, row, rays); });
  std::vector<float> caustics(static_cast<std::size_t>(kCells) * kCells * kLevels);
  const auto depth_m = [](int level) { return kFirstCausticLevel_m * std::exp2(level); };
  static_assert(kLevels % 2 == 0);  // each level has the same partner, and so the same rounding
  for_rows(kLevels / 2 - first_level / 2, threads, [&](int pair, int) {
    const int upper = 2 * (first_level / 2 + pair), lower = upper + 1;
    const double bend = 1 - 1 / water.refractive_index;
    Grid one = focused(rays, bend, depth_m(upper)), two = focused(rays, bend, depth_m(lower));
    spread(one, WavesLeft(short_slope, water, depth_m(upper)), two, WavesLeft(short_slope, water, depth_m(lower)));
    for (std::size_t k = 0; k < one.size(); ++k) {
      caustics[k * kLevels + lower] = two[k];
      caustics[k * kLevels + upper] = one[k];
    }
  });
  return caustics;
}

}  // namespace uwsim
