#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <thread>
#include <vector>

#include "dynamics/tethers.h"
#include "uwsim/dynamics/contact_shapes.h"

// Bodies and tethers among the pieces of a world's cover.
namespace uwsim::cover_contact_tests {
namespace {

constexpr double kBed_m = -10;

World bed(const std::vector<CoverLayer>& layers, double spacing_m = 1, double z_m = kBed_m) {
  World world = flat_bed(z_m, 61, spacing_m);
  for (const CoverLayer& layer : layers) world.add_cover(layer);
  return world;
}

/// Boulders with flat tops, 2 m wide and high, about 16 m apart.
CoverLayer boulders() {
  CoverLayer layer;
  layer.name = "boulders";
  layer.meshes = {testing::moved(testing::box(1, 1, 1), {0, 0, 0.5})};
  layer.density_per_m2 = 0.004;
  layer.size_m = {2, 2};
  layer.sunk = 0.1;
  layer.solid = true;
  return layer;
}

CoverLayer rubble() {
  CoverLayer layer;
  layer.name = "rubble";
  layer.meshes = {testing::sphere(0.5, 6), testing::box(1, 0.6, 0.8)};
  layer.stance = CoverStance::kTumbled;
  layer.density_per_m2 = 4;
  layer.size_m = {0.1, 0.8};
  layer.solid = true;
  return layer;
}

template <typename Visit>
void visit_pieces(const World& world, const Visit& visit) {
  const CoverPlan plan(world);
  for (std::uint32_t row = 0; row < plan.rows(); ++row) {
    for (std::uint32_t column = 0; column < plan.columns(); ++column) {
      const CoverTilePlan tile = plan.pieces(column, row);
      for (const CoverPiece& piece : tile.pieces) visit(piece, tile.middle_m + piece.at_m.cast<double>());
    }
  }
}

/// The same pieces as solids.
World with_solids(const World& world) {
  World fixed;
  fixed.set_terrain(*world.terrain());
  visit_pieces(world, [&](const CoverPiece& piece, const Eigen::Vector3d& at_m) {
    TriangleMesh mesh = world.cover()[0]->meshes[piece.mesh];
    for (Eigen::Vector3d& v : mesh.vertices_m) v = at_m + piece.turn.cast<double>() * v.cast<float>().cast<double>();
    fixed.add_solid("piece" + std::to_string(piece.number), mesh);
  });
  return fixed;
}

/// The pose of a boulder well inside the world.
Pose first_boulder(const World& world) {
  std::optional<Pose> found;
  visit_pieces(world, [&](const CoverPiece& piece, const Eigen::Vector3d& at_m) {
    if (found || at_m.head<2>().cwiseAbs().maxCoeff() > 20) return;
    found = {at_m, Eigen::Quaterniond(piece.turn.cast<double>() / piece.size_m).normalized()};
  });
  return found.value();
}

BodySpec box(double density_kg_m3, double damping = 50) {
  CraftParameters p = brick_parameters(density_kg_m3);
  p.linear_damping.diagonal() << damping, damping, damping, damping / 2, damping / 2, damping / 2;
  return {"box", craft_of(p)};
}

class CoverContact : public ::testing::TestWithParam<EngineKind> {};
INSTANTIATE_TEST_SUITE_P(WithEachEngine, CoverContact, ::testing::Values(EngineKind::kUwsim, EngineKind::kBullet));

TEST_P(CoverContact, ABoxRestsOnABoulderAtTheHeightOfItsMesh) {
  const World world = bed({boulders()});
  const Pose boulder = first_boulder(world);
  RigidBodyWorld bodies(world, kStep_s, GetParam());
  BodyState start;
  start.world_from_body = {boulder.position_m + Eigen::Vector3d(0, 0, 2.6), boulder.orientation};
  bodies.add_body(box(2000), start);
  run(bodies, 2000);
  EXPECT_NEAR(place_m(bodies).z(), kBed_m - 0.1 * 2 + 2 + 0.3, 1.5 * kRestGap_m);
  EXPECT_LT(bodies.state(0).velocity_body.norm(), 1e-3);
  EXPECT_TRUE(bodies.in_contact(0));
}

TEST_P(CoverContact, ABoulderStopsABodyThatIsDrivenAgainstIt) {
  const World world = bed({boulders()});
  const Pose boulder = first_boulder(world);
  RigidBodyWorld bodies(world, kStep_s, GetParam());
  BodyState start;
  start.world_from_body = {boulder.point({-4, 0, 0.9}), boulder.orientation};
  bodies.add_body(box(1000), start);
  bodies.set_wrench(0, ahead(40));
  run(bodies, 8000);
  const Eigen::Vector3d place = boulder.inverse().point(place_m(bodies));
  EXPECT_NEAR(place.x(), -1 - 0.6, 2 * kRestGap_m);
  EXPECT_LT(bodies.state(0).velocity_body.norm(), 1e-3);
}

TEST(Cover, BodiesMeetPiecesAsTheyMeetEqualSolids) {
  const World world = bed({rubble()}, 0.1), fixed = with_solids(world);
  for (const double x : {0.0, 1.7, -1.4}) {
    RigidBodyWorld one(world, kStep_s), other(fixed, kStep_s);
    for (RigidBodyWorld* bodies : {&one, &other}) bodies->add_body(box(2000), at(x, 0.3 * x, kBed_m + 1.5));
    for (RigidBodyWorld* bodies : {&one, &other}) run(*bodies, 600);
    EXPECT_LT((place_m(one) - place_m(other)).norm(), 1e-4);
    EXPECT_GT(place_m(one).z(), kBed_m + 0.32) << "it lies on the bed alone";
  }
}

TEST(Cover, AStepInContactDependsOnTheStateAlone) {
  const World world = bed({rubble()});
  RigidBodyWorld bodies(world, kStep_s);
  bodies.add_body(box(2000), at(0.4, 0.2, kBed_m + 1));
  run(bodies, 150);
  EXPECT_TRUE(bodies.in_contact(0));
  const std::string middle = saved(bodies);
  std::vector<std::string> ends(3);
  std::vector<std::jthread> threads;
  for (std::string& end : ends) {
    threads.emplace_back([&] {
      RigidBodyWorld other(world, kStep_s);
      other.add_body(box(2000), at(-9, 7, kBed_m + 0.5));
      run(other, 20);  // a different history
      restore(other, middle);
      run(other, 150);
      end = saved(other);
    });
  }
  threads.clear();
  run(bodies, 150);
  for (const std::string& end : ends) EXPECT_EQ(end, saved(bodies));
}

TEST(Cover, PassableAndSmallPiecesTouchNothing) {
  CoverLayer layer = rubble();
  layer.size_m = {0.01, 0.99 * CoverTriangles::kSmallest_m};
  layer.density_per_m2 = 100;
  const auto touches = [](const CoverLayer& of) {
    RigidBodyWorld bodies(bed({of}), kStep_s);
    bodies.add_body(box(1000), at(0, 0, kBed_m + 0.31));
    bodies.step(EvenWater{}, 0);
    return bodies.in_contact(0);
  };
  EXPECT_FALSE(touches(layer));
  layer.size_m = {0.1, 0.1};
  EXPECT_TRUE(touches(layer));
  layer.solid = false;
  EXPECT_FALSE(touches(layer));
}

TEST(Cover, TheLayerAroundAPointIsThatOfThePieceThatEnclosesIt) {
  const World world = bed({boulders()});
  const Pose boulder = first_boulder(world);
  const RigidBodyWorld bodies(world, kStep_s);
  EXPECT_EQ(bodies.cover_around(boulder.point({0.9, 0.9, 1.9}))->name, "boulders");
  EXPECT_EQ(bodies.cover_around(boulder.point({0.9, 0.9, 2.1})), nullptr);
  EXPECT_EQ(bodies.cover_around(boulder.point({1.1, 0.9, 1.9})), nullptr);
}

TEST(Cover, ATetherLiesOverABoulder) {
  const World world = bed({boulders()});
  const Pose boulder = first_boulder(world);
  RigidBodyWorld bodies(world, kStep_s);
  const TetherSpec spec = between(boulder.point({-2.5, 0.1, 2.6}), boulder.point({2.5, 0.1, 2.6}), 5.6, 40, 2, 1e5);
  const Tether& tether = bodies.tether(bodies.add_tether(spec, EvenWater{}, 0));
  run(bodies, 1000);
  double lowest_m = 1e9;
  for (std::size_t i = 0; i <= tether.elements(); ++i) {
    const Eigen::Vector3d place = boulder.inverse().point(tether.position_m(i));
    if (std::abs(place.x()) < 0.95) lowest_m = std::min(lowest_m, place.z() - 2);
  }
  EXPECT_NEAR(lowest_m, spec.diameter_m / 2, 0.3 * spec.diameter_m);  // on its top
}

/// Crossed upright leaves, each `width` wide and 1 high.
CoverLayer meadow(double width) {
  CoverLayer layer;
  layer.name = "meadow";
  TriangleMesh mesh;
  for (const Eigen::Vector3d& side : {Eigen::Vector3d(width / 2, 0, 0), Eigen::Vector3d(0, width / 2, 0)}) {
    const auto n = static_cast<std::uint32_t>(mesh.vertices_m.size());
    const Eigen::Vector3d up(0, 0, 1);
    for (const Eigen::Vector3d& v : {Eigen::Vector3d(-side), Eigen::Vector3d(side)})
      mesh.vertices_m.insert(mesh.vertices_m.end(), {v, v + up});
    mesh.triangles.insert(mesh.triangles.end(), {{n, n + 2, n + 1}, {n + 1, n + 2, n + 3}});
  }
  layer.meshes = {mesh};
  layer.density_per_m2 = 100;
  layer.size_m = {1.6, 1.6};
  layer.drag_coefficient = 1.1;
  return layer;
}

TEST_P(CoverContact, ABodyReachesTheSpeedAtWhichPlantsBalanceItsThrust) {
  const double width = 0.01, thrust_n = 300;
  RigidBodyWorld bodies(bed({meadow(width)}), kStep_s, GetParam());
  EvenWater water;
  water.current_world_m_s = {0.05, 0, 0};
  for (const double height_m : {0.8, 3.0})  // among plants and above them
    bodies.add_body(box(1000, 0), at(-20, 5 * height_m, kBed_m + height_m));
  for (std::size_t k = 0; k < 2; ++k) bodies.set_wrench(k, ahead(thrust_n));
  run(bodies, 1600, water);
  const double a_1_m = 100 * 2 * width * 1.6 * 2 / std::numbers::pi;  // frontal area per volume, of two leaves
  const double volume_m3 = 1.2 * 0.8 * 0.6;
  const double terminal_m_s = std::sqrt(2 * thrust_n / (1000 * 1.1 * a_1_m * volume_m3));
  EXPECT_NEAR(bodies.state(0).velocity_body[0] - 0.05, terminal_m_s, 1e-3 * terminal_m_s);
  EXPECT_NEAR(bodies.state(1).velocity_body[0], thrust_n * 1600 * kStep_s / (1000 * volume_m3), 1e-6);
}

TEST(Cover, DenseKelpStopsABodyWithoutThrowingItBack) {
  CoverLayer dense = meadow(1);
  dense.density_per_m2 = 1000;
  dense.size_m = {20, 20};
  RigidBodyWorld bodies(bed({dense}, 1, -30), 0.02);
  BodyState fast = at(0, 0, -20);
  fast.velocity_body << 8, 1, 0, 0, 0, 6;
  bodies.add_body(box(1000, 0), fast);
  double energy_j = bodies.spec(0).craft->kinetic_energy_j(fast);
  for (int k = 0; k < 50; ++k) {
    bodies.step(EvenWater{}, 0.02 * k);
    const double left_j = bodies.spec(0).craft->kinetic_energy_j(bodies.state(0));
    EXPECT_LT(left_j, energy_j);
    energy_j = left_j;
  }
  EXPECT_LT(bodies.state(0).velocity_body.norm(), 0.01);
}

TEST(Cover, ForcesOfPlantsArePartOfTheDrag) {
  RigidBodyWorld bodies(bed({meadow(0.01)}), kStep_s);
  BodyState fast = at(0, 0, kBed_m + 1.6);  // half of it among plants
  fast.velocity_body << 0.5, 0, 0, 0, 0, 0;
  bodies.add_body(box(1000, 0), fast);
  const Forces now = bodies.forces(0, EvenWater{}, 0);
  bodies.step(EvenWater{}, 0);
  const Forces mean = bodies.forces(0, EvenWater{}, 0);
  const double area_m2 = 1.1 * 100 * 2 * 0.01 * 1.6 * 2 / std::numbers::pi * 1.2 * 0.8 * 0.6;
  EXPECT_NEAR(now.craft.drag[0], -500 * area_m2 / 2 * 0.25, 1e-3 * area_m2);
  EXPECT_NEAR(now.craft.drag[4], 500 * area_m2 / 2 * 0.25 * 0.15, 1e-3 * area_m2);  // at its lower half's middle
  EXPECT_NEAR(mean.craft.drag[0], now.craft.drag[0], 1e-3);
  EXPECT_TRUE(mean.contact.isZero(1e-6));
  EXPECT_NEAR(mean.sum()[0], 576 * (bodies.state(0).velocity_body[0] - 0.5) / kStep_s, 1e-3);
}

}  // namespace
}  // namespace uwsim::cover_contact_tests
