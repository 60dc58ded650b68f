#include "uwsim/camera/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "meshes.h"
#include "uwsim/camera/refraction.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

TriangleMesh box_mesh(const Eigen::Vector3d& middle, const Eigen::Vector3d& size) {
  TriangleMesh mesh = testing::box(size.x(), size.y(), size.z());
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex += middle;
  return mesh;
}

World hilly_lake() {
  std::vector<float> heights;
  for (int j = 0; j < 81; ++j) {
    for (int i = 0; i < 81; ++i)
      heights.push_back(-12 + 2 * std::sin(0.3f * static_cast<float>(i)) + 0.12f * static_cast<float>(j));
  }
  World world;
  world.set_terrain(Heightfield(heights, 81, 81, 1.0, {-40, -40}));
  world.add_solid("box", box_mesh({3, 0.5, -5.5}, {1, 1, 2}));
  return world;
}

Optics some_light() {
  Optics optics;
  optics.water = jerlov_water("III");
  optics.particles_per_m3 = 40;
  return optics;
}

Exposure from(const Eigen::Vector3d& eye, double pitch_down_rad) {
  Exposure exposure;
  exposure.world_from_camera = {eye, Eigen::Quaterniond(Eigen::AngleAxisd(pitch_down_rad, Eigen::Vector3d::UnitY()))};
  exposure.time_s = 12.5;
  exposure.tick = 12'500'000'000;
  Lamp lamp;
  lamp.world_from_lamp = exposure.world_from_camera;
  lamp.world_from_lamp.position_m += Eigen::Vector3d(0, 0.4, 0.1);
  exposure.lamps = {lamp};
  exposure.keep_radiance = true;
  return exposure;
}

class Cameras : public ::testing::Test {
 protected:
  Cameras() : scene(world, std::make_shared<RayScene>(world), 7) {
    scene.add_body("craft", box_mesh({0, 0, 0}, {1, 0.6, 0.4}), {material("paint"), SurfaceClass::kVehicle, nullptr});
    Lens lens;
    lens.width = 101, lens.height = 67;  // no multiples of a block
    lens.fx = lens.fy = 60, lens.cx = 50, lens.cy = 33;
    lens.k1 = -0.1;
    camera = std::make_unique<Camera>("test", lens, ImageSensor{});
  }
  World world = hilly_lake();
  CameraScene scene;
  std::unique_ptr<Camera> camera;
  Optics optics = some_light();
};

void expect_same(const Picture& a, const Picture& b, const char* what) {
  EXPECT_EQ(a.rgb, b.rgb) << what;
  EXPECT_EQ(a.depth_m, b.depth_m) << what;
  EXPECT_EQ(a.normals_world, b.normals_world) << what;
  EXPECT_EQ(a.labels, b.labels) << what;
  EXPECT_EQ(a.radiance, b.radiance) << what;
}

TEST_F(Cameras, OnePictureWhateverTheThreadsAndTheKindOfVectorUnit) {
  for (const auto& [eye, pitch] :
       {std::pair(Eigen::Vector3d(-4, 0, -4), 0.1), std::pair(Eigen::Vector3d(-6, 1, 3), 0.4),
        std::pair(Eigen::Vector3d(0, 1, -2.5), -1.2)}) {
    Exposure exposure = from(eye, pitch);
    exposure.world_from_bodies = {{eye + Eigen::Vector3d(2.5, -0.6, -0.3), Eigen::Quaterniond::Identity()}};
    exposure.kernels = &camera::baseline_kernels();
    const Picture one = render(scene, *camera, optics, exposure);
    for (const int threads : {2, 3, 5}) {
      exposure.threads = threads;
      expect_same(one, render(scene, *camera, optics, exposure), "threads");
    }
    if (__builtin_cpu_supports("avx2")) {
      exposure.kernels = camera::avx2_kernels();
      expect_same(one, render(scene, *camera, optics, exposure), "avx2");
    }
    if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512f")) {
      exposure.kernels = camera::avx512_kernels();
      expect_same(one, render(scene, *camera, optics, exposure), "avx512");
    }
    for (const float value : one.radiance) ASSERT_TRUE(std::isfinite(value) && value >= 0);
  }
}

