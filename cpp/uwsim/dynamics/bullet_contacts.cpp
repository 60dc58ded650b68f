#include "uwsim/dynamics/bullet_contacts.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kUnitTolerance = 1e-6;
constexpr double kNearObject_m = 0.1;  // Bullet's points of deep overlaps lie beside the surface

const btCollisionObject* object_of(const btCollisionObjectArray& objects, std::int32_t index) {
  for (int k = 0; k < objects.size(); ++k) {
    if (objects[k]->getUserIndex() == index) return objects[k];
  }
  return nullptr;
}

int pieces_of(const btCollisionObject& object) {
  const btCollisionShape* shape = object.getCollisionShape();
  return shape->isCompound() ? static_cast<const btCompoundShape*>(shape)->getNumChildShapes() : 0;
}

void require_side(const KeptContact::Side& side, const btCollisionObject* object) {
  require(object != nullptr, "state.contact.object", side.object, "must be a body or a part of the ground");
  const int pieces = pieces_of(*object);
  require(pieces == 0 ? side.piece == -1 : side.piece >= 0 && side.piece < pieces, "state.contact.piece", side.piece,
          pieces == 0 ? "must be -1" : "must be in [0, " + std::to_string(pieces) + ")");
}

void require_on(const btVector3& local_m, const btCollisionObject& object) {
  btVector3 centre_m;
  btScalar radius_m = 0;
  object.getCollisionShape()->getBoundingSphere(centre_m, radius_m);
  const double apart_m = local_m.distance(centre_m);
  require(apart_m <= radius_m + kNearObject_m, "state.contact.point", apart_m, "must lie on its object");
}

std::array<KeptContact::Side, 2> sides_of(const btPersistentManifold& manifold) {
  return {{{manifold.getBody0()->getUserIndex(), manifold.m_companionIdA},
           {manifold.getBody1()->getUserIndex(), manifold.m_companionIdB}}};
}

void exchange_number(StateArchive& archive, std::int32_t& number) {
  auto bits = static_cast<std::uint64_t>(std::int64_t{number});
  archive(bits);
  number = static_cast<std::int32_t>(static_cast<std::int64_t>(bits));
  require(bits == static_cast<std::uint64_t>(std::int64_t{number}), "state.contact", bits, "must be a small integer");
}

void exchange_vector(StateArchive& archive, btVector3& v) {
  for (int k = 0; k < 3; ++k) archive(v.m_floats[k]);
}

}  // namespace

/// Compound shapes find an algorithm for each of their pieces. It makes its manifold there and clears it, or makes it
/// at its first use, which follows at once.
btCollisionAlgorithm* ContactKeeper::findAlgorithm(const btCollisionObjectWrapper* one,
                                                   const btCollisionObjectWrapper* other, btPersistentManifold* shared,
                                                   ebtDispatcherQueryType query) {
  if (shared != nullptr) return btCollisionDispatcher::findAlgorithm(one, other, shared, query);  // for a triangle
  met_ = one->getCollisionObject();
  met_pieces_ = {one->m_index, other->m_index};
  const int before = getNumManifolds();
  btCollisionAlgorithm* algorithm = btCollisionDispatcher::findAlgorithm(one, other, shared, query);
  if (getNumManifolds() > before) fill(*getManifoldByIndexInternal(before));
  return algorithm;
}

btPersistentManifold* ContactKeeper::getNewManifold(const btCollisionObject* one, const btCollisionObject* other) {
  btPersistentManifold* manifold = btCollisionDispatcher::getNewManifold(one, other);
  const bool same_order = one == met_;
  manifold->m_companionIdA = met_pieces_[same_order ? 0 : 1];
  manifold->m_companionIdB = met_pieces_[same_order ? 1 : 0];
  fill(*manifold);
  return manifold;
}

void ContactKeeper::fill(btPersistentManifold& manifold) {
  if (manifold.getNumContacts() > 0) return;
  const auto sides = sides_of(manifold);
  for (std::size_t tried = 0; tried < kept_.size(); ++tried) {
    if (next_ >= kept_.size()) next_ = 0;
    const KeptContact& contact = kept_[next_];
    if (contact.sides != sides) {
      ++next_;
      continue;
    }
    for (std::size_t k = 0; k < contact.count; ++k) {
      const KeptPoint& kept = contact.points[k];
      btManifoldPoint point(kept.local_m[0], kept.local_m[1], kept.normal_world, 0);
      point.m_appliedImpulse = kept.impulse_Ns;
      manifold.addManifoldPoint(point);
    }
    manifold.refreshContactPoints(manifold.getBody0()->getWorldTransform(), manifold.getBody1()->getWorldTransform());
    return;
  }
}

void ContactKeeper::read() {
  read_.clear();
  for (int m = 0; m < getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = *getManifoldByIndexInternal(m);
    if (manifold.getNumContacts() == 0) continue;
    KeptContact& contact = read_.emplace_back();
    contact.sides = sides_of(manifold);
    contact.count = static_cast<std::size_t>(manifold.getNumContacts());
    for (std::size_t k = 0; k < contact.count; ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(static_cast<int>(k));
      contact.points[k] = {{point.m_localPointA, point.m_localPointB}, point.m_normalWorldOnB, point.m_appliedImpulse};
    }
  }
}

void ContactKeeper::forget(std::size_t body) {
  std::erase_if(kept_, [&](const KeptContact& contact) {
    return std::ranges::any_of(contact.sides,
                               [&](const auto& side) { return side.object == static_cast<std::int32_t>(body); });
  });
}

void ContactKeeper::exchange(StateArchive& archive, const btCollisionObjectArray& objects, double most_impulse_Ns) {
  std::set<std::array<KeptContact::Side, 2>> seen;
  archive.list(kept_, [&](KeptContact& contact) {
    std::array<const btCollisionObject*, 2> on{};
    for (std::size_t k = 0; k < 2; ++k) {
      exchange_number(archive, contact.sides[k].object);
      exchange_number(archive, contact.sides[k].piece);
      on[k] = object_of(objects, contact.sides[k].object);
      require_side(contact.sides[k], on[k]);
    }
    const auto [a, b] = std::array{contact.sides[0].object, contact.sides[1].object};
    require(a != b && (a >= 0 || b >= 0), "state.contact.objects", a, "must be two, of which one is a body");
    require(seen.insert(contact.sides).second, "state.contact.objects", a, "must have one set of points for a piece");
    std::uint64_t count = contact.count;
    archive(count);
    require(count >= 1 && count <= contact.points.size(), "state.contact.points", count, "must be in [1, 4]");
    contact.count = count;
    for (std::size_t p = 0; p < count; ++p) {
      KeptPoint& point = contact.points[p];
      for (std::size_t k = 0; k < 2; ++k) {
        exchange_vector(archive, point.local_m[k]);
        require_on(point.local_m[k], *on[k]);
      }
      exchange_vector(archive, point.normal_world);
      const double length = point.normal_world.length();
      require(std::abs(length - 1) < kUnitTolerance, "state.contact.normal", length, "must be of length 1");
      archive(point.impulse_Ns);
      require(point.impulse_Ns >= 0 && point.impulse_Ns <= most_impulse_Ns, "state.contact.impulse", point.impulse_Ns,
              "must be in [0, " + std::to_string(most_impulse_Ns) + "] N s");
    }
  });
}

}  // namespace uwsim
