#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace uwsim {

/// What may be switched in a picture; all off is the plain scene under the open sky.
enum class Effect : std::uint8_t {
  kAttenuation,  ///< beam attenuation along the camera's path and the lamps'
  kBackscatter,  ///< the veil of daylight and of lamps
  kSunlight,     ///< daylight dimmed by depth (Kd) and bent at the surface
  kSurface,      ///< the water's surface: refraction, reflection
  kShadows,
  kLamps,
  kCaustics,
  kShafts,
  kParticles,
  kWobble,
  kDistortion,
  kVignetting,
  kExposure,  ///< automatic; a fixed one of 1 otherwise
  kNoise,
};

inline constexpr std::array<std::string_view, 14> kEffectNames = {
    "attenuation", "backscatter", "sunlight", "surface",    "shadows",    "lamps",    "caustics",
    "shafts",      "particles",   "wobble",   "distortion", "vignetting", "exposure", "noise"};

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
