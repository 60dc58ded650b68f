#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "uwsim/camera/kernels/kernels_impl.h"
#include "uwsim/core/random.h"

/// The kernels' arithmetic is as accurate as their headers state. test_renderer.cpp checks that all builds produce the
/// same bits.
namespace uwsim::camera {
namespace {

constexpr double kTau = 2 * std::numbers::pi;

/// The largest error of `got` on a fine grid, relative or absolute.
template <typename Got, typename Expected>
double worst(double low, double high, bool relative, Got&& got, Expected&& expected) {
  double most = 0;
  for (int k = 0; k < 100'000; k += kLanes) {
    Float x;
    for (int lane = 0; lane < kLanes; ++lane) x[lane] = static_cast<float>(low + (high - low) * (k + lane) / 100'000);
    const Float y = got(x);
    for (int lane = 0; lane < kLanes; ++lane) {
      const double right = expected(static_cast<double>(x[lane]));
      most = std::max(most, std::abs(static_cast<double>(y[lane]) - right) / (relative ? std::abs(right) : 1));
    }
  }
  return most;
}

TEST(CameraKernels, FunctionsHaveTheStatedErrors) {
  const auto e = [](Float x) { return exponential(x); };
  for (const double most : {1.0, 10.0, 87.0}) {
    EXPECT_LT(worst(-most, most, true, e, [](double x) { return std::exp(x); }), 2e-7 + 1.2e-7 * most);
  }
  EXPECT_EQ(exponential(splat(0))[3], 1);
  EXPECT_EQ(exponential(splat(-88))[3], 0);
  EXPECT_LT(worst(
                1e-6, 3, false, [](Float x) { return logarithm(x); }, [](double x) { return std::log(x); }),
            1e-6);
  EXPECT_LT(worst(
                -1e4, 1e4, false, [](Float x) { return sine(x); }, [](double x) { return std::sin(x); }),
            1e-6);
  const auto sine_of = [](Float x) { return sine_cosine_of_turns(x).sine; };
  const auto cosine_of = [](Float x) { return sine_cosine_of_turns(x).cosine; };
  EXPECT_LT(worst(-20, 20, false, sine_of, [](double x) { return std::sin(kTau * x); }), 1e-6);
  EXPECT_LT(worst(-20, 20, false, cosine_of, [](double x) { return std::cos(kTau * x); }), 1e-6);
  const auto angle = [](Float x) { return angle_of(cosine(x) * 7, max(sine(x), Float{}) * 7); };
  EXPECT_LT(worst(1e-3, 3.1415, false, angle, [](double x) { return x; }), 3e-6);
}

TEST(CameraKernels, TransmissionHasTheStatedErrors) {
  const auto left = [](Float x) { return transmission(splat(0.25f), x); };
  for (const double most_m : {1.0, 30.0, 200.0}) {
    EXPECT_LT(worst(0, most_m, true, left, [](double x) { return std::exp(-0.25 * x); }),
              4e-6 + 1.2e-7 * 0.25 * most_m);
  }
  EXPECT_EQ(left(splat(0))[3], 1);
  EXPECT_LT(left(splat(1e30f))[3], 2e-38);
}

TEST(CameraKernels, TheTransferCurveIsThatOfSrgb) {
  const auto curve = [](double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; };
  EXPECT_LT(worst(
                0, 1, false, [](Float x) { return srgb(x); }, curve),
            4e-5);
  EXPECT_EQ(srgb(splat(-0.3f))[0], 0);
  EXPECT_NEAR(srgb(splat(7))[0], 1, 4e-5);
}

TEST(CameraKernels, NoiseDrawsTheSameWordsAsRandomStream) {
  const RandomStream random(0x1234'5678'9abc'def0, "rov/front/noise");
  const std::uint64_t tick = 0x0123'4567'89ab'cdef;
  Unsigned index;
  for (int k = 0; k < kLanes; ++k) index[k] = 4'294'967'000u + static_cast<std::uint32_t>(17 * k);
  const PhiloxWords words = philox(Wide(tick & 0xffffffffu), Wide(tick >> 32), widened<std::uint64_t>(index),
                                   Wide(std::uint64_t{random.stream()}), random.key());
  for (int k = 0; k < kLanes; ++k) {
    EXPECT_EQ(words.word[0][k], std::floor(random.uniform(tick, index[k]) * 0x1p32)) << k;
    const double turn = std::atan2(random.normals(tick, index[k])[1], random.normals(tick, index[k])[0]) / kTau;
    EXPECT_EQ(words.word[2][k], std::floor((turn < 0 ? turn + 1 : turn) * 0x1p32)) << k;
  }
}

/// Reference for the kernels' lamp_backscatter, for rays that hit nothing: the same quadrature in double, directly from
/// the formulas.
double lamp_backscatter(const View& view, const SpotLight& lamp, const std::array<double, 3>& direction, double from,
                        double to) {
  const auto dot = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const double nearest = dot(lamp.position, direction);
  const double apart = std::sqrt(dot(lamp.position, lamp.position) - nearest * nearest);
  const double first = std::atan((from - nearest) / apart), last = std::atan((to - nearest) / apart);
  double sum = 0;
  for (int k = 0; k < kBackscatterSamples; ++k) {
    const double t = nearest + apart * std::tan(first + (last - first) * (k + 0.5) / kBackscatterSamples);
    std::array<double, 3> at;
    for (std::size_t n = 0; n < 3; ++n) at[n] = direction[n] * t - lamp.position[n];
    const double distance = std::sqrt(dot(at, at)), turning = -dot(at, direction) / distance, g = kLampAsymmetry;
    const double edge = (dot(at, lamp.axis) / distance - lamp.cos_outer) / (lamp.cos_inner - lamp.cos_outer);
    const double soft = std::clamp(edge, 0.0, 1.0), spot = soft * soft * (3 - 2 * soft);
    const double particles = (1 - g * g) / (2 * kTau) / std::pow(1 + g * g - 2 * g * turning, 1.5);
    const double molecules = 3 / (8 * kTau) * (1 + turning * turning);
    sum += spot * (view.particle_b[1] * particles + view.molecule_b[1] * molecules) *
           std::exp(-view.c[1] * (t + distance)) * (last - first) / apart / kBackscatterSamples;
  }
  return sum * lamp.intensity[1];
}

TEST(CameraKernels, LampBackscatterEqualsTheQuadratureWithTrigonometry) {
  const SpotLight lamp{{0.1f, 0.4f, 0.2f}, {0.96f, 0, -0.28f}, {0.2f, 0.3f, 0.4f}, 0.64f, 0.9f};
  View view{};
  view.lamps = &lamp;
  view.lamp_count = view.has_attenuation = 1;
  for (int n = 0; n < 3; ++n) view.c[n] = 0.3f, view.particle_b[n] = 0.2f, view.molecule_b[n] = 0.003f;
  const auto block = std::make_unique<Block>();
  for (int k = 0; k < kBlockPixels; ++k) {
    const double across = 0.08 * (k % 4 - 1.5), up = 0.08 * (k / 4 - 1.5);
    const double size = std::sqrt(1 + across * across + up * up);
    block->direction.x.at[k] = static_cast<float>(1 / size);
    block->direction.y.at[k] = static_cast<float>(across / size);
    block->direction.z.at[k] = static_cast<float>(up / size);
    block->active.at[k] = block->in_water.at[k] = -1;
    block->reach.at[k] = 0.7f + 0.5f * static_cast<float>(k);
  }
  const Vector direction = load(block->direction);
  const Float reach = load(block->reach.at);
  const Vector light =
      lamp_backscatter<kBackscatterSamples>(view, 0, direction, Float{}, reach, load(block->active.at));
  for (int k = 0; k < kBlockPixels; ++k) {
    const std::array<double, 3> along = {direction.x[k], direction.y[k], direction.z[k]};
    Float from, to;
    cone_crossing(lamp, direction, Float{}, reach, from, to);
    const double expected = lamp_backscatter(view, lamp, along, from[k], to[k]);
    ASSERT_GT(expected, 1e-6) << k;
    EXPECT_NEAR(light.y[k], expected, 1e-5 * expected) << k;
  }
}

}  // namespace
}  // namespace uwsim::camera
