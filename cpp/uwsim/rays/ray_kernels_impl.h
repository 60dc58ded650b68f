#pragma once

#include <cmath>
#include <cstdint>

#include "uwsim/rays/ray_kernels.h"
#include "uwsim/rays/terrain_hit.h"
#include "uwsim/rays/tolerances.h"

// The kernels of ray_kernels.h, as plain loops that compilers can vectorise. They are compiled once for each
// instruction set, hence the anonymous namespace. `ivdep` asserts that inputs and outputs do not overlap.
namespace uwsim {
namespace {

constexpr int kLanes = 16;

bool all_near(const LaneRays& rays, const double* middle_m, double distance_m) {
  alignas(64) std::int32_t away[kLanes];
  const double x = middle_m[0], y = middle_m[1], z = middle_m[2];
  for (int k = 0; k < kLanes; ++k) {
    const bool near = (std::fabs(rays.origin_x[k] - x) <= distance_m) &
                      (std::fabs(rays.origin_y[k] - y) <= distance_m) & (std::fabs(rays.origin_z[k] - z) <= distance_m);
    away[k] = near ? 0 : -1;
  }
  std::int32_t any = 0;
  for (int k = 0; k < kLanes; ++k) any |= away[k] & rays.active[k];
  return any == 0;
}

void to_float(const LaneRays& rays, const double* middle_m, double setback_m, const LaneFloats& floats) {
  constexpr double kLargest = 3e38;  // the largest value converted to float, so that it stays finite
  const double x = middle_m[0], y = middle_m[1], z = middle_m[2];
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    floats.origin_x[k] = static_cast<float>(rays.origin_x[k] - setback_m * rays.direction_x[k] - x);
    floats.origin_y[k] = static_cast<float>(rays.origin_y[k] - setback_m * rays.direction_y[k] - y);
    floats.origin_z[k] = static_cast<float>(rays.origin_z[k] - setback_m * rays.direction_z[k] - z);
    floats.direction_x[k] = static_cast<float>(rays.direction_x[k]);
    floats.direction_y[k] = static_cast<float>(rays.direction_y[k]);
    floats.direction_z[k] = static_cast<float>(rays.direction_z[k]);
    const double far = (rays.far_m[k] + setback_m) * (1 + kFartherRelative) + kFarther_m;
    floats.far_m[k] = static_cast<float>(far < kLargest ? far : kLargest);
  }
}

void fill_packet(const float* rays, const float* near_m, const float* far_m, const std::int32_t* active,
                 const float* shift, float* packet) {
  enum Row { kOrigin = 0, kNear = 3, kDirection = 4, kTime = 7, kFar = 8, kMask = 9, kId = 10, kFlags = 11 };
  auto* const words = reinterpret_cast<std::uint32_t*>(packet);
  const float x = shift[0], y = shift[1], z = shift[2];
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const bool idle = active[k] == 0;
    const float origin_x = x + rays[k], origin_y = y + rays[kLanes + k], origin_z = z + rays[2 * kLanes + k];
    const float direction_x = rays[3 * kLanes + k], direction_y = rays[4 * kLanes + k];
    const float direction_z = rays[5 * kLanes + k], near = near_m[k], far = far_m[k];
    packet[kOrigin * kLanes + k] = idle ? 0 : origin_x;
    packet[(kOrigin + 1) * kLanes + k] = idle ? 0 : origin_y;
    packet[(kOrigin + 2) * kLanes + k] = idle ? 0 : origin_z;
    packet[kNear * kLanes + k] = idle ? 0 : near;
    packet[kDirection * kLanes + k] = idle ? 0 : direction_x;
    packet[(kDirection + 1) * kLanes + k] = idle ? 0 : direction_y;
    packet[(kDirection + 2) * kLanes + k] = idle ? 1 : direction_z;
    packet[kTime * kLanes + k] = 0;
    packet[kFar * kLanes + k] = idle ? 0 : far;
  }
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    words[kMask * kLanes + k] = ~0u;
    words[kId * kLanes + k] = static_cast<std::uint32_t>(k);
    words[kFlags * kLanes + k] = 0;
  }
}

