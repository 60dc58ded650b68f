#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

#include "dynamics/bodies.h"
#include "uwsim/core/check.h"

// Bullet keeps points of contact and their impulses from step to step: with them, a body at rest stands. They are part
// of the state.
namespace uwsim {
namespace {

constexpr double kSlope = 0.3, kFriction = 0.6, kBoxDensity = 3000;
const Eigen::Vector3d kBoxSize_m(1.2, 0.8, 0.6);

/// A ramp, and a box whose lower face is 1 mm above it.
struct Ramp {
  Pose pose{{0, 0, -30}, Eigen::Quaterniond(Eigen::AngleAxisd(-std::atan(kSlope), Eigen::Vector3d::UnitY()))};
  TriangleMesh mesh = testing::placed(testing::box(20, 20, 2), pose);
  World world = solid_world(mesh, "ramp");
  BodyState start = at(pose.point({5, 0.3, 1.301}));

  Ramp() { start.world_from_body.orientation = pose.orientation; }
  /// The displacement along the ramp since the start.
  double slid_m(const Eigen::Vector3d& now_m) const {
    return (now_m - start.world_from_body.position_m).dot(pose.direction(Eigen::Vector3d::UnitX()));
  }
};

BodySpec heavy_box() {
  const TriangleMesh mesh = testing::box(kBoxSize_m.x(), kBoxSize_m.y(), kBoxSize_m.z());
  return body_of(craft_of(solid_of(mesh, kBoxDensity), mesh), kFriction, 0);
}

/// The same box on the same ramp in a btDiscreteDynamicsWorld with Bullet's default settings.
class StockBullet {
 public:
  explicit StockBullet(const Ramp& ramp) {
    for (const Triangle& t : ramp.mesh.triangles) {
      const auto corner = [&](std::size_t k) { return vector(ramp.mesh.vertices_m[t[k]]); };
      triangles_.addTriangle(corner(0), corner(1), corner(2));
    }
    surface_ = std::make_unique<btBvhTriangleMeshShape>(&triangles_, true);
    ground_ = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, surface_.get()));
    ground_->setFriction(1);
    const double mass_kg = kBoxDensity * kBoxSize_m.prod();
    btVector3 moments;
    shape_.calculateLocalInertia(mass_kg, moments);
    box_ = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(mass_kg, nullptr, &shape_, moments));
    box_->setFriction(kFriction);
    const Eigen::Quaterniond& q = ramp.pose.orientation;
    box_->setWorldTransform(
        btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), vector(ramp.start.world_from_body.position_m)));
    box_->setActivationState(DISABLE_DEACTIVATION);
    const EvenWater water;
    world_.setGravity({0, 0, -water.gravity_m_s2 * (1 - water.density_kg_m3 / kBoxDensity)});
    world_.addRigidBody(ground_.get());
    world_.addRigidBody(box_.get());
  }
  ~StockBullet() {
    world_.removeRigidBody(box_.get());
    world_.removeRigidBody(ground_.get());
  }

  void step(int steps) {
    for (int k = 0; k < steps; ++k) world_.stepSimulation(kStep_s, 0);
  }
  Eigen::Vector3d position_m() const {
    const btVector3& at = box_->getWorldTransform().getOrigin();
    return {at.x(), at.y(), at.z()};
  }

 private:
  static btVector3 vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

  btTriangleMesh triangles_;
  std::unique_ptr<btBvhTriangleMeshShape> surface_;
  btBoxShape shape_{vector(0.5 * kBoxSize_m)};
  std::unique_ptr<btRigidBody> ground_, box_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
};

std::string saved_state(RigidBodyWorld& bodies) {
  StateArchive archive;
  bodies.exchange_state(archive);
  bodies.exchange_contacts(archive);
  return archive.bytes();
}

void restore_from(const std::string& bytes, RigidBodyWorld& bodies) {
  StateArchive archive(bytes);
  bodies.exchange_state(archive);
  bodies.exchange_contacts(archive);
  archive.finish();
}

/// The size of the state without contacts, which follow it.
std::size_t bodies_end(RigidBodyWorld& bodies) {
  StateArchive archive;
  bodies.exchange_state(archive);
  return archive.bytes().size();
}

TEST(BulletContacts, ABoxStandsOnASlopeWhereStockBulletLetsItStand) {
  const Ramp ramp;
  RigidBodyWorld ours(ramp.world, kStep_s, EngineKind::kBullet);
  ours.add_body(heavy_box(), ramp.start);
  StockBullet stock(ramp);
  const auto slid_m = [&] { return std::array{ramp.slid_m(place_m(ours)), ramp.slid_m(stock.position_m())}; };
  const auto run = [&](int steps) {
    uwsim::run(ours, steps);
    stock.step(steps);
  };
  run(200);
  const auto [ours_settled_m, stock_settled_m] = slid_m();
  run(1800);
  const auto [ours_m, stock_m] = slid_m();
  EXPECT_LT(std::abs(ours_m), 1e-3);
  EXPECT_LT(std::abs(ours_m), std::abs(stock_m));
  EXPECT_LT(std::abs(stock_m - stock_settled_m), 1e-6) << "stock Bullet stands";
  EXPECT_LT(std::abs(ours_m - ours_settled_m), 1e-6) << "in 9 s";
  RecordProperty("ours_um", static_cast<int>(std::lround(ours_m * 1e6)));  // for the table in docs/inside/theory.md
  RecordProperty("stock_um", static_cast<int>(std::lround(stock_m * 1e6)));
}

