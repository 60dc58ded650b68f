#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/contact_shapes.h"
#include "uwsim/dynamics/moved_body.h"
#include "uwsim/dynamics/tether_spec.h"

namespace uwsim {

/// A place where an element of a tether touches, or may in this step: a plane that its axis stays a radius away from.
struct TetherContact {
  std::size_t element;
  double share;                                 ///< of the element's length, from its first node
  Eigen::Vector3d point_world_m, normal_world;  ///< on the surface; towards the tether
  Eigen::Vector3d moves_m;                      ///< the surface, in this step
  std::uint64_t body;                           ///< TetherEnd::kNoBody: a solid
  // In the step under way:
  double level_m = 0, stiffness = 0, force_n = 0, inertia = 0;
  double friction_n = 0, friction_stiffness = 0;
  Eigen::Vector3d held_m = Eigen::Vector3d::Zero(), grip_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d slide_n = Eigen::Vector3d::Zero();
  Eigen::Matrix3d slide_stiffness = Eigen::Matrix3d::Zero();
  bool is_pressed = false, slides = false;
};

/// A tether as the finder sees it.
struct TetherLine {
  std::span<const Eigen::Vector3d> points_m;  ///< nodes
  std::span<const double> reach_m;            ///< of elements: only surfaces this near are found
  std::span<const double> from_m;             ///< of nodes: length from the first end
  std::uint64_t broken;                       ///< the element that has broken, or greater
  double step_s;                              ///< in which hulls move on
};

/// Finds where a tether comes close to solids and hulls. The result depends on its arguments only.
///
/// Its elements meet the features of a solid's surface, as bodies do (surface_contact.h): nodes meet triangles,
/// elements convex edges and peaks. A hull is the intersection of its faces' half spaces. Within `hull radius +
/// distance of its end` of its own vehicle, a tether that is fastened inside the hull passes through that; fastened on
/// it, only its last element does.
class TetherContactFinder {
 public:
  TetherContactFinder(const World& world, const TetherSpec& spec, std::span<const MovedBody> bodies);

  void set_bodies(std::span<const MovedBody> bodies);
  /// Replaces `contacts`. Throws ContactBudgetExceeded.
  void find(const TetherLine& line, std::span<const MovedBody> bodies, std::vector<TetherContact>& contacts);
  /// False only if no solid or solid piece of cover is near the box.
  bool may_touch(const WorldBox& box) const;
  /// The name of a solid whose surface the segment passes through, or "".
  std::string crossed(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const;
  /// True if the segment passes through a solid piece of cover.
  bool crosses_cover(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const;

 private:
  void find_solids(const WorldBox& whole);
  void find_hulls(const WorldBox& whole, std::span<const MovedBody> bodies);
  void meet_node(std::size_t element, double share, const SurfacePatch& patch);
  void meet_edge(std::size_t element, const SurfaceEdge& edge);
  void meet_peak(std::size_t element, const SurfacePatch& patch, const SurfacePeak& peak);
  void meet_piece(std::size_t element, const Polytope& piece, std::uint64_t body, const MovedBody& moved);
  void add(std::size_t element, double share, const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal,
           const Eigen::Vector3d& moves_m = Eigen::Vector3d::Zero(), std::uint64_t body = TetherEnd::kNoBody);
  WorldBox box_of(std::size_t first, std::size_t last) const;
  Eigen::Vector3d point(std::size_t element, double share) const;
  /// Nodes between two elements belong to the second.
  bool owns_end(std::size_t element) const;
  bool is_own(std::size_t element, std::uint64_t body) const;

  std::shared_ptr<const FixedSurfaces> fixed_;
  std::vector<std::shared_ptr<const ConvexBody>> hulls_;
  TetherSpec spec_;
  double own_m_[2] = {0, 0};  // what of the tether passes through the hulls at its ends
  // Kept so that steps do not allocate.
  TetherLine line_{};
  ContactBudget budget_;
  std::shared_ptr<SolidTriangles::Stack> stack_;
  std::vector<SurfacePatch> patches_;
  std::vector<TetherContact>* contacts_ = nullptr;
};

}  // namespace uwsim
