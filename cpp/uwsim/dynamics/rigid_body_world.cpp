#include "uwsim/dynamics/rigid_body_world.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/dynamics/motion.h"

namespace uwsim {
namespace {

constexpr double kAbsurd = 1e7;    // m, m/s and rad/s: no body gets there but by diverging
constexpr double kSkin_m = 0.005;  // Bullet's convex margin: keeps its distance queries well conditioned

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Vector3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btTransform to_bullet(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), to_bullet(pose.position_m));
}

std::unique_ptr<btCollisionShape> terrain_shape(const Heightfield& terrain) {
  auto shape = std::make_unique<btHeightfieldTerrainShape>(static_cast<int>(terrain.nx()),
                                                           static_cast<int>(terrain.ny()), terrain.heights_m().data(),
                                                           terrain.lowest_m(), terrain.highest_m(), 2, false);
  shape->setLocalScaling({terrain.spacing_m(), terrain.spacing_m(), 1});
  return shape;
}

std::vector<Eigen::Vector3d> box_corners(const TriangleMesh& mesh) {
  Eigen::Vector3d low = mesh.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  std::vector<Eigen::Vector3d> corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back(k & 1 ? high.x() : low.x(), k & 2 ? high.y() : low.y(), k & 4 ? high.z() : low.z());
  }
  return corners;
}

std::unique_ptr<btConvexShape> body_shape(const TriangleMesh& mesh, CollisionShape kind) {
  const std::vector<Eigen::Vector3d> corners = kind == CollisionShape::kHull ? mesh.vertices_m : box_corners(mesh);
  btConvexHullComputer hull;
  hull.compute(corners.front().data(), sizeof(Eigen::Vector3d), static_cast<int>(corners.size()), 0, 0);
  auto shape = std::make_unique<btConvexHullShape>(&hull.vertices[0].getX(), hull.vertices.size());
  shape->setMargin(kSkin_m);
  return shape;
}

}  // namespace

struct RigidBodyWorld::Impl {
  struct Body {
    BodySpec spec;
    BodyState state;
    Vector6d tau_body = Vector6d::Zero();
    Vector6d acceleration_body = Vector6d::Zero();
    bool held = false;
    bool in_contact = false;
    std::unique_ptr<btConvexShape> shape;
    std::unique_ptr<btCollisionObject> object;
  };

  World world;  // keeps the arrays alive that Bullet's shapes point into
  double step_s;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btCollisionWorld bullet{&dispatcher, &broadphase, &configuration};
  std::vector<std::unique_ptr<btTriangleIndexVertexArray>> meshes;
  std::vector<std::unique_ptr<btCollisionShape>> fixed_shapes;
  std::vector<std::unique_ptr<btCollisionObject>> fixed_objects;
  std::vector<Body> bodies;
  std::vector<BodyState> next_states;
  std::vector<ContactBody> contact_bodies;
  std::vector<Contact> contacts;
  ContactSolver solver;

  Impl(const World& source, double step) : world(source), step_s(step) {
    bullet.setForceUpdateAllAabbs(false);
    if (const auto& terrain = world.terrain()) {
      const Eigen::Vector2d middle = 0.5 * (terrain->origin_m() + terrain->far_corner_m());
      const double middle_z = 0.5 * (double{terrain->lowest_m()} + double{terrain->highest_m()});
      add_fixed(terrain_shape(*terrain), {middle.x(), middle.y(), middle_z});
    }
    for (const auto& solid : world.solids()) add_solid(solid->mesh_world);
  }

  ~Impl() {
    for (auto& body : bodies) {
      if (!body.held) bullet.removeCollisionObject(body.object.get());
    }
    for (auto& object : fixed_objects) bullet.removeCollisionObject(object.get());
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void add_fixed(std::unique_ptr<btCollisionShape> shape, const Eigen::Vector3d& position_m) {
    auto object = std::make_unique<btCollisionObject>();
    object->setCollisionShape(shape.get());
    object->setWorldTransform(to_bullet(Pose{position_m, Eigen::Quaterniond::Identity()}));
    object->setUserIndex(kFixedBody);
    object->setActivationState(ISLAND_SLEEPING);
    bullet.addCollisionObject(object.get(), btBroadphaseProxy::StaticFilter,
                              btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter);
    fixed_shapes.push_back(std::move(shape));
    fixed_objects.push_back(std::move(object));
  }

  void add_solid(const TriangleMesh& mesh) {
    btIndexedMesh part;
    part.m_numTriangles = static_cast<int>(mesh.triangles.size());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(mesh.triangles.data());
    part.m_triangleIndexStride = sizeof(Triangle);
    part.m_numVertices = static_cast<int>(mesh.vertices_m.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh.vertices_m.data());
    part.m_vertexStride = sizeof(Eigen::Vector3d);
    part.m_vertexType = PHY_DOUBLE;
    meshes.push_back(std::make_unique<btTriangleIndexVertexArray>());
    meshes.back()->addIndexedMesh(part, PHY_INTEGER);
    add_fixed(std::make_unique<btBvhTriangleMeshShape>(meshes.back().get(), false), Eigen::Vector3d::Zero());
  }

  /// Bullet finds where bodies touch at their present poses.
  void find_contacts() {
    contacts.clear();
    for (Body& body : bodies) {
      body.in_contact = false;
      if (!body.held) body.object->setWorldTransform(to_bullet(body.state.world_from_body));
    }
    bullet.performDiscreteCollisionDetection();
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) read_manifold(*dispatcher.getManifoldByIndexInternal(m));
  }

