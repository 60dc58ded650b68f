#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "uwsim/core/kept_tiles.h"
#include "uwsim/rays/cover_tile.h"
#include "uwsim/rays/embree_tree.h"
#include "uwsim/rays/ray_packet.h"
#include "uwsim/world/cover_plan.h"

namespace uwsim {

/// A world's cover as a target of rays. Each mesh has one tree of Embree, and each tile a tree of instances of them,
/// which is built when a ray first comes near the tile. Tiles that were not needed for long are released when the
/// pieces in memory exceed a limit, so that memory depends on the number of kinds, and not on the size of the world.
/// Thread-safe.
class CoverTrees {
 public:
  /// The pieces in memory, at about 0.5 kB each, above which tiles are released.
  static constexpr std::size_t kMostPieces = 1'000'000;

  CoverTrees(RTCDeviceTy* device, const World& surfaces, std::size_t most_pieces = kMostPieces);

  // With `sway`, plants lean; if it is null, they stand upright.

  /// Replaces each hit by a hit on a piece if that is nearer. Embree finds the piece and its triangle in float; the
  /// distance and the normal are computed in double, on that triangle.
  void cast(std::span<const ExactRays> rays, const std::shared_ptr<const Sway>& sway, std::span<ExactHits> hits) const;
  /// The same for pictures; sets the number of the piece and the smooth normal as well.
  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder order,
            const std::shared_ptr<const Sway>& sway, HitPacket& hits) const;
  /// Marks the lanes that a piece blocks.
  void occlude(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder order,
               const std::shared_ptr<const Sway>& sway, Blocked& blocked) const;
  /// The smaller of `nearest_m` and the distance to the nearest triangle of a piece.
  double distance(const Eigen::Vector3d& point_world_m, const std::shared_ptr<const Sway>& sway,
                  double nearest_m) const;

  /// The rotation times size of the piece with a number, upright; the identity if there is none.
  Eigen::Matrix3f turn_of(std::uint32_t piece) const;
  const CoverPlan& plan() const { return plan_; }
  std::size_t pieces_in_memory() const { return tiles_.items(); }

 private:
  using InUse = KeptTiles<CoverTile>::InUse;
  struct Walk;

  Eigen::AlignedBox3d box_of(std::uint32_t column, std::uint32_t row) const;
  const CoverTile& tile(std::uint32_t column, std::uint32_t row) const;
  template <typename Visit>
  void for_each_tile(Walk& walk, const std::shared_ptr<const Sway>& sway, const Visit& visit) const;

  RTCDeviceTy* device_;
  CoverPlan plan_;
  double reach_m_;  ///< how far a piece extends at most from its origin
  Label first_label_;
  std::vector<std::shared_ptr<const CoverLayer>> layers_;
  std::vector<CoverShape> shapes_;            ///< of all layers
  double lowest_m_, highest_m_;               ///< of the terrain
  std::vector<Eigen::AlignedBox1d> heights_;  ///< of the tiles that are not in memory: bounds of their pieces' z
  KeptTiles<CoverTile> tiles_;
};

}  // namespace uwsim
