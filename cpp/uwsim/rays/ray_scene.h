#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "uwsim/rays/moving_bodies.h"
#include "uwsim/rays/ray_packet.h"
#include "uwsim/world/sway.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A half line from `origin_world_m` along the unit vector `direction_world`.
struct Ray {
  Eigen::Vector3d origin_world_m;
  Eigen::Vector3d direction_world;
};

struct RayHit {
  double distance_m;             ///< infinity if nothing is hit within range
  Eigen::Vector3f normal_world;  ///< unit, on the side from which the triangle's corners run counter-clockwise
  Label label;
};

/// A piece of cover.
struct PlacedPiece {
  Eigen::Vector3d position_world_m;  ///< of its mesh's origin
  double size_m;
  Label label;           ///< of its layer
  std::uint32_t number;  ///< as in HitPacket::piece
};

/// The world's fixed surfaces, prepared for ray casting, and optionally bodies that move among them. Embree searches
/// the surfaces in single precision, in tiles of at most 1 km, each relative to its own centre. The hits that it finds
/// are recomputed in double precision on the world's original triangles and shapes, so each is truly the first hit,
/// anywhere in the world and however large the world is. Within about 0.1 degree of tangency, single-precision error
/// may decide whether a ray grazes or misses. README.md explains the method and the size of the remaining errors.
/// Thread-safe. Copies are cheap: they share the surfaces. Embree's trees are built by `prepare` or, without it, by the
/// first ray, so that a scene in which no ray is cast costs nothing.
class RayScene {
 public:
  explicit RayScene(const World& world);

  /// Builds the trees of the fixed surfaces, unless they exist: 0.4 s of processor time for two million triangles.
  /// Callers that will cast rays call it before they start, so that a lack of memory is reported early and the first
  /// ray takes no longer than the others. Throws InvalidValue if Embree cannot build them.
  void prepare() const;

  /// Returns a scene with the same surfaces and these bodies (null for none) instead of the present ones. Each cast
  /// uses the bodies' poses at that time and ignores the body `hidden`, such as the vehicle that carries the sensor.
  RayScene with(std::shared_ptr<const MovingBodies> bodies, std::size_t hidden = MovingBodies::kNone) const;
  /// Returns the same scene with plants that lean so; null: they stand upright.
  RayScene with_plants(std::shared_ptr<const Sway> sway) const;
  /// Returns true if plants lean, as they do only at one time.
  bool sways() const { return sway_ != nullptr; }
  /// Whether any of the cone's rays may hit a body; conservative.
  bool bodies_in(const RayCone& cone) const;

  /// Sets hits[k] to the point where rays[k] first hits a surface within `max_range_m`; a non-finite ray hits nothing.
  /// The result does not depend on the number of threads.
  void cast(std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits, int threads = 1) const;
  RayHit cast(const Ray& ray, double max_range_m) const;

  /// The same for packets of sixteen rays, which need no conversion. Casting several packets together is faster than
  /// casting them one at a time.
  void cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const;

  /// Returns Embree's unrefined answer in float, for pictures, at no more than Embree's own cost. Distances have an
  /// error of about 1e-4 m. A ray that passes a silhouette within half a millionth of half the tile's diagonal may be
  /// on the wrong side of it. At the silhouette of terrain, this limit is multiplied by 1 / cosine of the slope: it is
  /// up to 0.2 mm at the lake's hills, and a few millimetres at cliffs of 24 in 1 in a tile 1 km wide.
  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, HitPacket& hits,
            RayOrder order = RayOrder::kIncoherent) const;
  /// Whether each ray is blocked between its limits; idle lanes are not.
  void occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, Blocked& blocked,
                RayOrder order = RayOrder::kIncoherent) const;

  /// How the mesh of a hit lies in the world: rotation times size, for the label and the piece of a HitPacket.
  Eigen::Matrix3f mesh_turn(Label label, std::uint32_t piece) const;

  /// A point in the frame of the mesh of a body; the world's frame for other labels.
  Eigen::Vector3d on_mesh(Label label, const Eigen::Vector3d& point_world_m) const;

  /// The terrain; null if there is none.
  const Heightfield* terrain() const;
  /// Whether the point lies on or below the terrain; false outside its extent.
  bool under_ground(const Eigen::Vector3d& point_world_m) const;

  /// The pieces of cover whose origins lie in an area.
  std::vector<PlacedPiece> cover_in(const Eigen::AlignedBox2d& area_world_m) const;

  /// Whether the point lies in a round shape, deeper than `depth_m`. Since shapes are closed, no ray from outside comes
  /// closer to such a point than `depth_m`.
  bool within_round(const Eigen::Vector3d& point_world_m, double depth_m) const;

  /// The distance from each point to the nearest triangle of the terrain, the solids' meshes and the bodies, exact to
  /// double rounding; infinity in an empty world.
  void distance(std::span<const Eigen::Vector3d> points_world_m, std::span<double> distances_m, int threads = 1) const;

 private:
  struct Fixed;
  void cast_packets(std::span<const ExactRays> rays, std::span<ExactHits> hits) const;
  void cast_range(std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits) const;

  std::shared_ptr<const Fixed> fixed_;
  std::shared_ptr<const MovingBodies> bodies_;  // null if there are none
  std::shared_ptr<const Sway> sway_;
  std::size_t hidden_ = MovingBodies::kNone;
};

}  // namespace uwsim
