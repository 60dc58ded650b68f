#include "uwsim/camera/development.h"

#include <algorithm>

#include "uwsim/core/random.h"
#include "uwsim/core/stream_name.h"

namespace uwsim {
namespace {

constexpr double kMiddleGrey = 0.18;
// Gain of the fixed exposure, at which white in full sun (radiance 1 / pi) is rendered as 0.8.
constexpr double kSunnyGain = 0.8 * 3.14159265358979;
constexpr double kLeastGain = 0.25 * kSunnyGain, kMostGain = 2e4 * kSunnyGain;
// Gain of the longest shutter time; beyond it, the signal is amplified together with its noise.
constexpr double kLongestShutterGain = 30 * kSunnyGain;

}  // namespace

double exposure_gain(const ImageSensor& sensor, const Effects& effects, const std::vector<double>& root_luminance,
                     std::size_t pixels) {
  if (!effects.has(Effect::kExposure)) return kSunnyGain * sensor.exposure;
  double sum = 0;
  for (const double part : root_luminance) sum += part;
  const double root = sum / static_cast<double>(pixels);
  return std::clamp(sensor.exposure * kMiddleGrey / std::max(root * root, 1e-12), kLeastGain, kMostGain);
}

camera::Development development_of(const Camera& camera, const PictureRequest& request, std::uint64_t seed,
                                   double gain) {
  const ImageSensor& sensor = camera.sensor();
  const RandomStream random(seed, stream_name(camera.name(), "noise"));
  camera::Development development{};
  development.gain = static_cast<float>(gain);
  development.iso = static_cast<float>(std::max(1.0, gain / kLongestShutterGain));
  development.vignetting = request.effects.has(Effect::kVignetting) ? static_cast<float>(sensor.vignetting) : 0;
  development.full_well = static_cast<float>(sensor.full_well);
  development.read_noise = static_cast<float>(sensor.read_noise);
  development.has_noise = request.effects.has(Effect::kNoise);
  development.key = random.key();
  development.stream = random.stream();
  development.tick = request.tick;
  return development;
}

}  // namespace uwsim
