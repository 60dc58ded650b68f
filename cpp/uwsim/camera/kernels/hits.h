#pragma once

#include <cstddef>

#include "uwsim/camera/kernels/block_lanes.h"
#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/kernels/primary_rays.h"
#include "uwsim/camera/kernels/view.h"
#include "uwsim/rays/tolerances.h"

/// Conversion of ray hits to points, normals and the geometry images. Included only by the kernels.
namespace uwsim::camera {
namespace {

struct TerrainPlanes {
  Double height, slope_x, slope_y, node_x, node_y;
};

/// The plane of each lane's terrain triangle, through a node at `height`. Lanes that are not on terrain get the first
/// triangle's plane.
UWSIM_LANES TerrainPlanes terrain_planes(const View& view, const std::uint32_t* primitive, Int on_terrain) {
  Unsigned number;
  __builtin_memcpy(number.part, primitive, sizeof(number.part));
  const Int triangle = bits_as<std::int32_t>(number) & on_terrain;
  const Int upper = triangle & 1, cell = triangle >> 1, is_upper = upper == 1;
  const int row = view.terrain_nx - 1;
  // May be too large or too small by one, which is corrected below
  Int j = to_int(to_float(cell) * (1 / static_cast<float>(row)));
  j += (j * row > cell);
  j -= ((j + 1) * row <= cell);
  const Int i = cell - j * row, corner = j * view.terrain_nx + i;
  const Int base_at = select(is_upper, corner + (view.terrain_nx + 1), corner);
  const Double base = to_double(gather(view.heights, base_at));
  const Double sign = to_double(select(is_upper, splat(-1), splat(1)));
  const Float east = gather(view.heights + 1, corner), north = gather(view.heights + view.terrain_nx, corner);
  const Double beside_x = to_double(select(is_upper, north, east)), beside_y = to_double(select(is_upper, east, north));
  const Double per_m = sign * (1 / view.terrain_spacing);
  return {base, (beside_x - base) * per_m, (beside_y - base) * per_m, to_double(to_float(i + upper)),
          to_double(to_float(j + upper))};
}

/// Recomputes the distance to terrain in double, on the plane of the triangle that was hit; the error in single
/// precision is 1e-4 m.
UWSIM_LANES void refine_on_terrain(const View& view, Vector origin, Vector direction, Int on_terrain, Block& block,
                                   Float& distance, Vector& normal) {
  const TerrainPlanes f = terrain_planes(view, block.primitive, on_terrain);
  const Double x = to_double(origin.x) - (view.terrain_x + f.node_x * view.terrain_spacing);
  const Double y = to_double(origin.y) - (view.terrain_y + f.node_y * view.terrain_spacing);
  const Double above = view.anchor_z + to_double(origin.z) - (f.height + f.slope_x * x + f.slope_y * y);
  const Double sinking =
      f.slope_x * to_double(direction.x) + f.slope_y * to_double(direction.y) - to_double(direction.z);
  const Vector facing = unit({to_single(-f.slope_x), to_single(-f.slope_y), splat(1)});
  // Within 0.1 degree of tangency, the plane determines the distance less accurately than the ray tree does.
  const Int solvable = on_terrain & (abs(to_single(sinking)) * facing.z > static_cast<float>(kGrazingSine));
  distance = select(solvable, max(to_single(above / sinking), Float{}), distance);
  normal = select(on_terrain, facing, normal);
}

/// Computes point and normal of each hit from its distance, label and triangle; refines hits on terrain.
void locate_hits(const View& view, Block& block) {
  const Vector origin = load(block.origin), direction = load(block.direction);
  Float distance = load(block.distance.at);
  Unsigned label;
  __builtin_memcpy(label.part, block.label, sizeof(label.part));
  const Int hit = distance < 1e30f;
  const Int on_terrain = hit & (label == view.terrain_label);
  Vector normal = zero();
  if (view.heights == nullptr || any(hit & ~on_terrain)) normal = unit(load(block.normal));
  if (view.heights != nullptr && any(on_terrain)) {
    refine_on_terrain(view, origin, direction, on_terrain, block, distance, normal);
  }
  store(block.distance.at, distance);
  store(block.point, origin + direction * select(hit, distance, Float{}));
  store(block.normal, select(hit, normal, zero()));
}

UWSIM_LANES void write_part(const View& view, int left, int top, int columns, int rows, const float* depth,
                            const Block& block, const GeometryPlanes& planes) {
  for (int row = 0; row < rows; ++row) {
    const std::size_t at = static_cast<std::size_t>(top + row) * view.width + left;
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

/// Writes depth along the optical axis, normals, labels and classes to their images.
void write_geometry(const View& view, int left, int top, const Block& block, const GeometryPlanes& planes) {
  alignas(64) float depth[kLanes];
  store(depth, load(block.distance.at) * dot(load(block.direction), broadcast(view.ahead)));
  if (is_whole_block(view, left, top)) return write_part(view, left, top, kBlockSide, kBlockSide, depth, block, planes);
  const int columns = view.width - left < kBlockSide ? view.width - left : kBlockSide;
  const int rows = view.height - top < kBlockSide ? view.height - top : kBlockSide;
  write_part(view, left, top, columns, rows, depth, block, planes);
}

}  // namespace
}  // namespace uwsim::camera
