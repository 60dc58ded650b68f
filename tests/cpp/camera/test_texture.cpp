#include "uwsim/camera/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "meshes.h"
#include "uwsim/camera/renderer.h"

namespace uwsim {
namespace {

constexpr double kPi = std::numbers::pi;
const Eigen::Vector3f kNothing = Eigen::Vector3f::Zero();

/// A square of 1 m in the plane z = 0, whose x and y are the image's s and t.
TriangleMesh square() { return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}}; }
std::vector<float> corners_of_square() { return {0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1}; }

/// Upright stripes, black and white, one pixel wide.
TextureImage stripes(int size) {
  TextureImage image{size, size, TextureImage::kColourBands, {}, corners_of_square(), {}};
  for (int k = 0; k < size * size; ++k) image.pixels.insert(image.pixels.end(), 3, k % size % 2 == 0 ? 0 : 255);
  return image;
}

// The mean of light, and not of sRGB's numbers; 0.5 is not a number of sRGB, whose nearest two are 0.4969 and 0.5028.
TEST(Texture, AFootprintShowsItsMeanAndASmallOneTheImage) {
  for (const int size : {64, 100, 37}) {
    const Texture texture(stripes(size), square());
    const float pixel_m = 1.0f / static_cast<float>(size), white = std::floor(0.5f * static_cast<float>(size));
    const float black = texture.at(0, 2.5f * pixel_m, 0, kNothing, kNothing).albedo.x();
    EXPECT_NEAR(black, 0, 1e-3);
    EXPECT_NEAR(texture.at(0, 3.5f * pixel_m, 0, kNothing, kNothing).albedo.x(), 1, 1e-3);
    for (const float far : {4.0f, 13.0f, 30.0f}) {
      const Eigen::Vector3f across(far * pixel_m, 0, 0), along(0, far * pixel_m, 0);
      EXPECT_NEAR(texture.at(0, 0.3f, 0.3f, across, along).albedo.y(), white / static_cast<float>(size), 0.02);
    }
  }
}

// Seen at a grazing angle along the stripes, they stay; seen across them, they are grey.
TEST(Texture, ALongFootprintBlursNoOtherWay) {
  const Texture texture(stripes(64), square());
  const float pixel_m = 1.0f / 64;
  const Eigen::Vector3f wide(pixel_m, 0, 0), high(0, pixel_m, 0);
  const auto at = [&](float x, const Eigen::Vector3f& across, const Eigen::Vector3f& along) {
    return texture.at(0, x - 0.4f, 0.4f, across, along).albedo.x();  // in the first triangle, at (x, 0.4)
  };
  const float black = 40.5f * pixel_m, white = 41.5f * pixel_m;
  EXPECT_NEAR(std::abs(at(black, wide, 7 * high) - at(white, wide, 7 * high)), 1, 0.01);
  EXPECT_NEAR(at(black, high, 8 * wide), 0.5, 0.1);
  EXPECT_NEAR(at(white, high, 8 * wide), 0.5, 0.1);
}

/// A grey square of 4 x 4 texels seen from above, in red light of daylight, over 64 x 64 pixels.
std::vector<float> seen_from(double above_m, bool in_detail) {
  World world;
  TriangleMesh slab = square();
  world.add_solid("slab", slab);
  CameraScene scene(world, std::make_shared<RayScene>(world), 7);
  TextureImage grey{4, 4, TextureImage::kColourBands, std::vector<std::uint8_t>(48, 128), corners_of_square(), {}};
  scene.set_appearance(kTerrain + 1, {material("rock"), SurfaceClass::kStructure, grey});
  if (in_detail) scene.show_detail();
  PictureRequest request;
  request.effects = Effects::none();
  request.keep_radiance = true;
  request.world_from_camera.position_m = {0.5, 0.5, above_m};
  request.world_from_camera.orientation = Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitY());
  Lens lens;
  lens.width = lens.height = 64, lens.fx = lens.fy = 100, lens.cx = lens.cy = 31.5;
  Optics optics;
  optics.water = jerlov_water("III");
  const Picture picture = render(scene, Camera("c", lens, {}), optics, request);
  std::vector<float> red;
  for (std::size_t k = 0; k < picture.radiance.size(); k += 3) red.push_back(picture.radiance[k]);
  return red;
}

// Between its texels an image has the grain of its material, around the image's own colour; never from afar.
TEST(Texture, ATexelHasTheGrainOfItsMaterial) {
  const auto mean_and_cv = [](const std::vector<float>& light) {
    double sum = 0, square_sum = 0;
    for (const float x : light) sum += x, square_sum += x * x;
    const double mean = sum / static_cast<double>(light.size());
    return std::pair(mean,
                     std::sqrt(std::max(square_sum / static_cast<double>(light.size()) / (mean * mean) - 1, 0.0)));
  };
  const auto [mean, cv] = mean_and_cv(seen_from(0.7, true));
  const auto [plain_mean, plain_cv] = mean_and_cv(seen_from(0.7, false));
  EXPECT_LT(plain_cv, 0.05);
  EXPECT_GT(cv, 0.1);
  EXPECT_NEAR(mean, plain_mean, 0.1 * plain_mean);
  EXPECT_EQ(seen_from(90, true), seen_from(90, false));
}

