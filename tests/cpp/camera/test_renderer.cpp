#include "uwsim/camera/prepared_view.h"
#include "uwsim/camera/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <tuple>

#include "meshes.h"
#include "uwsim/camera/parallel_rows.h"
#include "uwsim/core/check.h"
#include "uwsim/core/instruction_set.h"

namespace uwsim {
namespace {

TriangleMesh box_mesh(const Eigen::Vector3d& centre, const Eigen::Vector3d& size) {
  TriangleMesh mesh = testing::box(size.x(), size.y(), size.z());
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex += centre;
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

PictureRequest from(const Eigen::Vector3d& eye, double pitch_down_rad) {
  PictureRequest request;
  request.world_from_camera = {eye, Eigen::Quaterniond(Eigen::AngleAxisd(pitch_down_rad, Eigen::Vector3d::UnitY()))};
  request.time_s = 12.5;
  request.tick = 12'500'000'000;
  SpotLamp lamp;
  lamp.world_from_lamp = request.world_from_camera;
  lamp.world_from_lamp.position_m += Eigen::Vector3d(0, 0.4, 0.1);
  request.lamps = {lamp};
  request.keep_radiance = true;
  return request;
}

ImageSensor moving_sensor() {
  ImageSensor sensor;
  sensor.shutter_s = 0.02, sensor.readout_s = 0.03;
  return sensor;
}

class Renderer : public ::testing::Test {
 protected:
  Renderer() : scene(world, std::make_shared<RayScene>(world), 7) {
    scene.add_vehicle("vehicle", box_mesh({0, 0, 0}, {1, 0.6, 0.4}),
                      {material("paint"), SurfaceClass::kVehicle, std::nullopt});
    Lens lens;
    lens.width = 101, lens.height = 67;  // not multiples of a block's edge
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

TEST_F(Renderer, ThePictureDependsNeitherOnThreadsNorOnTheInstructionSet) {
  for (const auto& [eye, pitch] :
       {std::pair(Eigen::Vector3d(-4, 0, -4), 0.1), std::pair(Eigen::Vector3d(-6, 1, 3), 0.4),
        std::pair(Eigen::Vector3d(0, 1, -2.5), -1.2)}) {
    PictureRequest request = from(eye, pitch);
    request.world_from_vehicles = {{eye + Eigen::Vector3d(2.5, -0.6, -0.3), Eigen::Quaterniond::Identity()}};
    request.kernels = &camera::baseline_kernels();
    const Picture one = render(scene, *camera, optics, request);
    for (const int threads : {2, 3, 5}) {
      request.threads = threads;
      expect_same(one, render(scene, *camera, optics, request), "threads");
    }
    if (processor_has(InstructionSet::avx2)) {
      request.kernels = &camera::avx2_kernels();
      expect_same(one, render(scene, *camera, optics, request), "avx2");
    }
    if (processor_has(InstructionSet::avx512)) {
      request.kernels = &camera::avx512_kernels();
      expect_same(one, render(scene, *camera, optics, request), "avx512");
    }
    for (const float value : one.radiance) ASSERT_TRUE(std::isfinite(value) && value >= 0);
  }
}

// Without AVX-512, Embree splits packets, and Debian's build aborts the process if inactive rays are not finite.
TEST_F(Renderer, InactiveRaysAreFinite) {
  RayRecord record;
  PictureRequest request = from({-1, 0, -4.5}, 0.1);
  request.record = &record;
  render(scene, *camera, optics, request);
  std::size_t inactive = 0;
  for (const RayRecord::Packet& packet : record.packets) {
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      inactive += packet.active[k] == 0 ? 1 : 0;
      for (const RayPacket::Lanes& row : packet.rows) ASSERT_TRUE(std::isfinite(row[k]));
    }
  }
  EXPECT_GT(inactive, 100u);
}

TEST_F(Renderer, EveryEffectChangesThePictureButNotItsGeometry) {
  PictureRequest request = from({-1, 0, -4.5}, 0.25);
  request.velocity_camera << 0.5, 0.2, 0, 0, 0, 0.3;
  camera = std::make_unique<Camera>("test", camera->lens(), moving_sensor());
  const Picture whole = render(scene, *camera, optics, request);
  for (std::size_t k = 0; k < kEffectNames.size(); ++k) {
    request.effects = Effects::all();
    request.effects.set(static_cast<Effect>(k), false);
    const Picture without = render(scene, *camera, optics, request);
    EXPECT_TRUE(whole.rgb != without.rgb) << kEffectNames[k];
    const auto effect = static_cast<Effect>(k);
    const bool bends_rays = effect == Effect::kWobble || effect == Effect::kDistortion || effect == Effect::kShutter;
    EXPECT_EQ(whole.depth_m == without.depth_m, !bends_rays) << kEffectNames[k];
  }
  request.effects = Effects::all();
  request.geometry_only = true;
  const Picture bare = render(scene, *camera, optics, request);
  EXPECT_EQ(bare.depth_m, whole.depth_m);
  EXPECT_EQ(bare.labels, whole.labels);
  EXPECT_EQ(bare.normals_world, whole.normals_world);
  EXPECT_TRUE(bare.rgb.empty());
}

/// Renders the shadow that a plate in open water casts into the water. `side_m`: along x and y.
Picture under_a_plate(double side_m, const Camera& camera, const Optics& optics, const Effects& effects) {
  World world;
  world.add_solid("plate", box_mesh({6, 0, -2}, {side_m, side_m, 0.1}));
  PictureRequest request = from({0, 0, -7}, 0.45);
  request.lamps.clear();
  request.effects = effects;
  return render(CameraScene(world, std::make_shared<RayScene>(world), 7), camera, optics, request);
}

/// The fraction of sunlight, weighted by its scattering towards the camera, that passes the plate and reaches the water
/// along a pixel's ray; sampled independently of the renderer.
double lit_share(const Eigen::Vector2d& pixel, double side_m, const Camera& camera, const Optics& optics) {
  const Eigen::Vector2d ray = *unproject(camera.lens(), pixel, false);
  const Pose pose = from({0, 0, -7}, 0.45).world_from_camera;
  const Eigen::Vector3d direction = pose.direction(Eigen::Vector3d(1, -ray.x(), -ray.y()).normalized());
  const Eigen::Vector3d sun = daylight_below(daylight(optics.sun), optics.water.refractive_index).to_sun_world;
  const double c = optics.water.beam_attenuation()(1);
  double lit = 0, whole = 0;
  for (int k = 0; k < 400; ++k) {
    const double t = 3 / c * (k + 0.5) / 400;
    const Eigen::Vector3d at = pose.position_m + t * direction;
    const Eigen::Vector3d above = at + (-2 - at.z()) / sun.z() * sun;
    const bool shaded = std::abs(above.x() - 6) < side_m / 2 && std::abs(above.y()) < side_m / 2;
    const double kb = optics.water.diffuse_attenuation(1) + 0.2 * optics.water.scattering(1) / sun.z();
    const double weight = std::exp(t * (kb * direction.z() - c));
    whole += weight, lit += shaded ? 0 : weight;
  }
  return lit / whole;
}

// In this small picture of 25 x 17 blocks, the error with eight samples per ray is 0.031 on average and at most 0.083;
// sharing shadows among four blocks, and mixing them with their neighbours, makes these 0.035 and 0.096.
TEST_F(Renderer, ShadowsInTheWaterLieWhereThePlateCastsThem) {
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
  EXPECT_LT(least_lit, 0.6);  // the picture shows a shadow
  EXPECT_LT(error, 0.035);
  EXPECT_LT(most, 0.12);
}

TEST_F(Renderer, CausticsMoveWithTimeAndNoiseWithTheTick) {
  PictureRequest request = from({-4, 0, -4}, 0.6);
  request.effects = Effects::none();
  request.effects.set(Effect::kSunlight, true);
  request.effects.set(Effect::kCaustics, true);
  const Picture before = render(scene, *camera, optics, request);
  request.tick += 1;
  EXPECT_EQ(before.rgb, render(scene, *camera, optics, request).rgb);
  request.time_s += 0.2;
  EXPECT_NE(before.rgb, render(scene, *camera, optics, request).rgb);
  request.effects = Effects::none();
  request.effects.set(Effect::kNoise, true);
  const Picture noisy = render(scene, *camera, optics, request);
  request.tick += 1;
  EXPECT_NE(noisy.rgb, render(scene, *camera, optics, request).rgb);
}

// A picture that computes only the caustics that it needs equals one of a scene that has all of them.
TEST_F(Renderer, DeepPicturesNeedOnlyDeepCaustics) {
  const auto computed_from = [&](const CameraScene& of, int level) {
    return of.ripples(optics.wind_m_s, 0, optics.fetch_m, 12.5, focused_sun(optics), level, 1)->first_level;
  };
  for (const auto& [z_m, pitch, expected] : {std::tuple(-8.0, 0.9, 4), {-4.6, 0.6, 3}, {-4.0, 0.1, 0}, {3.0, 0.4, 0}}) {
    const PictureRequest request = from({-4, 0, z_m}, pitch);
    const CameraScene some(scene, world.water, 7), all(scene, world.water, 7);
    EXPECT_EQ(computed_from(all, 0), 0);
    const Picture picture = render(some, *camera, optics, request);
    expect_same(picture, render(all, *camera, optics, request), "all caustics");
    EXPECT_EQ(computed_from(some, 4), expected) << z_m;
  }
}

// Water beside a near pillar is as bright as it would be without it: values of shafts, which are coarse, belong to rays
// of about the same length.
TEST_F(Renderer, ShaftsDoNotLeakAroundNearSolids) {
  World with_pillar = hilly_lake();
  with_pillar.add_solid("pillar", box_mesh({-2.5, 0.1, -4}, {0.2, 0.3, 6}));
  const CameraScene other(with_pillar, std::make_shared<RayScene>(with_pillar), 7);
  PictureRequest request = from({-4, 0, -3}, -0.3);
  request.lamps.clear();
  for (const Effect effect : {Effect::kShadows, Effect::kParticles, Effect::kNoise}) {
    request.effects.set(effect, false);
  }
  optics.wind_m_s = 8;
  const Picture without = render(scene, *camera, optics, request), with = render(other, *camera, optics, request);
  request.effects.set(Effect::kShafts, false);
  const Picture even = render(scene, *camera, optics, request);
  int compared = 0;
  double error = 0, contrast = 0;
  for (std::size_t k = 0; k < with.depth_m.size(); ++k) {
    if (with.depth_m[k] != without.depth_m[k]) continue;
    const std::size_t g = 3 * k + 1;
    ++compared;
    error = std::max(error, std::abs(double{with.radiance[g]} / without.radiance[g] - 1));
    contrast = std::max(contrast, std::abs(double{without.radiance[g]} / even.radiance[g] - 1));
  }
  EXPECT_GT(compared, 3000);
  EXPECT_LT(error, 0.2 * contrast);
}

// The edge of a shadow in the water runs through blocks of pixels and sample points without steps.
TEST_F(Renderer, ShadowsInTheWaterHaveNoSteps) {
  World with_roof = hilly_lake();
  with_roof.add_solid("roof", box_mesh({1, 1, -0.6}, {3, 2, 0.2}));
  const CameraScene roofed(with_roof, std::make_shared<RayScene>(with_roof), 7);
  PictureRequest request = from({-4, 0, -3}, -0.3);
  request.lamps.clear();
  for (const Effect effect : {Effect::kCaustics, Effect::kParticles, Effect::kNoise})
    request.effects.set(effect, false);
  const Picture with = render(roofed, *camera, optics, request);
  request.effects.set(Effect::kShafts, false);
  const Picture even = render(roofed, *camera, optics, request);
  const auto shade = [&](std::size_t k) { return double{with.radiance[3 * k + 1]} / even.radiance[3 * k + 1]; };
  double step = 0, least = 1, most = 0;
  for (std::size_t k = 1; k < with.depth_m.size(); ++k) {
    if (k % static_cast<std::size_t>(with.width) == 0 || with.labels[k] != with.labels[k - 1]) continue;
    if (std::isfinite(with.depth_m[k])) continue;
    step = std::max(step, std::abs(shade(k) - shade(k - 1)));
    least = std::min(least, shade(k)), most = std::max(most, shade(k));
  }
  EXPECT_LT(least, 0.8 * most);
  EXPECT_LT(step, 0.05);
}

/// The cosine similarity of two pictures of particles: 1 for the same particles, about 0 for others.
double likeness(const std::vector<float>& a, const std::vector<float>& b) {
  const Eigen::Map<const Eigen::VectorXf> first(a.data(), static_cast<Eigen::Index>(a.size()));
  const Eigen::Map<const Eigen::VectorXf> second(b.data(), static_cast<Eigen::Index>(b.size()));
  return first.dot(second) / (first.norm() * second.norm());
}

TEST_F(Renderer, ParticlesDriftWithAChangingFlowAtAnyTime) {
  World gusty = hilly_lake();
  gusty.water.currents = {gusty_current({0.2, 0.2, 0.05}, 5, 3)};
  const CameraScene gusty_scene(gusty, std::make_shared<RayScene>(gusty), 7);
  PictureRequest request = from({-4, 0, -4}, 0.0);
  request.effects = Effects::none();
  request.effects.set(Effect::kSunlight, true);
  const auto particles = [&](double time_s) {
    request.time_s = time_s;
    request.effects.set(Effect::kParticles, false);
    const std::vector<float> without = render(gusty_scene, *camera, optics, request).radiance;
    request.effects.set(Effect::kParticles, true);
    std::vector<float> with = render(gusty_scene, *camera, optics, request).radiance;
    for (std::size_t k = 0; k < with.size(); ++k) with[k] -= without[k];
    return with;
  };
  for (const double time_s : {3601.0, 3603.999, 7204.5}) {  // the second is just before a new generation
    EXPECT_GT(likeness(particles(time_s), particles(time_s + 0.002)), 0.98) << time_s;
  }
  EXPECT_LT(likeness(particles(3601), particles(3613)), 0.5);
}

TEST_F(Renderer, AVehicleIsSeenByOtherCamerasButNotByItsOwn) {
  PictureRequest request = from({-4, 0, -4}, 0.1);
  request.world_from_vehicles = {{request.world_from_camera.position_m, Eigen::Quaterniond::Identity()}};
  const std::uint16_t vehicle = 3;
  const auto sees = [&] {
    const Picture picture = render(scene, *camera, optics, request);
    return std::count(picture.labels.begin(), picture.labels.end(), vehicle) > 0;
  };
  EXPECT_TRUE(sees());  // visible from inside
  request.hidden_vehicle = 0;
  EXPECT_FALSE(sees());
  request.hidden_vehicle.reset();
  request.world_from_vehicles[0].position_m.x() += 3;
  EXPECT_TRUE(sees());
}

/// The number of pixels of two pictures that differ by one step of their 8 bits. More than one step is a failure.
std::size_t steps_between(const Picture& a, const Picture& b) {
  std::size_t differing = 0;
  for (std::size_t k = 0; k < a.rgb.size(); ++k) {
    const int step = std::abs(a.rgb[k] - b.rgb[k]);
    EXPECT_LE(step, 1) << k;
    differing += step > 0 ? 1 : 0;
  }
  return differing;
}

/// How many rays of a picture test for a shadow, or how many do not.
double rays_of(const RayRecord& record, bool for_shadow) {
  std::ptrdiff_t rays = 0;
  for (const RayRecord::Packet& packet : record.packets) {
    if (((packet.kind & 1) != 0) == for_shadow) rays += std::ranges::count(packet.active, -1);
  }
  return static_cast<double>(rays);
}

// Light that hardly matters is not tested for shadows. Compared with testing all light, fewer rays are cast, and few
// pixels change, by one step.
TEST_F(Renderer, WeakLightNeedsNoShadowTest) {
  for (const auto& [eye, pitch] : {std::pair(Eigen::Vector3d(-4, 0, -4), 0.3), {Eigen::Vector3d(-1, 0, -4.5), 0.1}}) {
    PictureRequest request = from(eye, pitch);
    request.world_from_vehicles = {{eye + Eigen::Vector3d(2.5, -0.6, -0.3), Eigen::Quaterniond::Identity()}};
    RayRecord fewer, all;
    request.record = &fewer;
    const Picture picture = render(scene, *camera, optics, request);
    request.untested_share = 0;
    request.record = &all;
    const Picture exact = render(scene, *camera, optics, request);
    EXPECT_LT(rays_of(fewer, true), 0.97 * rays_of(all, true));
    EXPECT_LT(steps_between(picture, exact), picture.rgb.size() / 100);
  }
}

// A camera that moves imperceptibly computes the lamps' backscatter for every pixel. Looking upwards, the difference is
// the error of interpolation; towards the bed, the light from beyond it is subtracted by another quadrature.
TEST_F(Renderer, InterpolatedBackscatterOfLampsIsAccurate) {
  Lens lens = camera->lens();
  lens.width *= 4, lens.height *= 4, lens.fx *= 4, lens.fy *= 4, lens.cx *= 4, lens.cy *= 4;
  ImageSensor sensor;
  sensor.readout_s = 1e-9;
  for (const auto& [pitch_down_rad, tolerance] : {std::pair(-0.4, 1e-3), {0.4, 1e-2}}) {
    PictureRequest request = from({0, 0, -2}, pitch_down_rad);
    request.effects = Effects::none();
    for (const Effect effect : {Effect::kAttenuation, Effect::kBackscatter, Effect::kLamps, Effect::kShutter}) {
      request.effects.set(effect, true);
    }
    const Picture interpolated = render(scene, Camera("test", lens, {}), optics, request);
    request.velocity_camera << 1e-9, 0, 0, 0, 0, 0;
    const Picture exact = render(scene, Camera("test", lens, sensor), optics, request);
    std::size_t differing = 0;
    for (std::size_t k = 0; k < exact.radiance.size(); ++k) {
      const double expected = exact.radiance[k];
      ASSERT_NEAR(interpolated.radiance[k], expected, tolerance * expected) << k;
      differing += interpolated.radiance[k] != exact.radiance[k] ? 1 : 0;
    }
    EXPECT_GT(differing, exact.radiance.size() / 4);
    steps_between(interpolated, exact);
  }
}

TEST_F(Renderer, APictureWithoutGeometryHasTheSameColoursFromShorterRays) {
  PictureRequest request = from({-4, 0, -4}, 0.05);
  request.effects.set(Effect::kParticles, false);
  const Picture whole = render(scene, *camera, optics, request);
  RayRecord record;
  request.colours_only = true;
  request.record = &record;
  const Picture colours = render(scene, *camera, optics, request);
  EXPECT_EQ(whole.rgb, colours.rgb);
  EXPECT_EQ(whole.radiance, colours.radiance);
  EXPECT_TRUE(colours.depth_m.empty());
  const double c = optics.water.beam_attenuation().minCoeff();
  std::size_t shorter = 0;
  for (const RayRecord::Packet& packet : record.packets) shorter += packet.rows[7][0] < 20 / c ? 1 : 0;
  EXPECT_GT(shorter, record.packets.size() / 2);
}

TEST_F(Renderer, RefusesImpossiblePlacesAndParameters) {
  EXPECT_THROW(render(scene, *camera, optics, from({0, 0, -30}, 0)), InvalidValue);
  EXPECT_THROW(render(scene, *camera, optics, from({0, 0, NAN}, 0)), InvalidValue);
  EXPECT_THROW(jerlov_water("IV"), InvalidValue);
  EXPECT_THROW(material("gold"), InvalidValue);
  for (const int side : {0, -3, 8193, 2'000'000'000}) {
    Lens lens;
    lens.width = side;
    EXPECT_THROW(Camera("bad", lens, {}), InvalidValue) << side;
  }
  Lens folded;  // 85 % of its pixels are beyond the fold
  folded.k1 = -2;
  EXPECT_THROW(Camera("bad", folded, {}), InvalidValue);
}

TEST(CameraRows, AnExceptionInAnyRowOnAnyThreadReachesTheCaller) {
  constexpr int kRows = 40;
  for (const int threads : {1, 4}) {
    for (const int bad : {0, 17, kRows - 1}) {
      std::array<std::atomic<int>, kRows> done{};
      const auto work = [&](int row, int worker) {
        EXPECT_LT(worker, threads);
        if (row == bad) throw std::runtime_error("row " + std::to_string(row));
        ++done[static_cast<std::size_t>(row)];
      };
      try {
        for_rows(kRows, threads, work);
        FAIL() << "no exception from row " << bad << " on " << threads << " threads";
      } catch (const std::runtime_error& error) {
        EXPECT_EQ(error.what(), "row " + std::to_string(bad));
      }
      for (const auto& times : done) EXPECT_LE(times, 1);
    }
  }
}

}  // namespace
}  // namespace uwsim
