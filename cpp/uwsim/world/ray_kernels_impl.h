#pragma once

#include <cmath>
#include <cstdint>

#include "uwsim/world/ray_kernels.h"

// Compiled once for each width of vector unit; hence the anonymous namespace, and loops that compilers vectorise.
namespace uwsim {
namespace {

constexpr int kLanes = 16;

bool all_near(const LaneRays& rays, const double* middle_m, double reach_m) {
  alignas(64) std::int32_t away[kLanes];
  const double x = middle_m[0], y = middle_m[1], z = middle_m[2];
  for (int k = 0; k < kLanes; ++k) {
    const bool near = (std::fabs(rays.origin_x[k] - x) <= reach_m) & (std::fabs(rays.origin_y[k] - y) <= reach_m) &
                      (std::fabs(rays.origin_z[k] - z) <= reach_m);
    away[k] = near ? 0 : -1;
  }
  std::int32_t any = 0;
  for (int k = 0; k < kLanes; ++k) any |= away[k] & rays.active[k];
  return any == 0;
}

void to_float(const LaneRays& rays, const double* middle_m, double back_m, const LaneFloats& floats) {
  const double x = middle_m[0], y = middle_m[1], z = middle_m[2];
#pragma GCC ivdep  // what is read and what is written are apart
  for (int k = 0; k < kLanes; ++k) {
    floats.origin_x[k] = static_cast<float>(rays.origin_x[k] - back_m * rays.direction_x[k] - x);
    floats.origin_y[k] = static_cast<float>(rays.origin_y[k] - back_m * rays.direction_y[k] - y);
    floats.origin_z[k] = static_cast<float>(rays.origin_z[k] - back_m * rays.direction_z[k] - z);
    floats.direction_x[k] = static_cast<float>(rays.direction_x[k]);
    floats.direction_y[k] = static_cast<float>(rays.direction_y[k]);
    floats.direction_z[k] = static_cast<float>(rays.direction_z[k]);
    const double far = (rays.far_m[k] + back_m) * (1 + 1e-6) + 1e-6;
    floats.far_m[k] = static_cast<float>(far < 3e38 ? far : 3e38);
  }
}

/// Over the block's cell, above its highest corner by the clearance.
bool starts_high(const TerrainBlock& block, double x_m, double y_m, double z_m) {
  const double u = (x_m - block.origin_x) * block.cells_per_m - block.first_column;
  const double v = (y_m - block.origin_y) * block.cells_per_m - block.first_row;
  if (!(u >= 0 && v >= 0 && u < block.columns && v < block.rows)) return false;
  const std::uint32_t i = block.first_column + static_cast<std::uint32_t>(u);
  const std::uint32_t j = block.first_row + static_cast<std::uint32_t>(v);
  const float* near = block.heights_m + j * block.row_length + i;
  const float* next = near + block.row_length;
  const float one = near[0] > near[1] ? near[0] : near[1], two = next[0] > next[1] ? next[0] : next[1];
  return z_m > (one > two ? one : two) + block.clearance_m;
}

void find_low(const TerrainBlock& block, const LaneRays& rays, std::int32_t* low) {
  const double x = rays.origin_x[0], y = rays.origin_y[0], z = rays.origin_z[0];
  std::int32_t apart = 0;
  for (int k = 0; k < kLanes; ++k) {
    apart |= (rays.origin_x[k] != x) | (rays.origin_y[k] != y) | (rays.origin_z[k] != z);
  }
  const std::int32_t first = starts_high(block, x, y, z) ? 0 : -1;
  for (int k = 0; k < kLanes; ++k) low[k] = first & rays.active[k];
  if (apart == 0) return;
  for (int k = 1; k < kLanes; ++k) {
    low[k] = starts_high(block, rays.origin_x[k], rays.origin_y[k], rays.origin_z[k]) ? 0 : rays.active[k];
  }
}

void may_meet_round(const LaneRays& rays, const double* point_m, const double* axis, double radius_m,
                    std::int32_t* passes) {
  const double px = point_m[0], py = point_m[1], pz = point_m[2], ax = axis[0], ay = axis[1], az = axis[2];
  const double limit = radius_m * radius_m * (1 + 1e-9);
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const double x = rays.origin_x[k] - px, y = rays.origin_y[k] - py, z = rays.origin_z[k] - pz;
    const double dx = rays.direction_x[k], dy = rays.direction_y[k], dz = rays.direction_z[k];
    const double along = x * ax + y * ay + z * az, turn = dx * ax + dy * ay + dz * az;
    const double sx = x - along * ax, sy = y - along * ay, sz = z - along * az;  // off the axis
    const double tx = dx - turn * ax, ty = dy - turn * ay, tz = dz - turn * az;
    const double closest = -(sx * tx + sy * ty + sz * tz) / (tx * tx + ty * ty + tz * tz);
    const double cx = sx + closest * tx, cy = sy + closest * ty, cz = sz + closest * tz;
    passes[k] = cx * cx + cy * cy + cz * cz > limit ? 0 : -1;  // along the axis: not a number, which passes
  }
}

int name_triangles(const NamedLanes& named, std::uint32_t crossed, std::uint32_t plain, std::uint32_t* primitive,
                   std::uint32_t* triangle, std::int32_t* wanted) {
  std::int32_t any_crossed = 0, any_plain = 0;
#pragma GCC ivdep  // what is read and what is written are apart
  for (int k = 0; k < kLanes; ++k) {
    const std::int32_t is_plain = named.geometry[k] == plain ? -1 : 0;
    const std::int32_t is_crossed = named.geometry[k] == crossed ? -1 : 0;
    const std::uint32_t second = named.u[k] + named.v[k] > 1 ? 1 : 0;
    const std::uint32_t number = 2 * named.primitive[k] + second;
    primitive[k] = (is_plain | is_crossed) != 0 ? number : named.primitive[k];
    triangle[k] = number & static_cast<std::uint32_t>(is_plain);
    wanted[k] = is_plain;
    any_crossed |= is_crossed;
    any_plain |= is_plain;
  }
  return (any_crossed & 1) | (any_plain & 2);
}

bool label(const std::uint32_t* geometry, std::uint32_t plain, const std::int32_t* met, std::uint32_t* label) {
  std::int32_t open = 0;
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const std::int32_t done = (geometry[k] == plain ? -1 : 0) & met[k];
    label[k] = plain & static_cast<std::uint32_t>(done);
    open |= ~done & (geometry[k] == ~0u ? 0 : -1);
  }
  return open == 0;
}