  void read_manifold(const btPersistentManifold& manifold) {
    int a = manifold.getBody0()->getUserIndex(), b = manifold.getBody1()->getUserIndex();
    const bool swapped = a == kFixedBody;
    if (swapped) std::swap(a, b);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      Contact contact;
      contact.a = a;
      contact.b = b;
      contact.point_world_m = from_bullet(point.getPositionWorldOnB());
      contact.normal_world = from_bullet(point.m_normalWorldOnB).normalized() * (swapped ? -1.0 : 1.0);
      contact.gap_m = point.getDistance();
      if (!contact.normal_world.allFinite()) continue;  // Bullet's degenerate pair: nothing to push along
      if (b == kFixedBody)
        straighten_on_terrain(contact, swapped ? manifold.getBody0() : manifold.getBody1(), point, swapped);
      mix_materials(contact);
      contacts.push_back(contact);
    }
  }

  /// Crossing an edge between two of the terrain's triangles, Bullet tilts the normal as if the edge stood out: a
  /// sliding body would stub on it. The triangle's own normal is meant.
  void straighten_on_terrain(Contact& contact, const btCollisionObject* fixed, const btManifoldPoint& point,
                             bool terrain_is_first) const {
    if (fixed->getCollisionShape()->getShapeType() != TERRAIN_SHAPE_PROXYTYPE) return;
    const Heightfield& terrain = *world.terrain();
    // Bullet's height field numbers its triangles as (part = 2 i + half, index = row j).
    const auto part = static_cast<std::size_t>(terrain_is_first ? point.m_partId0 : point.m_partId1);
    const auto row = static_cast<std::size_t>(terrain_is_first ? point.m_index0 : point.m_index1);
    const Triangle t = terrain.triangle(2 * (row * (terrain.nx() - 1) + part / 2) + part % 2);
    const Eigen::Vector3d a = terrain.vertex(t[0]);
    const Eigen::Vector3d face = (terrain.vertex(t[1]) - a).cross(terrain.vertex(t[2]) - a).normalized();
    contact.gap_m *= contact.normal_world.dot(face);
    contact.normal_world = face;
  }

  void mix_materials(Contact& contact) const {
    const BodySpec& a = bodies[static_cast<std::size_t>(contact.a)].spec;
    const BodySpec& b = contact.b == kFixedBody ? a : bodies[static_cast<std::size_t>(contact.b)].spec;
    contact.friction = std::sqrt(a.friction * b.friction);
    contact.restitution = std::max(a.restitution, b.restitution);
  }

  /// Impulses are found on the velocities that free motion would end with, then act as steady forces over the step: so
  /// a body at rest stays at rest, two bodies' momentum is kept, and their work is that of the impulses.
  void solve_contacts(const Fluid& fluid) {
    contact_bodies.clear();
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const Pose& pose = bodies[k].state.world_from_body;
      contact_bodies.push_back({.world_from_body = pose,
                                .velocity_body = next_states[k].velocity_body,
                                .inverse_mass = bodies[k].spec.craft->inverse_mass(pose),
                                .arriving_velocity_body = bodies[k].state.velocity_body});
    }
    solver.solve(contact_bodies, contacts, step_s);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const ContactBody& solved = contact_bodies[k];
      if (solved.impulse_body.isZero(0) && solved.push_body.isZero(0)) continue;
      Loads loads{.body = bodies[k].tau_body};
      const Eigen::Quaterniond& q = solved.world_from_body.orientation;
      loads.world << q * solved.impulse_body.head<3>() / step_s, q * solved.impulse_body.tail<3>() / step_s;
      next_states[k] = advance(*bodies[k].spec.craft, bodies[k].state, loads, fluid, step_s);
      next_states[k].world_from_body = displaced(next_states[k].world_from_body, solved.push_body, step_s);
    }
    for (const Contact& contact : contacts) {
      if (contact.gap_m > kSkin_m) continue;
      bodies[static_cast<std::size_t>(contact.a)].in_contact = true;
      if (contact.b != kFixedBody) bodies[static_cast<std::size_t>(contact.b)].in_contact = true;
    }
  }

  void accept(Body& body, const BodyState& next) const {
    const bool sane = next.velocity_body.cwiseAbs().maxCoeff() < kAbsurd &&
                      next.world_from_body.position_m.cwiseAbs().maxCoeff() < kAbsurd;  // false for NaN too
    if (!sane) {
      std::ostringstream last;
      last << "[" << body.state.world_from_body.position_m.transpose() << " m; " << body.state.velocity_body.transpose()
           << " m/s, rad/s]";
      require(false, "vehicle '" + body.spec.name + "' last finite state", last.str(),
              "the motion diverged: use a smaller step_s or check the vehicle's coefficients");
    }
    body.acceleration_body = (next.velocity_body - body.state.velocity_body) / step_s;
    body.state = next;
  }

  void step(const Fluid& fluid) {
    next_states.resize(bodies.size());
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const Body& body = bodies[k];
      next_states[k] =
          body.held ? body.state : advance(*body.spec.craft, body.state, {.body = body.tau_body}, fluid, step_s);
    }
    find_contacts();
    if (!contacts.empty()) solve_contacts(fluid);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      if (!bodies[k].held) accept(bodies[k], next_states[k]);
    }
  }
};

