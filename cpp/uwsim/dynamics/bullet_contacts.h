#pragma once

#include <btBulletCollisionCommon.h>

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwsim/core/state_archive.h"

namespace uwsim {

/// A point of contact of two shapes, with what Bullet needs of it for the next step.
struct KeptPoint {
  std::array<btVector3, 2> local_m;  ///< on each object, in that object's frame
  btVector3 normal_world;            ///< unit, from the second object towards the first
  double impulse_Ns = 0;             ///< along the normal in the last step: the start of the next solution
};

/// The points of contact of one convex piece with a piece of another body or with a part of the ground.
struct KeptContact {
  /// Either a body and its piece, or a part of the ground.
  struct Side {
    std::int32_t object = 0;  ///< the body's number, or -1 - part
    std::int32_t piece = 0;   ///< -1 for a part of the ground
    auto operator<=>(const Side&) const = default;
  };
  std::array<Side, 2> sides;
  std::array<KeptPoint, MANIFOLD_CACHE_SIZE> points;
  std::size_t count = 0;
};

/// A dispatcher whose contact points and impulses between steps are a plain list. Bullet's own are spread over pairs
/// and algorithms, whose order depends on the past. Here, all of these are rebuilt in every step, and each new set of
/// contact points begins with those of the list, refreshed for the present poses, as Bullet would have refreshed its
/// own. The list is therefore all that a step needs of the past.
///
/// Each object's user index is that of KeptContact::Side.
class ContactKeeper final : public btCollisionDispatcher {
 public:
  using btCollisionDispatcher::btCollisionDispatcher;

  btCollisionAlgorithm* findAlgorithm(const btCollisionObjectWrapper* one, const btCollisionObjectWrapper* other,
                                      btPersistentManifold* shared, ebtDispatcherQueryType query) override;
  btPersistentManifold* getNewManifold(const btCollisionObject* one, const btCollisionObject* other) override;

  /// Copies the points of contact and impulses of the step that ended; keep() makes them the start of the next.
  void read();
  void keep() { kept_.swap(read_); }
  void forget(std::size_t body);
  /// Saves or restores the list. Throws InvalidValue unless each point lies on both of its objects.
  void exchange(StateArchive& archive, const btCollisionObjectArray& objects, double most_impulse_Ns);

 private:
  /// Adds the list's points and impulses to a manifold without any.
  void fill(btPersistentManifold& manifold);

  std::vector<KeptContact> kept_, read_;
  std::size_t next_ = 0;                    // where a search in the list begins: the order seldom changes
  const btCollisionObject* met_ = nullptr;  // the first of the two objects whose pieces meet
  std::array<std::int32_t, 2> met_pieces_{};
};

}  // namespace uwsim