TEST(Texture, NormalsThatDifferWithinAFootprintMakeASurfaceRough) {
  TextureImage image{64, 64, TextureImage::kAllBands, {}, corners_of_square(), {}};
  const double slope = 0.3;  // alternately to either side
  for (int k = 0; k < 64 * 64; ++k) {
    const double x = (k % 2 == 0 ? 1 : -1) * std::sin(slope), z = std::cos(slope);
    const auto byte = [](double part) { return static_cast<std::uint8_t>(std::lround(127.5 * (part + 1))); };
    for (const std::uint8_t value : {byte(0), byte(0), byte(0), byte(x), byte(0), byte(z), byte(-0.8), byte(-1)}) {
      image.pixels.push_back(value);
    }
  }
  const Texture texture(image, square());
  const float pixel_m = 1.0f / 64;
  const TextureSample near = texture.at(0, 0.5f * pixel_m, 0, kNothing, kNothing);
  const TextureSample far = texture.at(0, 0.3f, 0.3f, {16 * pixel_m, 0, 0}, {0, 16 * pixel_m, 0});
  EXPECT_NEAR(std::abs(near.normal_mesh.x()), std::sin(slope), 0.01);
  EXPECT_NEAR(far.normal_mesh.z(), 1, 1e-3);
  EXPECT_NEAR(near.roughness, 0.1, 0.03);  // although 8 bits make no unit normals
  // All slopes lie along one axis, with a variance of slope^2, so that each axis has half of it.
  EXPECT_NEAR(std::pow(far.roughness, 4), std::pow(0.1, 4) + slope * slope, 0.1 * slope * slope);
}

// The radiance of a surface beside that of a matt white one is pi times its reflectance (GGX, closed form).
TEST(Texture, AMetalReflectsALampAsGgxSays) {
  const Eigen::Vector3d lamp_m(0, 0.7, 0.4), at_m(2, 0, 0);
  const auto of_tilt = [&](int roughness, int metalness, std::uint8_t level) {
    World world;
    TriangleMesh plate = testing::box(0.2, 40, 40);
    for (Eigen::Vector3d& vertex : plate.vertices_m) vertex += Eigen::Vector3d(2.1, 0, 0);
    world.add_solid("plate", plate);
    TextureImage image{1, 1, TextureImage::kAllBands, {255, 255, 255, level, level, 255, 0, 0}, {}, {}};
    image.pixels[6] = static_cast<std::uint8_t>(roughness), image.pixels[7] = static_cast<std::uint8_t>(metalness);
    for (std::size_t k = 0; k < plate.triangles.size(); ++k) {
      for (const float part : {0.f, 0.f, 1.f, 0.f, 0.f, 1.f}) image.corners.push_back(part);
    }
    if (roughness < 0) {  // matt
      image.bands = TextureImage::kColourBands;
      image.pixels.resize(3);
    }
    CameraScene scene(world, std::make_shared<RayScene>(world), 7);
    scene.set_appearance(kTerrain + 1, {material("plain"), SurfaceClass::kStructure, image});
    Lens lens;
    lens.width = lens.height = 5, lens.fx = lens.fy = 400, lens.cx = lens.cy = 2;
    PictureRequest request;
    request.effects = Effects::none();
    request.keep_radiance = true;
    const Camera camera("test", lens, ImageSensor{});
    Optics optics;
    optics.water = jerlov_water("I");
    const Picture dark = render(scene, camera, optics, request);
    SpotLamp lamp;
    lamp.world_from_lamp.position_m = lamp_m;
    lamp.half_angle_rad = 1.2, lamp.soft_share = 0.1;
    request.lamps = {lamp};
    request.effects.set(Effect::kLamps, true);
    const Picture lit = render(scene, camera, optics, request);
    const std::size_t middle = 3 * (2 * 5 + 2);
    EXPECT_GT(lit.radiance[middle], dark.radiance[middle]);
    return double{lit.radiance[middle]} - double{dark.radiance[middle]};
  };
  // In 8 bits, no number is 0: a flat surface is between two.
  const auto radiance = [&](int roughness, int metalness) {
    return 0.5 * (of_tilt(roughness, metalness, 127) + of_tilt(roughness, metalness, 128));
  };
  const double matt = radiance(-1, 0);
  const Eigen::Vector3d normal(-1, 0, 0), eye(-1, 0, 0), light = (lamp_m - at_m).normalized();
  const Eigen::Vector3d half = (eye + light).normalized();
  const double nh = normal.dot(half), nl = normal.dot(light);
  for (const int roughness : {77, 128, 204, 255}) {
    const double a = std::pow(roughness / 255.0, 2);
    const double tangent = std::tan(std::acos(nh));  // Walter et al. 2007, eq. 33 and 34
    const double facets = a * a / (kPi * std::pow(nh, 4) * std::pow(a * a + tangent * tangent, 2));
    const auto lambda = [&](double c) { return (std::sqrt(1 + a * a * (1 / (c * c) - 1)) - 1) / 2; };  // Heitz 2014
    const double shadowed = 1 / (1 + lambda(nl) + lambda(1));
    EXPECT_NEAR(radiance(roughness, 255) / matt, kPi * facets * shadowed / (4 * nl), 0.01) << roughness;
    const double dielectric = radiance(roughness, 0) / matt;
    EXPECT_NEAR(dielectric, 0.96 + 0.04 * kPi * facets * shadowed / (4 * nl), 0.02) << roughness;
  }
}

}  // namespace
}  // namespace uwsim