// Where Embree splits packets, for lack of AVX-512, Debian's ends the process over idle rays that are not finite.
TEST_F(Cameras, IdleRaysAreFiniteToo) {
  RayRecord record;
  Exposure exposure = from({-1, 0, -4.5}, 0.1);
  exposure.record = &record;
  render(scene, *camera, optics, exposure);
  std::size_t idle = 0;
  for (const RayRecord::Packet& packet : record.packets) {
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      idle += packet.active[k] == 0 ? 1 : 0;
      for (const RayPacket::Lanes& row : packet.rows) ASSERT_TRUE(std::isfinite(row[k]));
    }
  }
  EXPECT_GT(idle, 100u);
}

TEST_F(Cameras, EveryEffectChangesThePictureAndGeometryStays) {
  Exposure exposure = from({-1, 0, -4.5}, 0.25);
  const Picture whole = render(scene, *camera, optics, exposure);
  for (std::size_t k = 0; k < kEffectNames.size(); ++k) {
    exposure.effects = Effects::all();
    exposure.effects.set(static_cast<Effect>(k), false);
    const Picture without = render(scene, *camera, optics, exposure);
    EXPECT_TRUE(whole.rgb != without.rgb) << kEffectNames[k];
    const bool bends = static_cast<Effect>(k) == Effect::kWobble || static_cast<Effect>(k) == Effect::kDistortion;
    EXPECT_EQ(whole.depth_m == without.depth_m, !bends) << kEffectNames[k];
  }
  exposure.effects = Effects::all();
  exposure.geometry_only = true;
  const Picture bare = render(scene, *camera, optics, exposure);
  EXPECT_EQ(bare.depth_m, whole.depth_m);
  EXPECT_EQ(bare.labels, whole.labels);
  EXPECT_EQ(bare.normals_world, whole.normals_world);
  EXPECT_TRUE(bare.rgb.empty());
}

/// A plate in open water throws a shadow into it. `side_m`: along x and y.
Picture under_a_plate(double side_m, const Camera& camera, const Optics& optics, const Effects& effects) {
  World world;
  world.add_solid("plate", box_mesh({6, 0, -2}, {side_m, side_m, 0.1}));
  Exposure exposure = from({0, 0, -7}, 0.45);
  exposure.lamps.clear();
  exposure.effects = effects;
  return render(CameraScene(world, std::make_shared<RayScene>(world), 7), camera, optics, exposure);
}

/// Share of the sun's beam that the plate leaves of what water scatters along a pixel's ray, by points of its own.
double lit_share(const Eigen::Vector2d& pixel, double side_m, const Camera& camera, const Optics& optics) {
  const Eigen::Vector2d ray = unproject(camera.lens(), pixel, false);
  const Pose pose = from({0, 0, -7}, 0.45).world_from_camera;
  const Eigen::Vector3d way = pose.direction(Eigen::Vector3d(1, -ray.x(), -ray.y()).normalized());
  const Eigen::Vector3d sun = daylight_below(daylight(optics.sun), optics.water.refractive_index).to_sun_world;
  const double c = optics.water.beam_attenuation()(1);
  double lit = 0, whole = 0;
  for (int k = 0; k < 400; ++k) {
    const double t = 3 / c * (k + 0.5) / 400;
    const Eigen::Vector3d at = pose.position_m + t * way;
    const Eigen::Vector3d above = at + (-2 - at.z()) / sun.z() * sun;
    const bool shaded = std::abs(above.x() - 6) < side_m / 2 && std::abs(above.y()) < side_m / 2;
    const double kb = optics.water.diffuse_attenuation(1) + 0.2 * optics.water.scattering(1) / sun.z();
    const double weight = std::exp(t * (kb * way.z() - c));
    whole += weight, lit += shaded ? 0 : weight;
  }
  return lit / whole;
}

