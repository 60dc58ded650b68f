#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "uwsim/dynamics/broad_phase.h"
#include "uwsim/dynamics/canopy.h"
#include "uwsim/dynamics/collision_shape.h"
#include "uwsim/dynamics/convex_contact.h"
#include "uwsim/dynamics/cover_triangles.h"
#include "uwsim/dynamics/solid_triangles.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A box along the world axes.
struct WorldBox {
  Eigen::Vector3d low_m, high_m;
  bool meets(const WorldBox& other) const {
    return (low_m.array() <= other.high_m.array()).all() && (other.low_m.array() <= high_m.array()).all();
  }
};

/// A box along a body's axes.
struct BodyBox {
  Eigen::Vector3d middle_body_m, half_size_body_m;

  static BodyBox around(const ConvexPiece& points_m);
  /// The box's bounding box along the world axes, enlarged by `reach_m`.
  WorldBox in_world(const Eigen::Vector3d& position_m, const Eigen::Matrix3d& rotation, double reach_m) const;
};

/// A body made of convex pieces, prepared for the search for contacts; immutable.
struct ConvexBody {
  struct Piece {
    ConvexShape shape;
    BodyBox box;
  };
  std::vector<ConvexPiece> points_m;  ///< in their original order
  std::optional<RoundPiece> round;    ///< the exact shape of its only piece
  std::vector<Piece> pieces;
  BodyBox box{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double radius_m = 0;  ///< of a sphere about the body's origin that encloses all pieces
};

/// Shared by all bodies of the same shape: a vehicle's convex hull takes 0.3 MB and 0.7 ms to build.
std::shared_ptr<const ConvexBody> convex_body(std::span<const ConvexPiece> pieces_body_m,
                                              const std::optional<RoundPiece>& round = {});

/// The world as far as bodies meet it; immutable.
struct FixedSurfaces {
  World world;  ///< without water
  BroadPhase broad_phase;
  SolidTriangles solids;
  std::optional<CoverPlan> plan;
  std::optional<CoverTriangles> cover;  ///< if a layer is solid
  std::optional<Canopy> canopy;         ///< if plants grow

  explicit FixedSurfaces(const World& source);
  FixedSurfaces(const FixedSurfaces&) = delete;
  FixedSurfaces& operator=(const FixedSurfaces&) = delete;

  bool has_solids() const { return cover.has_value() || !world.solids().empty(); }
  /// False only if neither terrain nor a solid nor a solid piece of cover reaches into the box.
  bool may_touch(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const;
  /// As SolidTriangles::find, with the pieces of cover after the solids.
  std::size_t find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                   SolidTriangles::Stack& stack, std::vector<SurfacePatch>& patches, ContactBudget& budget) const;
};

/// Shared in worlds with the same surfaces: those of the lake scenario take several megabytes.
std::shared_ptr<const FixedSurfaces> fixed_surfaces(const World& world);

}  // namespace uwsim
