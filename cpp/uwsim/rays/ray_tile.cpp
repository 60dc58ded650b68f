#include "uwsim/rays/ray_tile.h"

#include <utility>

#include "uwsim/rays/embree_float_cast.h"
#include "uwsim/rays/embree_query.h"
#include "uwsim/rays/exact_cast.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/tile_trees.h"

namespace uwsim {
namespace {

/// Marks hits on round shapes with no mesh close to them: the callback has computed such hits in double.
void settle_round_hits(const TileTrees& trees, const RoundAnswer& answer, const RayPacket& rays, HitPacket& hits) {
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const std::uint32_t geometry = hits.label[k];
    if (rays.active[k] == 0 || geometry <= kTerrain || !trees.surfaces.is_round(geometry)) continue;
    if (!trees.is_crowded(geometry, answer.primitive[k])) hits.settled[k] = -1;
  }
}

}  // namespace

RayTile::RayTile(RTCDeviceTy* device, const World& world, TileContents contents)
    : trees_(std::make_unique<TileTrees>(device, world, std::move(contents))) {}
RayTile::~RayTile() = default;
RayTile::RayTile(RayTile&&) noexcept = default;
RayTile& RayTile::operator=(RayTile&&) noexcept = default;

const Eigen::AlignedBox3d& RayTile::box() const { return trees_->surfaces.box(); }

bool RayTile::is_near(const Eigen::Vector3d& point_world_m) const {
  return (point_world_m - trees_->surfaces.middle_m()).cwiseAbs().maxCoeff() <= trees_->surfaces.diagonal_m();
}

bool RayTile::is_near(std::span<const ExactRays> rays) const {
  const double* middle_m = trees_->surfaces.middle_m().data();
  for (const ExactRays& packet : rays) {
    if (!trees_->kernels.all_near(lanes_of(packet), middle_m, trees_->surfaces.diagonal_m())) return false;
  }
  return true;
}

void RayTile::cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
  cast_exact(*trees_, rays, hits);
}

void RayTile::cast(const ExactRays& rays, const double* starts_m, ExactHits& hits) const {
  cast_exact(*trees_, rays, starts_m, hits);
}

void RayTile::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* starts_m,
                   HitPacket& hits, RayOrder order) const {
  RTCSceneTy* tree = trees_->tree.get();
  hits.settled.fill(0);
  if (starts_m != nullptr) {
    return cast_float(tree, trees_->surfaces, anchor_world_m, rays, starts_m, nullptr, hits, order);
  }
  RoundAnswer answer(anchor_world_m, rays);
  cast_float(tree, trees_->surfaces, anchor_world_m, rays, nullptr, &answer, hits, order);
  if (answer.rays.made()) settle_round_hits(*trees_, answer, rays, hits);
}

void RayTile::occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* starts_m,
                       Blocked& blocked, RayOrder order) const {
  occluded_float(trees_->tree.get(), trees_->surfaces, anchor_world_m, rays, starts_m, blocked, order);
}

double RayTile::distance(const Eigen::Vector3d& point_world_m, double nearest_m) const {
  const double to_met = nearest_triangle_m(trees_->tree.get(), trees_->surfaces, false, point_world_m, nearest_m);
  return nearest_triangle_m(trees_->mesh_tree.get(), trees_->surfaces, true, point_world_m, to_met);
}

}  // namespace uwsim
