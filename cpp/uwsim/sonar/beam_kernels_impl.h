#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "uwsim/sonar/beam_kernels.h"
#include "uwsim/sonar/hashed_noise.h"

// Compiled once for each instruction set, hence the anonymous namespace. The loops are written for auto-vectorisation.
namespace uwsim {
namespace {

constexpr int kLanes = 16;
constexpr float kInfinity = __builtin_inff();
constexpr float kDecibel = 8.68588964f;  // 20 / ln 10
constexpr double kMinCosine = 1e-6;
constexpr float kMinRange_m = 0.01f;

/// Natural logarithm of a positive, normal number: ln 2 times its exponent plus, for its mantissa m in [0.7, 1.41], the
/// series 2 (z + z^3/3 + z^5/5 + ...) with z = (m - 1) / (m + 1), |z| < 0.172.
inline float log_series(float x) {
  std::int32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;  // of x / sqrt(1/2), rounded down
  bits -= exponent * (1 << 23);
  float m;
  std::memcpy(&m, &bits, sizeof m);
  const float z = (m - 1) / (m + 1), z2 = z * z;
  const float series = 2 * z * (1 + z2 * (1.0f / 3 + z2 * (1.0f / 5 + z2 * (1.0f / 7 + z2 * (1.0f / 9)))));
  return static_cast<float>(exponent) * 0.69314718f + series;
}

/// atan2(opposite, adjacent) for non-negative arguments. Uses the series of the arc tangent about 0, 45 or 90 degrees,
/// whichever is nearest, so that its argument is at most tan(22.5 deg).
inline float angle_series(float opposite, float adjacent) {
  const float less = opposite < adjacent ? opposite : adjacent, more = opposite < adjacent ? adjacent : opposite;
  const bool middle = less > 0.41421356f * more;
  const float q = (middle ? less - more : less) / (middle ? less + more : more);
  const float q2 = q * q;
  const float tail = 1.0f / 7 - q2 * (1.0f / 9 - q2 * (1.0f / 11 - q2 * (1.0f / 13 - q2 * (1.0f / 15))));
  const float series = q * (1 - q2 * (1.0f / 3 - q2 * (1.0f / 5 - q2 * tail)));
  const float small = (middle ? 0.78539816f : 0.0f) + series;
  return opposite < adjacent ? small : 1.57079633f - small;
}

void directions(const double* x_axis, const double* y_axis, const double* cosine, const double* sine,
                double* direction_x, double* direction_y, double* direction_z) {
#pragma GCC ivdep  // inputs and outputs do not overlap
  for (int k = 0; k < kLanes; ++k) {
    direction_x[k] = x_axis[0] * cosine[k] + y_axis[0] * sine[k];
    direction_y[k] = x_axis[1] * cosine[k] + y_axis[1] * sine[k];
    direction_z[k] = x_axis[2] * cosine[k] + y_axis[2] * sine[k];
  }
}

void reach(double head_z_m, double range_max_m, const double* direction_z, double* far_m) {
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const double to_surface_m = -head_z_m / direction_z[k];
    const bool surfaces = (direction_z[k] > 0) & (to_surface_m < range_max_m);
    far_m[k] = surfaces ? to_surface_m : range_max_m;
  }
}

void echoes(const BeamHits& hits, const EchoRule& rule, const BeamEchoes& out) {
  alignas(64) std::int32_t valid[kLanes];
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const double hit_z = rule.head_z_m + hits.distance_m[k] * hits.direction_z[k];
    const bool echo = (hits.distance_m[k] < rule.range_max_m) & (hit_z <= 0);
    const double along = hits.normal_x[k] * hits.direction_x[k] + hits.normal_y[k] * hits.direction_y[k] +
                         hits.normal_z[k] * hits.direction_z[k];
    const double turned = along < 0 ? -along : along;
    const double cosine = turned < 1 ? turned : 1;
    const auto range = static_cast<float>(echo ? hits.distance_m[k] : 1);
    const float near = range > kMinRange_m ? range : kMinRange_m;
    const auto visible = static_cast<float>(cosine > kMinCosine ? cosine : kMinCosine);
    const float angle = angle_series(std::sqrt(static_cast<float>(1 - cosine * cosine)), static_cast<float>(cosine));
    const float level = kDecibel * log_series(visible / (near * near)) -
                        static_cast<float>(2 * rule.absorption_db_m) * range + hits.strength_db[k];
    out.range_m[k] = echo ? range : kInfinity;
    out.incidence_rad[k] = echo ? angle : __builtin_nanf("");
    out.intensity_db[k] = echo ? level : -kInfinity;
    valid[k] = -static_cast<std::int32_t>(echo);
  }
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    out.label[k] = static_cast<std::uint16_t>(hits.label[k] & static_cast<std::uint32_t>(valid[k]));
  }
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) out.valid[k] = static_cast<std::uint8_t>(valid[k] & 1);
}

