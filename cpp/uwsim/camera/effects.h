#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace uwsim {

/// The effects in a picture, each of which can be switched off. With all effects off, the picture shows the plain, dry
/// scene under the open sky.
enum class Effect : std::uint8_t {
  kAttenuation,  ///< beam attenuation between scene and camera, and between lamps and scene
  kBackscatter,  ///< light from sky, sun and lamps that water scatters into the camera (veiling light)
  kSunlight,     ///< daylight attenuated with depth (Kd) and refracted at the surface
  kSurface,      ///< refraction and reflection at the water's surface, as seen by the camera
  kShadows,
  kLamps,
  kCaustics,   ///< sunlight on surfaces, focused by ripples
  kShafts,     ///< sunlight in the water, focused by ripples and shadowed
  kParticles,  ///< individual particles near the camera
  kWobble,     ///< rays bent by turbulence
  kDistortion,
  kVignetting,
  kExposure,  ///< automatic exposure; if off, fixed at 1
  kNoise,     ///< photon and read noise
  kShutter,   ///< motion during exposure and readout
};

inline constexpr std::array<std::string_view, 15> kEffectNames = {
    "attenuation", "backscatter", "sunlight",   "surface",    "shadows",  "lamps", "caustics", "shafts",
    "particles",   "wobble",      "distortion", "vignetting", "exposure", "noise", "shutter"};

class Effects {
 public:
  static Effects all() { return Effects((1u << kEffectNames.size()) - 1); }
  static Effects none() { return Effects(0); }
  bool has(Effect effect) const { return bits_ >> static_cast<unsigned>(effect) & 1u; }
  void set(Effect effect, bool on) {
    const std::uint32_t bit = 1u << static_cast<unsigned>(effect);
    bits_ = on ? bits_ | bit : bits_ & ~bit;
  }

 private:
  explicit Effects(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_;
};

}  // namespace uwsim
