#pragma once

#include <cstddef>

#include "uwsim/camera/kernel.h"
#include "uwsim/camera/lanes.h"

/// From pixels to rays and from hits to points. Included by kernel_*.cpp only.
namespace uwsim::camera {
namespace {

UWSIM_LANES Vector load(const Row3& row) { return {load(row.x.at), load(row.y.at), load(row.z.at)}; }
UWSIM_LANES void store(Row3& row, Vector v) {
  store(row.x.at, v.x);
  store(row.y.at, v.y);
  store(row.z.at, v.z);
}
UWSIM_LANES Vector zero() { return {Float{}, Float{}, Float{}}; }
UWSIM_LANES Vector ones() { return {splat(1), splat(1), splat(1)}; }

/// Turbulent water bends rays a little: three waves over the picture that move with time. A look, not a measured model.
UWSIM_LANES void wobble(const Shot& shot, Float& x, Float& y) {
  const float t = shot.wobble_phase, a = shot.wobble_rad;
  const Float first = sine(x * 23.0f + y * 11.0f + 2.1f * t), second = sine(y * 31.0f - x * 7.0f + 2.9f * t + 1.3f);
  const Float third = sine((x + y) * 47.0f - 4.3f * t + 0.7f);
  x += a * (first + 0.5f * third);
  y += a * (second - 0.5f * third);
}

UWSIM_LANES void aim_at(const Shot& shot, Float x, Float y, Block& block) {
  if (shot.wobble_rad > 0) wobble(shot, x, y);
  const Vector ray = spread(shot.right) * x + spread(shot.down) * y + spread(shot.ahead);
  store(block.direction, unit(ray));
  store(block.origin, zero());
}

/// Before the first piece of each ray: all of later light reaches the eye.
void open_eye(const Shot& shot, Block& block) {
  store(block.through, ones());
  store(block.light, zero());
  store(block.veil_beam, zero());
  store(block.wet.at, Int(shot.camera_wet ? -1 : 0));
}

/// Lane k is pixel (left + scale (k % 4), top + scale (k / 4)); those beyond the picture's edge are idle and repeat the
/// edge.
void aim_pixels(const Shot& shot, int left, int top, int scale, Block& block) {
  Float x, y;
  for (int k = 0; k < kLanes; ++k) {
    const int u = left + scale * (k % kBlockSide), v = top + scale * (k / kBlockSide);
    block.active.at[k] = u < shot.width && v < shot.height ? -1 : 0;
    const int row = v < shot.height ? v : shot.height - 1, column = u < shot.width ? u : shot.width - 1;
    x[k] = shot.ray_x[row * shot.width + column];
    y[k] = shot.ray_y[row * shot.width + column];
  }
  aim_at(shot, x, y, block);
}

/// Whether no pixel of the block lies beyond the picture's edge: most blocks, which go row by row.
UWSIM_LANES bool is_whole(const Shot& shot, int left, int top) {
  return left + kBlockSide <= shot.width && top + kBlockSide <= shot.height;
}

void aim(const Shot& shot, int left, int top, Block& block) {
  if (!is_whole(shot, left, top)) return aim_pixels(shot, left, top, 1, block);
  const std::size_t columns = static_cast<std::size_t>(shot.width) / kBlockSide;
  const std::size_t at = kBlockPixels * (static_cast<std::size_t>(top) / kBlockSide * columns + left / kBlockSide);
  // Traversal in between makes the CPU forget where the tables were read.
  __builtin_prefetch(shot.block_ray_x + at + kBlockPixels);
  __builtin_prefetch(shot.block_ray_y + at + kBlockPixels);
  store(block.active.at, Int(-1));
  aim_at(shot, load(shot.block_ray_x + at), load(shot.block_ray_y + at), block);
}

void aim_shafts(const Shot& shot, int left, int top, int scale, Block& block) {
  aim_pixels(shot, left, top, scale, block);
}

UWSIM_LANES Double to_double(Float x) { return widened<double>(x); }
UWSIM_LANES Float to_single(Double x) { return narrowed<float>(x); }
UWSIM_LANES Float gather(const float* from, Int index) {
  Float value;
  for (int k = 0; k < kLanes; ++k) value[k] = from[index[k]];
  return value;
}

struct Facet {
  Double height, slope_x, slope_y, node_x, node_y;
};

/// The plane of each lane's terrain triangle: through a node at `height`. Lanes that are not on terrain get the first.
UWSIM_LANES Facet facets(const Shot& shot, const std::uint32_t* primitive, Int on_terrain) {
  Unsigned number;
  __builtin_memcpy(number.part, primitive, sizeof(number.part));
  const Int triangle = bits_as<std::int32_t>(number) & on_terrain;
  const Int upper = triangle & 1, cell = triangle >> 1, is_upper = upper == 1;
  const int row = shot.terrain_nx - 1;
  Int j = to_int(to_float(cell) * (1 / static_cast<float>(row)));  // off by one at most
  j += (j * row > cell);
  j -= ((j + 1) * row <= cell);
  const Int i = cell - j * row, corner = j * shot.terrain_nx + i;
  const Int base_at = select(is_upper, corner + (shot.terrain_nx + 1), corner);
  const Double base = to_double(gather(shot.heights, base_at));
  const Double sign = to_double(select(is_upper, splat(-1), splat(1)));
  const Double beside_x = to_double(gather(shot.heights, select(is_upper, corner + shot.terrain_nx, corner + 1)));
  const Double beside_y = to_double(gather(shot.heights, select(is_upper, corner + 1, corner + shot.terrain_nx)));
  const Double per_m = sign * (1 / shot.terrain_spacing);
  return {base, (beside_x - base) * per_m, (beside_y - base) * per_m, to_double(to_float(i + upper)),
          to_double(to_float(j + upper))};
}

/// On terrain the distance is solved again in double over the plane of the triangle that was named: floats err by 1e-4
/// m.
UWSIM_LANES void solve_terrain(const Shot& shot, Vector origin, Vector way, Int on_terrain, Block& block,
                               Float& distance, Vector& normal) {
  const Facet f = facets(shot, block.primitive, on_terrain);
  const Double x = to_double(origin.x) - (shot.terrain_x + f.node_x * shot.terrain_spacing);
  const Double y = to_double(origin.y) - (shot.terrain_y + f.node_y * shot.terrain_spacing);
  const Double above = shot.anchor_z + to_double(origin.z) - (f.height + f.slope_x * x + f.slope_y * y);
  const Double sinking = f.slope_x * to_double(way.x) + f.slope_y * to_double(way.y) - to_double(way.z);
  const Vector facing = unit({to_single(-f.slope_x), to_single(-f.slope_y), splat(1)});
  // Within 0.1 degree of tangency the plane says less about the distance than the ray tree does.
  const Int solvable = on_terrain & (abs(to_single(sinking)) * facing.z > 1.7e-3f);
  distance = select(solvable, max(to_single(above / sinking), Float{}), distance);
  normal = select(on_terrain, facing, normal);
}

void place(const Shot& shot, Block& block) {
  const Vector origin = load(block.origin), way = load(block.direction);
  Float distance = load(block.distance.at);
  Unsigned label;
  __builtin_memcpy(label.part, block.label, sizeof(label.part));
  const Int hit = distance < 1e30f;
  const Int on_terrain = hit & (label == shot.terrain_label);
  Vector normal = unit(load(block.normal));
  if (shot.heights != nullptr && any(on_terrain)) {
    solve_terrain(shot, origin, way, on_terrain, block, distance, normal);
  }
  store(block.distance.at, distance);
  store(block.point, origin + way * select(hit, distance, Float{}));
  store(block.normal, select(hit, normal, zero()));
}

UWSIM_LANES void write_part(const Shot& shot, int left, int top, int columns, int rows, const float* depth,
                            const Block& block, const GeometryPlanes& planes) {
  for (int row = 0; row < rows; ++row) {
    const std::size_t at = static_cast<std::size_t>(top + row) * shot.width + left;
    const int lane = row * kBlockSide;
    float* normals = planes.normals + 3 * at;
    for (int k = 0; k < columns; ++k) {
      const std::uint32_t label = block.label[lane + k];
      planes.depth[at + k] = depth[lane + k];
      normals[3 * k] = block.normal.x.at[lane + k];
      normals[3 * k + 1] = block.normal.y.at[lane + k];
      normals[3 * k + 2] = block.normal.z.at[lane + k];
      planes.labels[at + k] = static_cast<std::uint16_t>(label);
      planes.classes[at + k] = planes.class_of_label[label];
    }
  }
}

/// Depth along the optical axis, normals, labels and classes to their pictures.
void write_geometry(const Shot& shot, int left, int top, const Block& block, const GeometryPlanes& planes) {
  alignas(64) float depth[kLanes];
  store(depth, load(block.distance.at) * dot(load(block.direction), spread(shot.ahead)));
  if (is_whole(shot, left, top)) return write_part(shot, left, top, kBlockSide, kBlockSide, depth, block, planes);
  const int columns = shot.width - left < kBlockSide ? shot.width - left : kBlockSide;
  const int rows = shot.height - top < kBlockSide ? shot.height - top : kBlockSide;
  write_part(shot, left, top, columns, rows, depth, block, planes);
}

}  // namespace
}  // namespace uwsim::camera