/// Whether the point is over the block and higher than all corners of the cell there by the clearance.
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

void find_low_starts(const TerrainBlock& block, const LaneRays& rays, std::int32_t* low) {
  // Most packets share one origin.
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
  const double limit = radius_m * radius_m * (1 + kRoundMargin);
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const double x = rays.origin_x[k] - px, y = rays.origin_y[k] - py, z = rays.origin_z[k] - pz;
    const double dx = rays.direction_x[k], dy = rays.direction_y[k], dz = rays.direction_z[k];
    const double along = x * ax + y * ay + z * az, gain = dx * ax + dy * ay + dz * az;
    const double sx = x - along * ax, sy = y - along * ay, sz = z - along * az;  // distance from the axis
    const double tx = dx - gain * ax, ty = dy - gain * ay, tz = dz - gain * az;
    const double closest = -(sx * tx + sy * ty + sz * tz) / (tx * tx + ty * ty + tz * tz);
    const double cx = sx + closest * tx, cy = sy + closest * ty, cz = sz + closest * tz;
    passes[k] = cx * cx + cy * cy + cz * cz > limit ? 0 : -1;  // NaN along the axis, which counts as passing
  }
}

void meet_wall(const LaneRays& rays, const double* near_m, const LaneWall& wall, const LaneHits& hits) {
  const double ax = wall.axis[0], ay = wall.axis[1], az = wall.axis[2], radius = wall.radius_m, seam = wall.seam_m;
  const double px = wall.points_m[0][0], py = wall.points_m[0][1], pz = wall.points_m[0][2];
  const double qx = wall.points_m[1][0], qy = wall.points_m[1][1], qz = wall.points_m[1][2];
  const double ux = wall.outwards[0][0], uy = wall.outwards[0][1], uz = wall.outwards[0][2];
  const double vx = wall.outwards[1][0], vy = wall.outwards[1][1], vz = wall.outwards[1][2];
  const double along_axis = wall.along_axis;
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const double ox = rays.origin_x[k], oy = rays.origin_y[k], oz = rays.origin_z[k];
    const double dx = rays.direction_x[k], dy = rays.direction_y[k], dz = rays.direction_z[k];
    const double x = ox - px, y = oy - py, z = oz - pz;
    const double along = ax * x + ay * y + az * z, gain = ax * dx + ay * dy + az * dz;
    const double sx = x - along * ax, sy = y - along * ay, sz = z - along * az;  // distance from the axis
    const double tx = dx - gain * ax, ty = dy - gain * ay, tz = dz - gain * az;
    const double sine_squared = tx * tx + ty * ty + tz * tz;
    const double closest = -(sx * tx + sy * ty + sz * tz) / sine_squared;
    const double cx = sx + closest * tx, cy = sy + closest * ty, cz = sz + closest * tz;
    const double half_chord = std::sqrt((radius * radius - (cx * cx + cy * cy + cz * cz)) / sine_squared);
    const auto accepts = [&](double distance) {  // false for NaN
      const double hx = ox + distance * dx, hy = oy + distance * dy, hz = oz + distance * dz;
      return (distance >= near_m[k]) & (distance <= rays.far_m[k]) &
             (ux * (hx - px) + uy * (hy - py) + uz * (hz - pz) <= seam) &
             (vx * (hx - qx) + vy * (hy - qy) + vz * (hz - qz) <= seam);
    };
    const double first = closest - half_chord, second = closest + half_chord;
    const bool meets_first = accepts(first), meets = meets_first | accepts(second);
    const double distance = meets_first ? first : second;
    hits.distance_m[k] = distance;
    hits.normal_x[k] = (cx + (distance - closest) * tx) / radius;
    hits.normal_y[k] = (cy + (distance - closest) * ty) / radius;
    hits.normal_z[k] = (cz + (distance - closest) * tz) / radius;
    hits.met[k] = sine_squared < along_axis ? kAlong : meets ? kMeets : kMisses;
  }
}

