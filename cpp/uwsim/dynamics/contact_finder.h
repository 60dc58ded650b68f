#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "uwsim/dynamics/collision_shape.h"
#include "uwsim/dynamics/contact_solver.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// How near a resting body stays to the surface it rests on: closer contacts count as pressed together, so that shapes
/// need not overlap for a contact to hold.
inline constexpr double kRestGap_m = 1e-3;

/// A body as the search for contacts sees it.
struct MovingBody {
  Pose world_from_body;
  double reach_m = 0;  ///< contacts with a gap up to this are wanted
  bool collides = true;
};

/// Finds where bodies, made of convex pieces, come near each other, the terrain and the solids.
///
/// The answer is a pure function of the poses: nothing is kept from one step to the next, so the same state has the
/// same future. Shapes have no margin: a contact's gap is the distance of the surfaces less kRestGap_m. The terrain is
/// solid all the way down: what lies under it is an overlap.
class ContactFinder {
 public:
  explicit ContactFinder(const World& world);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  void add_body(std::span<const ConvexPiece> pieces_body_m);

  /// Radius of a sphere about the body's origin that holds all its pieces [m].
  double radius_m(std::size_t body) const;

  /// Replaces `contacts`: bodies in order, each with what is fixed, then with the bodies before it. Friction and
  /// restitution are left to the caller.
  void find(std::span<const MovingBody> bodies, std::vector<Contact>& contacts);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
