#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "uwsim/dynamics/collision_shape.h"
#include "uwsim/dynamics/contact_solver.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// The distance above a surface at which a body rests. Contacts closer than this count as pressed together, so that a
/// contact can persist without an overlap of the shapes.
inline constexpr double kRestGap_m = 1e-3;

/// A body as seen by the contact finder.
struct MovingBody {
  Pose world_from_body;
  double reach_m = 0;  ///< only contacts whose gap is at most this are found
  bool collides = true;
  bool meets_world = true;  ///< otherwise, only bodies that do are found
  std::size_t owner = 0;    ///< those of the same owner, a vehicle and its links, pass through each other
};

/// Finds the places where bodies made of convex pieces come close to each other, to the terrain, to solids or to
/// solid pieces of cover.
///
/// The result is a pure function of the poses: nothing is kept from one step to the next, so equal states evolve
/// equally. Shapes have no margin: a contact's gap is the distance between the surfaces minus kRestGap_m. The terrain
/// is solid all the way down: a body below its surface overlaps it.
class ContactFinder {
 public:
  explicit ContactFinder(const World& world);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  /// A body without pieces touches nothing.
  /// `round`: the exact shape of its only piece.
  void add_body(std::span<const ConvexPiece> pieces_body_m, const std::optional<RoundPiece>& round = {});
  void set_body(std::size_t body, std::span<const ConvexPiece> pieces_body_m,
                const std::optional<RoundPiece>& round = {});

  /// Radius of a sphere about the body's origin that encloses all its pieces [m].
  double radius_m(std::size_t body) const;
  /// The smallest edge of the body's bounding box, which is aligned with its axes [m].
  double thickness_m(std::size_t body) const;

  /// False only if neither terrain, a solid nor cover is within reach of what a sphere encloses.
  bool may_touch_world(const Eigen::Vector3d& centre_world_m, double radius_m) const;

  /// Replaces `contacts`. They are ordered by body; for each body, contacts with terrain, solids and cover come first,
  /// then those with bodies of lower index. The caller sets friction and restitution. Throws ContactBudgetExceeded
  /// (contact_budget.h).
  void find(std::span<const MovingBody> bodies, std::vector<Contact>& contacts);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
