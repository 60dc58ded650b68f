#include "uwsim/dynamics/bullet_engine.h"

#include <btBulletDynamicsCommon.h>

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/dynamics/bullet_contacts.h"
#include "uwsim/dynamics/bullet_ground.h"
#include "uwsim/dynamics/bullet_memory.h"
#include "uwsim/dynamics/contact.h"
#include "uwsim/dynamics/contact_finder.h"
#include "uwsim/dynamics/folded_mass.h"
#include "uwsim/dynamics/polytope.h"

namespace uwsim {
namespace {

constexpr int kMostObjects = 1024;
constexpr double kNear_m = 0.1;      // from the ground, beyond Bullet's own threshold of 2 cm
constexpr double kShallow_m = 3e-5;  // if even such overlaps are split, bodies that came to rest obliquely creep
constexpr int kIterations = 50;      // with Bullet's default of 10, a stack of five boxes shifts by 4 cm in 10 s

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Vector3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// Bullet subtracts the speed that closes a gap within the step from the speed of the rebound. A contact that will
/// bounce must therefore be closed first.
bool bounces_too_early(const btPersistentManifold& manifold, const btManifoldPoint& point) {
  if (point.m_combinedRestitution == 0 || point.getDistance() <= 0) return false;
  const auto velocity = [](const btCollisionObject* object, const btVector3& at) {
    return btRigidBody::upcast(object)->getVelocityInLocalPoint(at - object->getWorldTransform().getOrigin());
  };
  const btVector3 relative = velocity(manifold.getBody0(), point.getPositionWorldOnA()) -
                             velocity(manifold.getBody1(), point.getPositionWorldOnB());
  return relative.dot(point.m_normalWorldOnB) < -kBounceThreshold_m_s;
}

/// A body for Bullet, whose frame is along the principal axes at the centre of mass.
struct BulletBody {
  FoldedMass mass;
  std::vector<std::unique_ptr<btConvexHullShape>> pieces;
  btCompoundShape shape;
  btRigidBody body;

  explicit BulletBody(const BodySpec& spec)
      : mass(spec.craft->parameters()), body(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape)) {
    for (const ConvexPiece& piece : spec.collision_pieces_body_m) {
      auto hull = std::make_unique<btConvexHullShape>();
      for (const Eigen::Vector3d& corner : Polytope(piece).corners_m)
        hull->addPoint(to_bullet(mass.body_from_principal().conjugate() * (corner - mass.centre_of_mass_body_m())),
                       false);
      hull->setMargin(kRestGap_m);
      hull->recalcLocalAabb();
      hull->initializePolyhedralFeatures();  // so that faces meet in several points at once
      shape.addChildShape(btTransform::getIdentity(), hull.get());
      pieces.push_back(std::move(hull));
    }
    body.setActivationState(DISABLE_DEACTIVATION);
  }

  /// `surfaces`: of the ground, which a body that is far from it does not meet in this step.
  void put(const MovedBody& from, const WaterField& water, const ContactFinder& surfaces, double time_s,
           double step_s) {
    const BodyState& state = from.state;
    const Pose& pose = state.world_from_body;
    const Eigen::Quaterniond q = pose.orientation * mass.body_from_principal();
    const btTransform transform(btQuaternion(q.x(), q.y(), q.z(), q.w()),
                                to_bullet(pose.point(mass.centre_of_mass_body_m())));
    const Eigen::Vector3d v = state.linear_body_m_s() + state.angular_body_rad_s().cross(mass.centre_of_mass_body_m());
    body.setWorldTransform(transform);
    body.setLinearVelocity(to_bullet(pose.direction(v)));
    body.setAngularVelocity(to_bullet(pose.direction(state.angular_body_rad_s())));
    body.setInterpolationWorldTransform(transform);
    body.setInterpolationLinearVelocity(body.getLinearVelocity());
    body.setInterpolationAngularVelocity(body.getAngularVelocity());
    body.forceActivationState(from.held ? DISABLE_SIMULATION : DISABLE_DEACTIVATION);
    btVector3 middle;
    btScalar radius_m = 0;
    shape.getBoundingSphere(middle, radius_m);
    const double reach_m = radius_m + step_s * body.getLinearVelocity().length() + kNear_m;
    const bool meets_ground = !from.held && surfaces.may_touch_world(from_bullet(transform * middle), reach_m);
    body.getBroadphaseProxy()->m_collisionFilterMask =
        from.held ? 0 : btBroadphaseProxy::AllFilter & ~(meets_ground ? 0 : btBroadphaseProxy::StaticFilter);
    body.clearForces();
    if (from.held) return;
    const Loads loads = from.loads(Vector6d::Zero(), 1);
    Vector6d tau_body = loads.body;
    if (!loads.world.isZero(0)) tau_body += in_body_axes(loads.world, pose.orientation);
    const auto [load_body, submerged] = from.spec.craft->load(state, tau_body, water, time_s);
    body.setMassProps(mass.mass_kg(submerged), to_bullet(mass.moments_kg_m2(submerged)));
    body.updateInertiaTensor();
    const Vector6d applied = mass.applied_body(load_body, state.velocity_body, submerged);
    body.applyCentralForce(to_bullet(pose.direction(applied.head<3>())));
    body.applyTorque(to_bullet(pose.direction(applied.tail<3>())));
  }