// In this small picture, whose sides are 25 and 17 blocks, eight points a ray err by 0.031 in the mean and 0.083 at
// most; shadows that four blocks share make that 0.034 and 0.114.
TEST_F(Cameras, ShadowsInTheWaterLieWhereThePlateThrowsThem) {
  Effects effects = Effects::none();
  for (const Effect effect : {Effect::kAttenuation, Effect::kBackscatter, Effect::kSunlight, Effect::kShadows}) {
    effects.set(effect, true);
  }
  const std::vector<float> bright = under_a_plate(4, *camera, optics, effects).radiance;
  effects.set(Effect::kShafts, true);
  const std::vector<float> with = under_a_plate(4, *camera, optics, effects).radiance;
  const std::vector<float> dark = under_a_plate(400, *camera, optics, effects).radiance;
  double error = 0, most = 0, least_lit = 1;
  for (int v = 0; v < 67; ++v) {
    for (int u = 0; u < 101; ++u) {
      const auto green = static_cast<std::size_t>(3 * (101 * v + u) + 1);
      const double share = (with[green] - dark[green]) / (bright[green] - dark[green]);
      const double expected = lit_share({u, v}, 4, *camera, optics);
      least_lit = std::min(least_lit, expected);
      error += std::abs(share - expected) / (67 * 101);
      most = std::max(most, std::abs(share - expected));
    }
  }
  EXPECT_LT(least_lit, 0.6);  // there is a shadow to be seen
  EXPECT_LT(error, 0.035);
  EXPECT_LT(most, 0.12);
}

TEST_F(Cameras, CausticsMoveWithTimeAndNoiseWithTheTick) {
  Exposure exposure = from({-4, 0, -4}, 0.6);
  exposure.effects = Effects::none();
  exposure.effects.set(Effect::kSunlight, true);
  exposure.effects.set(Effect::kCaustics, true);
  const Picture before = render(scene, *camera, optics, exposure);
  exposure.tick += 1;
  EXPECT_EQ(before.rgb, render(scene, *camera, optics, exposure).rgb);
  exposure.time_s += 0.2;
  EXPECT_NE(before.rgb, render(scene, *camera, optics, exposure).rgb);
  exposure.effects = Effects::none();
  exposure.effects.set(Effect::kNoise, true);
  const Picture noisy = render(scene, *camera, optics, exposure);
  exposure.tick += 1;
  EXPECT_NE(noisy.rgb, render(scene, *camera, optics, exposure).rgb);
}

/// Cosine between what two pictures hold of specks alone: 1 for the same specks, about 0 for others.
double likeness(const std::vector<float>& a, const std::vector<float>& b) {
  const Eigen::Map<const Eigen::VectorXf> first(a.data(), static_cast<Eigen::Index>(a.size()));
  const Eigen::Map<const Eigen::VectorXf> second(b.data(), static_cast<Eigen::Index>(b.size()));
  return first.dot(second) / (first.norm() * second.norm());
}

TEST_F(Cameras, SpecksDriftWithTheFlowHoweverLongItHasChanged) {
  World gusty = hilly_lake();
  gusty.water.currents = {gusty_current({0.2, 0.2, 0.05}, 5, 3)};
  const CameraScene there(gusty, std::make_shared<RayScene>(gusty), 7);
  Exposure exposure = from({-4, 0, -4}, 0.0);
  exposure.effects = Effects::none();
  exposure.effects.set(Effect::kSunlight, true);
  const auto specks = [&](double time_s) {
    exposure.time_s = time_s;
    exposure.effects.set(Effect::kParticles, false);
    const std::vector<float> without = render(there, *camera, optics, exposure).radiance;
    exposure.effects.set(Effect::kParticles, true);
    std::vector<float> with = render(there, *camera, optics, exposure).radiance;
    for (std::size_t k = 0; k < with.size(); ++k) with[k] -= without[k];
    return with;
  };
  for (const double time_s : {3601.0, 3603.999, 7204.5}) {  // the second as a generation begins
    EXPECT_GT(likeness(specks(time_s), specks(time_s + 0.002)), 0.98) << time_s;
  }
  EXPECT_LT(likeness(specks(3601), specks(3613)), 0.5);
}