void BodySpec::check() const {
  require(craft != nullptr, "vehicle '" + name + "' craft", "none", "must be set");
  require(friction >= 0 && friction <= 10, "vehicle.friction", friction, "must be in [0, 10]");
  require(restitution >= 0 && restitution <= 1, "vehicle.restitution", restitution, "must be in [0, 1]");
}

RigidBodyWorld::RigidBodyWorld(const World& world, double step_s) : impl_(std::make_unique<Impl>(world, step_s)) {}
RigidBodyWorld::~RigidBodyWorld() = default;
RigidBodyWorld::RigidBodyWorld(RigidBodyWorld&&) noexcept = default;
RigidBodyWorld& RigidBodyWorld::operator=(RigidBodyWorld&&) noexcept = default;

std::size_t RigidBodyWorld::add_body(BodySpec spec, const BodyState& state) {
  spec.check();
  Impl::Body body;
  body.shape = body_shape(spec.craft->hull().mesh_body(), spec.shape);
  body.object = std::make_unique<btCollisionObject>();
  body.object->setCollisionShape(body.shape.get());
  body.object->setCollisionFlags(0);  // neither static nor kinematic
  body.object->setActivationState(DISABLE_DEACTIVATION);
  body.object->setUserIndex(static_cast<int>(impl_->bodies.size()));
  body.object->setWorldTransform(to_bullet(state.world_from_body));
  body.spec = std::move(spec);
  body.state = state;
  impl_->bullet.addCollisionObject(body.object.get());
  impl_->bodies.push_back(std::move(body));
  return impl_->bodies.size() - 1;
}

const BodyState& RigidBodyWorld::state(std::size_t body) const { return impl_->bodies.at(body).state; }
void RigidBodyWorld::set_state(std::size_t index, const BodyState& state) {
  Impl::Body& body = impl_->bodies.at(index);
  body.state = state;
  body.acceleration_body.setZero();
  body.in_contact = false;
  if (body.held) return;
  // What Bullet remembers of old contacts must not bear on the new place.
  auto& pairs = *impl_->broadphase.getOverlappingPairCache();
  pairs.cleanProxyFromPairs(body.object->getBroadphaseHandle(), &impl_->dispatcher);
}

void RigidBodyWorld::hold(std::size_t index, bool held) {
  Impl::Body& body = impl_->bodies.at(index);
  if (held == body.held) return;
  body.held = held;
  if (held) {
    impl_->bullet.removeCollisionObject(body.object.get());
  } else {
    body.object->setWorldTransform(to_bullet(body.state.world_from_body));
    impl_->bullet.addCollisionObject(body.object.get());
  }
}
bool RigidBodyWorld::held(std::size_t body) const { return impl_->bodies.at(body).held; }
void RigidBodyWorld::set_wrench(std::size_t body, const Vector6d& tau_body) {
  impl_->bodies.at(body).tau_body = tau_body;
}
bool RigidBodyWorld::in_contact(std::size_t body) const { return impl_->bodies.at(body).in_contact; }
const Vector6d& RigidBodyWorld::acceleration_body(std::size_t body) const {
  return impl_->bodies.at(body).acceleration_body;
}
void RigidBodyWorld::step(const Fluid& fluid) { impl_->step(fluid); }

}  // namespace uwsim