  BodyState state() const {
    const btQuaternion q = body.getWorldTransform().getRotation();
    BodyState state;
    Pose& pose = state.world_from_body;
    pose.orientation =
        (Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()) * mass.body_from_principal().conjugate()).normalized();
    pose.position_m = from_bullet(body.getWorldTransform().getOrigin()) - pose.direction(mass.centre_of_mass_body_m());
    const Eigen::Vector3d w = pose.orientation.conjugate() * from_bullet(body.getAngularVelocity());
    const Eigen::Vector3d v = pose.orientation.conjugate() * from_bullet(body.getLinearVelocity());
    state.velocity_body << v - w.cross(mass.centre_of_mass_body_m()), w;
    return state;
  }
};

}  // namespace

struct BulletEngine::Impl {
  /// Bullet's world, with uwsim's rules for the materials of two bodies.
  struct DynamicsWorld final : btDiscreteDynamicsWorld {
    std::span<const MovedBody> bodies;  // of the step under way

    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

    void performDiscreteCollisionDetection() override {
      btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
      for (int k = 0; k < m_dispatcher1->getNumManifolds(); ++k) {
        btPersistentManifold& manifold = *m_dispatcher1->getManifoldByIndexInternal(k);
        const int a = manifold.getBody0()->getUserIndex(), b = manifold.getBody1()->getUserIndex();
        const BodySpec& one = bodies[static_cast<std::size_t>(a < 0 ? b : a)].spec;
        const BodySpec& other = bodies[static_cast<std::size_t>(b < 0 ? a : b)].spec;
        for (int k = manifold.getNumContacts() - 1; k >= 0; --k) {
          btManifoldPoint& point = manifold.getContactPoint(k);
          point.m_combinedFriction = pair_friction(one, other);
          point.m_combinedRestitution = pair_restitution(one, other);
          if (bounces_too_early(manifold, point)) manifold.removeContactPoint(k);
        }
      }
    }
  };

  double step_s;
  std::shared_ptr<const BulletGround> ground;
  ContactFinder surfaces;
  std::vector<std::unique_ptr<btRigidBody>> fixed;
  std::vector<std::unique_ptr<BulletBody>> bodies;
  btDefaultCollisionConfiguration configuration;
  ContactKeeper dispatcher{&configuration};
  btSimpleBroadphase broadphase{kMostObjects};  // its pairs are in the order of the bodies
  btSequentialImpulseConstraintSolver solver;
  DynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};

  Impl(const World& source, double step_s) : step_s(step_s), ground(BulletGround::of(source)), surfaces(source) {
    world.setGravity({0, 0, 0});
    world.setForceUpdateAllAabbs(false);
    world.getSolverInfo().m_numIterations = kIterations;
    // Overlaps are separated by a velocity that does not persist (a split impulse), as in ContactSolver, and not only
    // those of Bullet's default of 4 cm: otherwise impacts add energy.
    world.getSolverInfo().m_splitImpulsePenetrationThreshold = -kShallow_m;
    // With one direction, along the last slip, a box that lands on a slope slides four times as far before it stands.
    world.getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    world.getSolverInfo().m_restitutionVelocityThreshold = kBounceThreshold_m_s;
    for (const BulletGround::Part& part : ground->parts()) {
      fixed.push_back(std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, part.shape)));
      fixed.back()->setWorldTransform(btTransform(btMatrix3x3::getIdentity(), to_bullet(part.position_world_m)));
      fixed.back()->setUserIndex(-static_cast<int>(fixed.size()));
      world.addRigidBody(fixed.back().get());
    }
  }

  ~Impl() {
    remove_bodies();
    for (const auto& body : fixed) world.removeRigidBody(body.get());
  }

  /// Bodies leave in the reverse of the order in which they entered, so that Bullet's lists keep their order.
  void remove_bodies() {
    for (auto body = bodies.rbegin(); body != bodies.rend(); ++body) world.removeRigidBody(&(*body)->body);
  }

  void enter(std::size_t body) {
    bodies[body]->body.setUserIndex(static_cast<int>(body));
    world.addRigidBody(&bodies[body]->body);
  }

  /// Drops all pairs and, with them, Bullet's contact points; those of the dispatcher's list remain.
  void drop_pairs() {
    for (const auto& body : bodies)
      broadphase.getOverlappingPairCache()->removeOverlappingPairsContainingProxy(body->body.getBroadphaseProxy(),
                                                                                  &dispatcher);
    solver.reset();
  }
};