int number_terrain(const LaneAnswers& answers, std::uint32_t near_solids, std::uint32_t open, std::uint32_t* primitive,
                   TerrainLanes& terrain) {
  std::int32_t any_near_solids = 0, any_open = 0;
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const std::int32_t is_open = answers.geometry[k] == open ? -1 : 0;
    const std::int32_t is_near_solids = answers.geometry[k] == near_solids ? -1 : 0;
    const std::uint32_t second = answers.u[k] + answers.v[k] > 1 ? 1 : 0;
    const std::uint32_t number = 2 * answers.primitive[k] + second;
    primitive[k] = (is_open | is_near_solids) != 0 ? number : answers.primitive[k];
    terrain.triangle[k] = number & static_cast<std::uint32_t>(is_open);
    terrain.on_terrain[k] = is_open;
    any_near_solids |= is_near_solids;
    any_open |= is_open;
  }
  return (any_near_solids & 1) | (any_open & 2);
}

bool complete_floats(const LaneFloatHits& hits, std::uint32_t terrain, float raise_m) {
  constexpr auto kLeastSine = static_cast<float>(kGrazingSine);
  std::int32_t any_other = 0;
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const std::uint32_t geometry = hits.geometry[k];
    const bool met = geometry != kNoGeometry, on_terrain = geometry <= terrain;
    const float u = hits.u[k], v = hits.v[k], distance = hits.distance_m[k];
    const bool second = u + v > 1;  // the corners of the second triangle are the quad's second, third and fourth
    const std::uint32_t number = 2 * hits.primitive[k] + (second ? 1 : 0);
    hits.primitive[k] = on_terrain ? number : met ? hits.primitive[k] : 0;
    hits.u[k] = on_terrain & second ? u + v - 1 : u;
    hits.v[k] = on_terrain & second ? 1 - u : v;
    const float x = hits.normal_x[k], y = hits.normal_y[k], z = hits.normal_z[k];
    const float length = std::sqrt(x * x + y * y + z * z);
    const float sinking = -(x * hits.direction_x[k] + y * hits.direction_y[k] + z * hits.direction_z[k]) / length;
    const float lowered = distance + raise_m / sinking;
    const float steep = std::fabs(sinking) > kLeastSine ? (lowered > 0 ? lowered : 0.0f) : distance;
    hits.distance_m[k] = on_terrain ? steep : met ? distance : __builtin_inff();
    hits.label[k] = on_terrain ? terrain : met ? geometry : 0;
    any_other |= (met ? -1 : 0) & (geometry == terrain ? 0 : -1);
  }
  return any_other != 0;
}

void locate_heights(const TerrainBlock& block, TerrainLanes& terrain) {
  // Compute column and row by multiplication instead of division. This is exact for integers below 2^31, because half a
  // cell is added.
  const double per_column = 1.0 / block.columns;
  const auto columns = static_cast<std::int32_t>(block.columns);
  const auto first_column = static_cast<std::int32_t>(block.first_column);
  const auto first_row = static_cast<std::int32_t>(block.first_row);
  const auto row_length = static_cast<std::int32_t>(block.row_length);
  for (int k = 0; k < kLanes; ++k) {
    const auto cell = static_cast<std::int32_t>(terrain.triangle[k] >> 1);
    const auto far_corner = static_cast<std::int32_t>(terrain.triangle[k] & 1);
    const auto j = static_cast<std::int32_t>((cell + 0.5) * per_column);
    const std::int32_t u = cell - j * columns + first_column + far_corner;
    const std::int32_t v = j + first_row + far_corner;
    terrain.vertex[k] = v * row_length + u;
    terrain.far_corner[k] = far_corner;
    terrain.column[k] = u;
    terrain.row[k] = v;
  }
  for (int k = 0; k < kLanes; ++k) {
    const float* height = block.heights_m + terrain.vertex[k];
    __builtin_prefetch(height);
    __builtin_prefetch(height + (1 - 2 * terrain.far_corner[k]) * row_length);
  }
}