void points(const double* distance_m, const double* cosine, const double* sine, const float* range_m, float* point) {
  constexpr float kNone = __builtin_nanf("");
  alignas(64) float x[kLanes], y[kLanes], z[kLanes];
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const bool echo = range_m[k] < kInfinity;
    const auto ahead_m = static_cast<float>(distance_m[k] * cosine[k]);
    const auto aside_m = static_cast<float>(distance_m[k] * sine[k]);
    x[k] = echo ? ahead_m : kNone;
    y[k] = echo ? aside_m : kNone;
    z[k] = echo ? 0.0f : kNone;
  }
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    point[3 * k] = x[k];
    point[3 * k + 1] = y[k];
    point[3 * k + 2] = z[k];
  }
}

void incidence(const FloatHits& hits, float* cosine) {
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const float x = hits.normal_x[k], y = hits.normal_y[k], z = hits.normal_z[k];
    const float along = x * hits.direction_x[k] + (y * hits.direction_y[k] + z * hits.direction_z[k]);
    cosine[k] = (along < 0 ? -along : along) / std::sqrt(x * x + (y * y + z * z));
  }
}

void patches(const RayPatches& rays, const PatchEchoes& out) {
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const float length = rays.length_m[k], cosine = rays.cosine[k], square = cosine * cosine;
    const float patch_m = length * rays.spacing_rad[k], relief_m = rays.relief[k];
    // The extent of a ray's patch in range depends on tan i, that of the relief along the ray on cos i.
    const float point_m2 = rays.cell_m * rays.cell_m + relief_m * relief_m * square;
    out.energy[k] = rays.gain[k] * rays.lost[k] / (length * length);
    out.point_m2[k] = point_m2;
    out.width_m[k] = std::sqrt(point_m2 + patch_m * patch_m * (1 - square) / square);
  }
}

/// A lane for each field and column.
void noise(const NoiseCells& cells, float* one, float* two) {
  constexpr int kEach = 4;
  alignas(64) std::uint32_t key[kLanes];
  alignas(64) float weight[kLanes], first[kLanes] = {}, second[kLanes] = {};
  for (int k = 0; k < kLanes; ++k) {
    key[k] = cells.field_keys[k / kEach] + cells.column_keys[k % kEach];
    weight[k] = cells.column_weights[k % kEach];
  }
  for (int row = 0; row < kEach; ++row) {
    const std::uint32_t row_key = cells.row_keys[row];
    const float row_weight = cells.row_weights[row];
#pragma GCC ivdep
    for (int k = 0; k < kLanes; ++k) {
      const auto [a, b] = byte_sums(mixed(row_key + key[k]));
      first[k] += row_weight * weight[k] * a;
      second[k] += row_weight * weight[k] * b;
    }
  }
  for (int field = 0; field < kEach; ++field) {
    one[field] = two[field] = 0;
    for (int column = 0; column < kEach; ++column) {
      one[field] += first[kEach * field + column];
      two[field] += second[kEach * field + column];
    }
  }
}

void column(const ColumnSamples& in, float* level_db) {
  alignas(64) float mean[kLanes], speckle[kLanes] = {};
  const float volume = in.volume * in.lost;
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const float range = in.first_m + static_cast<float>(k) * in.step_m;
    const float near = range > kMinRange_m ? range : kMinRange_m;
    const float x = in.rate * (static_cast<float>(k) - 7.5f);
    const float growth = 1 + x * (1 + x * (1.0f / 2 + x * (1.0f / 6 + x * (1.0f / 24))));  // exp(x), |x| <= 0.3
    const float water = range < in.water_m ? volume * growth / (near * near) : 0.0f;
    mean[k] = in.system_ratio * (in.echoes[k] + water) + in.noise;
  }
  // Each range cell's power is exponentially distributed: -log of a uniform number, a multiple of 2^-24 in (0, 1).
  for (std::uint32_t cell = 0; cell < in.cells; ++cell) {
#pragma GCC ivdep
    for (int k = 0; k < kLanes; ++k) {
      const std::uint32_t index = (in.index + static_cast<std::uint32_t>(k)) * in.cells + cell;
      const std::uint32_t hash = mixed(mixed(in.key + index) ^ in.second_key);
      speckle[k] -= log_series((static_cast<float>(static_cast<std::int32_t>(hash >> 9)) + 0.5f) * 0x1p-23f);
    }
  }
  const float share = 1 / static_cast<float>(in.cells);
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    level_db[k] = 0.5f * kDecibel * log_series(mean[k] * speckle[k] * share) + in.level_db;
  }
}

constexpr BeamKernels kKernels{&directions, &reach, &echoes, &points, &incidence, &patches, &noise, &column};

}  // namespace
}  // namespace uwsim
