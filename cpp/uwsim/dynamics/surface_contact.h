#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/convex_contact.h"
#include "uwsim/dynamics/surface_patch.h"

namespace uwsim {

/// A convex piece of a body, placed at the body's pose, as input to SurfaceContact.
struct PlacedShape {
  const ConvexShape& shape;
  const Pose& world_from_body;
  const Eigen::Matrix3d& rotation;        ///< rotation of the pose
  Eigen::Vector3d middle_m, half_size_m;  ///< of its box along the body's axes, in the body frame
  Eigen::Vector3d low_m, high_m;          ///< bounding box along the world axes, enlarged by `reach_m`
  double reach_m;                         ///< only contacts within this distance are found
};

/// Finds where a convex shape touches a surface, feature by feature: the shape's corners against triangles and edges,
/// its edges against edges, its faces against peaks. Each normal lies in the normal cone of the surface's feature
/// (Bouma and Vanecek 1993, "Modeling contacts in a physically based simulation"; cf. van den Bergen and Gregorius
/// 2010, "Game Physics Pearls", ch. 3); flat and concave edges have no such cone. ConvexContact finds overlaps deeper
/// than `reach_m` that the features miss. The result is a pure function of the poses.
///
/// A ball, and a rod with round ends, is the distance from its axis less its radius. A drum touches a triangle with the
/// points of its rims that are lowest over it, and edges and peaks with its wall; only its rims have facets, at edges.
class SurfaceContact {
 public:
  enum class Under {
    kSolid,   ///< the inside is everything below the surface, as for terrain
    kClosed,  ///< the inside is the volume that the surface encloses
  };

  SurfaceContact();

  /// The contacts, valid until the next call. Throws ContactBudgetExceeded.
  std::span<const ContactPoint> find(const PlacedShape& placed, const SurfacePatch& patch, Under under,
                                     ContactBudget& budget);

 private:
  void find_close_triangles(const SurfacePatch& patch);
  void place_corners();
  void add_rims(const SurfaceTriangle& triangle);
  void add_corner(const Eigen::Vector3d& corner_m);
  void add_corner_over(const SurfaceTriangle& triangle, const Eigen::Vector3d& corner_m);
  void add_corner_on_terrain(const Eigen::Vector3d& corner_m);
  void add_corner_at_solid(const Eigen::Vector3d& corner_m);
  void add_above(const SurfaceTriangle& triangle, const Eigen::Vector3d& corner_m, double height_m);
  void add_peak(const SurfacePatch& patch, const SurfacePeak& peak);
  bool add_wall_at_peak(const SurfacePatch& patch, const SurfacePeak& peak);
  void add_touching_peak(const SurfacePatch& patch, const SurfacePeak& peak, const Eigen::Vector3d& normal,
                         double gap_m);
  void add_edge(const SurfaceEdge& edge);
  void add_wall_at_edge(const SurfaceEdge& edge);
  void add_deep_overlap(const SurfaceTriangle& triangle);
  double lowest_over(const SurfaceTriangle& triangle) const;

  const PlacedShape* placed_ = nullptr;
  Under under_ = Under::kSolid;
  ContactBudget* budget_ = nullptr;
  std::vector<const SurfaceTriangle*> close_;
  std::vector<Eigen::Vector3d> corners_world_m_;
  const RoundPiece* round_ = nullptr;            // null: the piece has no more than its facets
  Eigen::Vector3d middle_world_m_, axis_world_;  // of `round_`; the axis is unit, or zero for a ball
  double half_length_m_ = 0;                     // likewise
  double corner_radius_m_ = 0;                   // of the balls about the corners
  std::vector<ContactPoint> found_;
  ConvexContact convex_contact_;
};

}  // namespace uwsim