void refine_terrain(const TerrainBlock& block, const TerrainLanes& terrain, const LaneRays& rays,
                    const LaneHits& hits) {
  alignas(64) float here[kLanes], along_x[kLanes], along_y[kLanes];
  const auto row_length = static_cast<std::int32_t>(block.row_length);
  for (int k = 0; k < kLanes; ++k) {
    const std::int32_t step = 1 - 2 * terrain.far_corner[k];
    here[k] = block.heights_m[terrain.vertex[k]];
    along_x[k] = block.heights_m[terrain.vertex[k] + step];
    along_y[k] = block.heights_m[terrain.vertex[k] + step * row_length];
  }
  const TerrainBlock grid = block;
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const TerrainTriangle triangle = terrain_triangle(1 - 2 * terrain.far_corner[k], terrain.column[k], terrain.row[k],
                                                      here[k], along_x[k], along_y[k]);
    const PlaneHit hit = meet_plane(triangle, grid, rays.origin_x[k], rays.origin_y[k], rays.origin_z[k],
                                    rays.direction_x[k], rays.direction_y[k], rays.direction_z[k]);
    const double tilt_x = triangle.slope_x * grid.cells_per_m, tilt_y = triangle.slope_y * grid.cells_per_m;
    const double upright = 1 / std::sqrt(1 + tilt_x * tilt_x + tilt_y * tilt_y);
    const bool met = (hit.a >= kCellMargin) & (hit.b >= kCellMargin) & (hit.a + hit.b <= 1 - kCellMargin) &
                     (hit.distance_m >= 0) & (hit.distance_m <= rays.far_m[k]) & (terrain.on_terrain[k] != 0);
    hits.distance_m[k] = met ? hit.distance_m : __builtin_inf();
    hits.normal_x[k] = met ? -tilt_x * upright : 0;
    hits.normal_y[k] = met ? -tilt_y * upright : 0;
    hits.normal_z[k] = met ? upright : 0;
    hits.met[k] = -static_cast<std::int32_t>(met);
  }
}

bool label_terrain(const std::uint32_t* geometry, std::uint32_t open, const std::int32_t* met, std::uint32_t* label) {
  std::int32_t left = 0;
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const std::int32_t done = (geometry[k] == open ? -1 : 0) & met[k];
    label[k] = open & static_cast<std::uint32_t>(done);
    left |= ~done & (geometry[k] == kNoGeometry ? 0 : -1);
  }
  return left == 0;
}

double enter_box(const LaneSlabs& rays, const double* low, const double* high, double* first_m) {
  alignas(64) double first[kLanes], last[kLanes];
  for (int k = 0; k < kLanes; ++k) first[k] = rays.near_m[k], last[k] = rays.far_m[k];
  for (int axis = 0; axis < 3; ++axis) {
    const double *const origin = rays.origin[axis], *const inverse = rays.inverse[axis];
    const double below = low[axis], above = high[axis];
    for (int k = 0; k < kLanes; ++k) {
      const double one = (below - origin[k]) * inverse[k], two = (above - origin[k]) * inverse[k];
      // A ray in the plane of a side multiplies zero by infinity; that side then leaves the limits alone.
      const bool in_plane = (one != one) | (two != two);
      const double near = two < one ? two : one, far = one < two ? two : one;
      first[k] = !in_plane & (first[k] < near) ? near : first[k];
      last[k] = !in_plane & (far < last[k]) ? far : last[k];
    }
  }
  for (int k = 0; k < kLanes; ++k) {
    const bool enters = (rays.active[k] != 0) & (first[k] <= last[k]);
    first_m[k] = enters ? first[k] : __builtin_inf();
  }
  double least = __builtin_inf();
  for (int k = 0; k < kLanes; ++k) least = first_m[k] < least ? first_m[k] : least;
  return least;
}

