#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/convex_contact.h"
#include "uwsim/dynamics/surface_patch.h"

namespace uwsim {

/// A convex piece at its pose, for SurfaceContact.
struct PlacedShape {
  const ConvexShape& shape;
  const Pose& world_from_body;
  const Eigen::Matrix3d& rotation;        ///< rotation of the pose
  Eigen::Vector3d middle_m, half_size_m;  ///< of its box along the body's axes, in the body frame
  Eigen::Vector3d low_m, high_m;          ///< its bounding box along the world's axes, enlarged by `reach_m`
  double reach_m;                         ///< find contacts whose distance is at most this
};

/// Finds where a convex shape touches a surface, feature by feature: its corners with triangles and edges, its edges
/// with edges, its faces with peaks. Each normal lies in the normal cone of the surface's feature (Bouma and Vanecek
/// 1993, "Modeling contacts in a physically based simulation"; cf. van den Bergen and Gregorius 2010, "Game Physics
/// Pearls", ch. 3), and flat and concave edges have none. ConvexContact finds overlaps deeper than `reach_m` that the
/// features miss. A pure function of the poses.
class SurfaceContact {
 public:
  enum class Under {
    kSolid,   ///< everything under the surface is inside, as for terrain
    kClosed,  ///< the surface encloses the inside
  };

  SurfaceContact();

  /// The contacts, valid until the next call. Throws ContactBudgetExceeded.
  std::span<const ContactPoint> find(const PlacedShape& placed, const SurfacePatch& patch, Under under,
                                     ContactBudget& budget);

 private:
  void find_close_triangles(const SurfacePatch& patch);
  void add_corner_on_terrain(const Eigen::Vector3d& corner_m);
  void add_corner_at_solid(const Eigen::Vector3d& corner_m);
  void add_above(const SurfaceTriangle& triangle, const Eigen::Vector3d& corner_m, double gap_m);
  void add_peak(const SurfacePatch& patch, const SurfacePeak& peak);
  void add_edge(const SurfaceEdge& edge);
  void add_deep_overlap(const SurfaceTriangle& triangle);
  double lowest_over(const SurfaceTriangle& triangle) const;

  const PlacedShape* placed_ = nullptr;
  Under under_ = Under::kSolid;
  ContactBudget* budget_ = nullptr;
  std::vector<const SurfaceTriangle*> close_;
  std::vector<Eigen::Vector3d> corners_world_m_;
  std::vector<ContactPoint> found_;
  ConvexContact convex_contact_;
};

}  // namespace uwsim
