#include "uwsim/world/same_surfaces.h"

#include <algorithm>

namespace uwsim {
namespace {

bool are_same(const Heightfield& one, const Heightfield& other) {
  return one.nx() == other.nx() && one.spacing_m() == other.spacing_m() && one.origin_m() == other.origin_m() &&
         one.heights_m() == other.heights_m();
}

bool are_same(const RoundShape& one, const RoundShape& other) {
  const auto same_ends = [](const RoundShape::End& a, const RoundShape::End& b) {
    return a.point_world_m == b.point_world_m && a.outward == b.outward && a.capped == b.capped;
  };
  return one.radius_m == other.radius_m && one.axis == other.axis &&
         std::ranges::equal(one.ends, other.ends, same_ends);
}

bool are_same(const Solid& one, const Solid& other) {
  const auto same_shapes = [](const RoundShape& a, const RoundShape& b) { return are_same(a, b); };
  return one.mesh_world.vertices_m == other.mesh_world.vertices_m &&
         one.mesh_world.triangles == other.mesh_world.triangles &&
         std::ranges::equal(one.shapes, other.shapes, same_shapes);
}

bool are_same(const CoverRange& one, const CoverRange& other) { return one.low == other.low && one.high == other.high; }

bool are_same(const CoverLayer& one, const CoverLayer& other) {
  const auto same_meshes = [](const TriangleMesh& a, const TriangleMesh& b) {
    return a.vertices_m == b.vertices_m && a.triangles == b.triangles;
  };
  return std::ranges::equal(one.meshes, other.meshes, same_meshes) && one.name == other.name &&
         one.stance == other.stance && one.sunk == other.sunk && one.density_per_m2 == other.density_per_m2 &&
         are_same(one.size_m, other.size_m) && one.size_exponent == other.size_exponent &&
         are_same(one.depth_m, other.depth_m) && are_same(one.slope_rad, other.slope_rad) &&
         are_same(one.from_solids_m, other.from_solids_m) && one.patch_m == other.patch_m &&
         one.patch_share == other.patch_share && one.seed == other.seed && one.solid == other.solid &&
         one.drag_coefficient == other.drag_coefficient && one.leans_at_m_s == other.leans_at_m_s;
}

/// Whether both are null, or point to the same surface.
template <typename Surface>
bool point_to_same(const std::shared_ptr<const Surface>& one, const std::shared_ptr<const Surface>& other) {
  return one == other || (one && other && are_same(*one, *other));
}

}  // namespace

bool have_same_surfaces(const World& one, const World& other) {
  const auto same = [](const auto& a, const auto& b) { return point_to_same(a, b); };
  return point_to_same(one.terrain(), other.terrain()) && std::ranges::equal(one.solids(), other.solids(), same) &&
         std::ranges::equal(one.cover(), other.cover(), same);
}

}  // namespace uwsim