/// Law: a body that came to rest obliquely, on a slope far below its friction, stands, whatever its weight in water.
TEST(BulletContacts, ABoxThatFellObliquelyStands) {
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(-std::atan(0.05), Eigen::Vector3d::UnitY()));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.6, Eigen::Vector3d(0.3, 1, 0.2).normalized()));
  const Pose pose{{0, 0, -30}, tilt};
  const World world = solid_world(testing::placed(testing::box(40, 40, 2), pose), "ramp");
  const TriangleMesh mesh = testing::box(1.2, 0.96, 0.72);
  for (const double density : {1050.0, 3000.0}) {
    CraftParameters p = solid_of(mesh, density);
    p.added_mass.diagonal() << p.mass_kg * Eigen::Vector3d(1, 1.5, 2), Eigen::Vector3d::Constant(0.1);
    BodyState start;
    start.world_from_body = {pose.point({2, 0.3, 2.44}), tilt * turn};
    RigidBodyWorld bodies(world, kStep_s, EngineKind::kBullet);
    bodies.add_body(body_of(craft_of(p, mesh), 0.5), start);
    const auto after_m = [&](int steps) {
      run(bodies, steps);
      return place_m(bodies);
    };
    const Eigen::Vector3d settled_m = after_m(4000);
    EXPECT_LT((after_m(1000) - settled_m).norm(), 2e-5) << density << " kg/m3, in 5 s";
  }
}

/// A box that stands on a ramp, and its state with contacts.
class ContactsOfABox : public ::testing::Test {
 protected:
  ContactsOfABox() {
    bodies.add_body(heavy_box(), ramp.start);
    run(bodies, 100);
    state = saved_state(bodies);
    contacts = bodies_end(bodies);
  }

  /// The state with one number replaced, `words` numbers of eight bytes after the list's length.
  template <typename Number>
  std::string forged(std::size_t words, Number number) const {
    static_assert(sizeof number == 8);
    std::string bytes = state;
    std::memcpy(bytes.data() + contacts + 8 * (1 + words), &number, sizeof number);
    return bytes;
  }

  const Ramp ramp;
  RigidBodyWorld bodies{ramp.world, kStep_s, EngineKind::kBullet};
  std::string state;
  std::size_t contacts = 0;
};

TEST_F(ContactsOfABox, AStateWithAValueOutOfBoundsIsRefused) {
  // One contact: object, piece, object, piece, number of points, then by point: two positions, normal, impulse.
  std::uint64_t count = 0;
  std::memcpy(&count, state.data() + contacts, sizeof count);
  ASSERT_EQ(count, 1u);
  const std::size_t kPoint = 5, kNormal = kPoint + 6, kImpulse = kNormal + 3;
  const auto refused = [&](const std::string& bytes) { EXPECT_THROW(restore_from(bytes, bodies), InvalidValue); };
  for (const std::int64_t object : {-3, 1, 1 << 30}) refused(forged(0, object));
  refused(forged(0, std::int64_t{1} << 40));
  for (const std::int64_t piece : {-2, 1}) refused(forged(1, piece));
  refused(forged(2, std::int64_t{0}));  // the body itself
  refused(forged(3, std::int64_t{0}));  // the ground has no pieces
  for (const std::int64_t points : {0, 5, 1 << 30}) refused(forged(4, points));
  for (const double far_m : {2.0, -1e300, std::numeric_limits<double>::quiet_NaN()}) refused(forged(kPoint, far_m));
  refused(forged(kPoint + 3, 1e3));
  refused(forged(kNormal, 0.5));
  for (const double impulse : {-1.0, 1e12, std::numeric_limits<double>::infinity()}) refused(forged(kImpulse, impulse));
  std::string twice = state + state.substr(contacts + 8);
  twice[contacts] = 2;
  refused(twice);
  for (std::size_t size = contacts; size < state.size(); ++size) refused(state.substr(0, size));
  restore_from(state, bodies);
  EXPECT_EQ(saved_state(bodies), state);
}

TEST_F(ContactsOfABox, ABodyThatIsPlacedHeldOrReshapedHasNone) {
  const BodySpec spec = heavy_box();
  BodySpec moved = spec, loaded = spec;
  CraftParameters shifted = spec.craft->parameters(), heavier = shifted;
  shifted.centre_of_mass_body_m.z() = -0.01;
  heavier.mass_kg *= 1.01;
  moved.craft = std::make_shared<const Craft>(shifted, spec.craft->hull());
  loaded.craft = std::make_shared<const Craft>(heavier, spec.craft->hull());
  const auto number = [&] { return (saved_state(bodies).size() - contacts - 8) > 0; };
  for (const auto& change :
       std::vector<std::function<void()>>{[&] { bodies.set_state(0, ramp.start); }, [&] { bodies.hold(0, true); },
                                          [&] { bodies.change_bodies({moved}); }}) {
    restore_from(state, bodies);
    change();
    EXPECT_FALSE(number());
  }
  bodies.change_bodies({spec});
  restore_from(state, bodies);
  bodies.change_bodies({loaded});
  EXPECT_TRUE(number()) << "only its mass has changed";
}

}  // namespace
}  // namespace uwsim