BulletEngine::BulletEngine(const World& world, double step_s) : impl_(std::make_unique<Impl>(world, step_s)) {}
BulletEngine::~BulletEngine() = default;

void BulletEngine::add_body(const BodySpec& spec) {
  const std::size_t most = kMostObjects - impl_->fixed.size();
  require(impl_->bodies.size() < most, "vehicles", impl_->bodies.size() + 1,
          "must be at most " + std::to_string(most) + " with dynamics.engine: bullet");
  impl_->bodies.push_back(std::make_unique<BulletBody>(spec));
  impl_->enter(impl_->bodies.size() - 1);
}

void BulletEngine::change_body(std::size_t body, const BodySpec& from, const BodySpec& to) {
  auto changed = std::make_unique<BulletBody>(to);
  // The points of contact are in the body's frame for Bullet.
  if (from.collision_pieces_body_m != to.collision_pieces_body_m ||
      !changed->mass.has_axes_of(impl_->bodies[body]->mass))
    forget(body);
  impl_->remove_bodies();
  impl_->bodies[body] = std::move(changed);
  for (std::size_t k = 0; k < impl_->bodies.size(); ++k) impl_->enter(k);
}

void BulletEngine::forget(std::size_t body) { impl_->dispatcher.forget(body); }

void BulletEngine::moved() { impl_->dispatcher.keep(); }

void BulletEngine::exchange_contacts(StateArchive& archive) {
  double all_kg = 0;
  for (const auto& body : impl_->bodies) all_kg += body->mass.mass_kg(1);
  impl_->dispatcher.exchange(archive, impl_->world.getCollisionObjectArray(), all_kg * kDiverged);
}

void BulletEngine::step(std::span<MovedBody> bodies, std::span<BodyState> next_states, const WaterField& water,
                        double time_s) {
  impl_->drop_pairs();
  for (std::size_t k = 0; k < bodies.size(); ++k)
    impl_->bodies[k]->put(bodies[k], water, impl_->surfaces, time_s, impl_->step_s);
  impl_->world.bodies = bodies;
  impl_->world.stepSimulation(impl_->step_s, 0);  // 0: one step of this size
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    next_states[k] = bodies[k].held ? bodies[k].state : impl_->bodies[k]->state();
    bodies[k].in_contact = false;
  }
  for (int k = 0; k < impl_->dispatcher.getNumManifolds(); ++k) {
    const btPersistentManifold& manifold = *impl_->dispatcher.getManifoldByIndexInternal(k);
    bool touches = false;
    for (int point = 0; point < manifold.getNumContacts(); ++point) {
      const btManifoldPoint& contact = manifold.getContactPoint(point);
      touches = touches || contact.getDistance() <= kTouch_m || contact.getAppliedImpulse() > 0;
    }
    for (const btCollisionObject* touched : {manifold.getBody0(), manifold.getBody1()}) {
      if (touches && touched->getUserIndex() >= 0)
        bodies[static_cast<std::size_t>(touched->getUserIndex())].in_contact = true;
    }
  }
  impl_->dispatcher.read();
}

}  // namespace uwsim