TEST_F(Cameras, OthersSeeTheVehicleItsOwnCameraDoesNot) {
  Exposure exposure = from({-4, 0, -4}, 0.1);
  exposure.world_from_bodies = {{exposure.world_from_camera.position_m, Eigen::Quaterniond::Identity()}};
  const std::uint16_t craft = 3;
  const auto sees = [&] {
    const Picture picture = render(scene, *camera, optics, exposure);
    return std::count(picture.labels.begin(), picture.labels.end(), craft) > 0;
  };
  EXPECT_TRUE(sees());  // from within
  exposure.hidden = 0;
  EXPECT_FALSE(sees());
  exposure.hidden.reset();
  exposure.world_from_bodies[0].position_m.x() += 3;
  EXPECT_TRUE(sees());
}

TEST_F(Cameras, RefusesImpossiblePlacesAndFigures) {
  EXPECT_THROW(render(scene, *camera, optics, from({0, 0, -30}, 0)), InvalidValue);
  EXPECT_THROW(render(scene, *camera, optics, from({0, 0, NAN}, 0)), InvalidValue);
  EXPECT_THROW(jerlov_water("IV"), InvalidValue);
  EXPECT_THROW(material("gold"), InvalidValue);
  for (const int side : {0, -3, 8193, 2'000'000'000}) {
    Lens lens;
    lens.width = side;
    EXPECT_THROW(Camera("bad", lens, {}), InvalidValue) << side;
  }
  Lens folded;
  folded.k1 = -2;
  EXPECT_THROW(Camera("bad", folded, {}), InvalidValue);
}

TEST(Refraction, FollowsSnellAndConservesEnergy) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (double degrees = 0; degrees < 90; degrees += 7) {
    const double angle = degrees * std::numbers::pi / 180;
    const auto below = refracted({std::sin(angle), 0, -std::cos(angle)}, up, 1, 1.333);
    ASSERT_TRUE(below);
    EXPECT_NEAR(below->norm(), 1, 1e-12);
    EXPECT_NEAR(1.333 * below->x(), std::sin(angle), 1e-12);
    const double inside = -below->z();  // the way back loses as much
    EXPECT_NEAR(fresnel_reflectance(std::cos(angle), 1, 1.333), fresnel_reflectance(inside, 1.333, 1), 1e-9);
  }
  EXPECT_FALSE(refracted({std::sin(0.9), 0, std::cos(0.9)}, -up, 1.333, 1));
  EXPECT_EQ(fresnel_reflectance(std::cos(0.9), 1.333, 1), 1);
}

TEST(Ripples, LightIsConservedAndSlopesHaveTheirVariance) {
  const Ripples ripples(5, 0.3, 11);
  const Ripples::Moment moment = ripples.at(3.7, 1.333, 2);
  for (int level = 0; level < Ripples::kLevels; ++level) {
    double sum = 0, square = 0;
    for (std::size_t k = static_cast<std::size_t>(level); k < moment.caustics.size(); k += Ripples::kLevels) {
      sum += moment.caustics[k], square += moment.caustics[k] * moment.caustics[k];
    }
    const double cells = Ripples::kCells * Ripples::kCells;
    EXPECT_NEAR(sum / cells, 1, 1e-4) << level;
    EXPECT_GT(square / cells, 1.005) << level;  // it is uneven
  }
  double variance = 0;
  for (const float slope : moment.slopes) variance += slope * slope;
  EXPECT_NEAR(variance / (Ripples::kCells * Ripples::kCells), 0.5 * (0.003 + 0.00512 * 5), 0.15 * 0.0143);
}

}  // namespace
}  // namespace uwsim