void locate(const TerrainBlock& block, const std::uint32_t* triangles, TerrainPlaces& places) {
  // Column and row by a multiplication: exact for whole numbers below 2^31, as half a cell is added.
  const double per_column = 1.0 / block.columns;
  const auto columns = static_cast<std::int32_t>(block.columns);
  const auto first_column = static_cast<std::int32_t>(block.first_column);
  const auto first_row = static_cast<std::int32_t>(block.first_row);
  const auto row_length = static_cast<std::int32_t>(block.row_length);
  for (int k = 0; k < kLanes; ++k) {
    const auto cell = static_cast<std::int32_t>(triangles[k] >> 1);
    const auto far_corner = static_cast<std::int32_t>(triangles[k] & 1);
    const auto j = static_cast<std::int32_t>((cell + 0.5) * per_column);
    const std::int32_t u = cell - j * columns + first_column + far_corner;
    const std::int32_t v = j + first_row + far_corner;
    places.vertex[k] = v * row_length + u;
    places.far_corner[k] = far_corner;
    places.column[k] = u;
    places.row[k] = v;
  }
  for (int k = 0; k < kLanes; ++k) {
    const float* height = block.heights_m + places.vertex[k];
    __builtin_prefetch(height);
    __builtin_prefetch(height + (1 - 2 * places.far_corner[k]) * row_length);
  }
}

void solve(const TerrainBlock& block, const TerrainPlaces& places, const LaneRays& rays, const LaneHits& hits) {
  alignas(64) float here[kLanes], along_x[kLanes], along_y[kLanes];
  const auto row_length = static_cast<std::int32_t>(block.row_length);
  for (int k = 0; k < kLanes; ++k) {
    const std::int32_t step = 1 - 2 * places.far_corner[k];
    here[k] = block.heights_m[places.vertex[k]];
    along_x[k] = block.heights_m[places.vertex[k] + step];
    along_y[k] = block.heights_m[places.vertex[k] + step * row_length];
  }
  const double scale = block.cells_per_m, margin = block.margin_cells;
#pragma GCC ivdep  // what is read and what is written are apart
  for (int k = 0; k < kLanes; ++k) {
    const double side = 1 - 2 * places.far_corner[k];
    const double slope_x = side * (static_cast<double>(along_x[k]) - here[k]);  // metres a cell
    const double slope_y = side * (static_cast<double>(along_y[k]) - here[k]);
    const double u = (rays.origin_x[k] - block.origin_x) * scale - places.column[k];
    const double v = (rays.origin_y[k] - block.origin_y) * scale - places.row[k];
    const double du = rays.direction_x[k] * scale, dv = rays.direction_y[k] * scale;
    const double distance =
        (here[k] + slope_x * u + slope_y * v - rays.origin_z[k]) / (rays.direction_z[k] - slope_x * du - slope_y * dv);
    const double a = side * (u + distance * du), b = side * (v + distance * dv);
    const double tilt_x = slope_x * scale, tilt_y = slope_y * scale;
    const double upright = 1 / std::sqrt(1 + tilt_x * tilt_x + tilt_y * tilt_y);
    const bool met = (a >= margin) & (b >= margin) & (a + b <= 1 - margin) & (distance >= 0) &
                     (distance <= rays.far_m[k]) & (places.wanted[k] != 0);
    hits.distance_m[k] = met ? distance : __builtin_inf();
    hits.normal_x[k] = met ? -tilt_x * upright : 0;
    hits.normal_y[k] = met ? -tilt_y * upright : 0;
    hits.normal_z[k] = met ? upright : 0;
    hits.met[k] = -static_cast<std::int32_t>(met);
  }
}

constexpr RayKernels kKernels{&all_near,       &find_low, &to_float, &may_meet_round,
                              &name_triangles, &locate,   &solve,    &label};

}  // namespace
}  // namespace uwsim