/// Combines sixteen values: halves first, which vector units do at once, and in the same order everywhere.
template <typename Operation>
double folded(double (&values)[kLanes], const Operation& operation) {
  for (int half = kLanes / 2; half > 0; half /= 2) {
    for (int k = 0; k < half; ++k) values[k] = operation(values[k], values[k + half]);
  }
  return values[0];
}

template <typename Real>
LaneBundle bundle(const Real* rays, const Real* far_m, const Real* distance_m, const std::int32_t* active) {
  LaneBundle found{{1, 0, 0}, -1, 0, -__builtin_inf()};
  int first = 0;
  while (first < kLanes && active[first] == 0) ++first;
  if (first == kLanes) return found;
  const Real *const from = rays, *const along = rays + 3 * kLanes;
  const double x = from[first], y = from[kLanes + first], z = from[2 * kLanes + first];
  const double dx = along[first], dy = along[kLanes + first], dz = along[2 * kLanes + first];
  // Idle lanes repeat the first active one, so that the loops need no branches.
  alignas(64) double ways[3][kLanes], sums[3][kLanes], spread2[kLanes], cosines[kLanes], ends[kLanes];
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) {
    const bool idle = active[k] == 0;
    const double end = distance_m[k] < far_m[k] ? distance_m[k] : far_m[k];
    const double one = along[k], two = along[kLanes + k], three = along[2 * kLanes + k];
    const double aside_x = from[k] - x, aside_y = from[kLanes + k] - y, aside_z = from[2 * kLanes + k] - z;
    sums[0][k] = ways[0][k] = idle ? dx : one;
    sums[1][k] = ways[1][k] = idle ? dy : two;
    sums[2][k] = ways[2][k] = idle ? dz : three;
    spread2[k] = idle ? 0 : aside_x * aside_x + aside_y * aside_y + aside_z * aside_z;
    ends[k] = idle ? -__builtin_inf() : end;
  }
  const auto sum = [](double one, double two) { return one + two; };
  const auto least = [](double one, double two) { return two < one ? two : one; };
  const auto most = [](double one, double two) { return one < two ? two : one; };
  const double ax = folded(sums[0], sum), ay = folded(sums[1], sum), az = folded(sums[2], sum);
  found.spread2 = folded(spread2, most);
  found.far_m = folded(ends, most);
  const double length = std::sqrt(ax * ax + ay * ay + az * az);
  if (!(length > 0)) return found;
  const double axis_x = ax / length, axis_y = ay / length, axis_z = az / length;
#pragma GCC ivdep
  for (int k = 0; k < kLanes; ++k) cosines[k] = axis_x * ways[0][k] + axis_y * ways[1][k] + axis_z * ways[2][k];
  found.axis[0] = axis_x, found.axis[1] = axis_y, found.axis[2] = axis_z;
  found.cosine = folded(cosines, least);
  return found;
}

constexpr RayKernels kKernels{.all_near = &all_near,
                              .find_low_starts = &find_low_starts,
                              .to_float = &to_float,
                              .fill_packet = &fill_packet,
                              .may_meet_round = &may_meet_round,
                              .meet_wall = &meet_wall,
                              .number_terrain = &number_terrain,
                              .complete_floats = &complete_floats,
                              .locate_heights = &locate_heights,
                              .refine_terrain = &refine_terrain,
                              .label_terrain = &label_terrain,
                              .enter_box = &enter_box,
                              .bundle_floats = &bundle<float>,
                              .bundle_doubles = &bundle<double>};

}  // namespace
}  // namespace uwsim
