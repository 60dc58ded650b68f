#include "uwsim/camera/caustics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "uwsim/camera/parallel_rows.h"
#include "uwsim/camera/ripples.h"
#include "uwsim/core/image_buffer.h"

namespace uwsim {
namespace {

constexpr double kSunRadius_rad = 0.00465;
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

/// One pass of the filter (w, 1 - 2 w, w) along each axis, with wrap-around at the tile's edges.
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
  // A disc of radius r has the variance r^2 / 4 along each axis; one pass of the filter adds 2 w cells^2.
  const double sigma = 0.5 * kSunRadius_rad * depth_m / kCell_m;
  double variance = std::max(sigma * sigma, 0.15);  // the minimum smooths away the lattice of rays
  for (; variance > 0; variance -= 0.5) blur(light, static_cast<float>(0.5 * std::min(variance, 0.5)));
  return light;
}

}  // namespace

std::vector<float> caustics_under(const std::vector<float>& slopes, double refractive_index, int first_level,
                                  int threads) {
  RaySlopes rays;
  for_rows(kRays, threads, [&](int row, int) { fill_ray_slopes(slopes, row, rays); });
  std::vector<float> caustics(static_cast<std::size_t>(kCells) * kCells * kLevels);
  for_rows(kLevels - first_level, threads, [&](int above, int) {
    const int level = first_level + above;
    const Grid light = caustic_level(rays, kFirstCausticLevel_m * std::exp2(level), 1 - 1 / refractive_index);
    for (std::size_t k = 0; k < light.size(); ++k) caustics[k * kLevels + level] = light[k];
  });
  return caustics;
}

}  // namespace uwsim
