#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/camera/plane.h"

namespace uwsim {

/// What a camera gives, all of one pass, rows from the top: width x height values, times 3 where noted.
/// Depth, normals, labels and classes are those of the first solid along each pixel's ray, as lens and wobble send it,
/// with water and its surface clear: they hold what the ray itself meets, while colour follows the light.
struct Picture {
  int width = 0, height = 0;
  Plane<std::uint8_t> rgb;      ///< x 3, sRGB; empty where geometry alone was asked for
  std::vector<float> radiance;  ///< x 3, before exposure, where asked for: irradiance as in daylight.h, a sr
  Plane<float> depth_m;         ///< along the optical axis (REP 118); infinity for nothing
  Plane<float> normals_world;   ///< x 3, unit, of the winding side; 0 for nothing
  Plane<std::uint16_t> labels;  ///< see CameraScene::label_names
  Plane<std::uint8_t> classes;  ///< see SurfaceClass
  double gain = 0;              ///< exposure that made rgb of radiance
};

/// Rays cast for a picture, and the processor seconds of each stage, all threads together, where they were measured.
struct PictureCost {
  std::uint64_t primary_rays = 0, onward_rays = 0, sun_rays = 0, lamp_rays = 0, shaft_rays = 0;
  std::array<double, 11> seconds{};  ///< by Stage

  void add(const PictureCost& other);
};

enum Stage {
  kPrepare,
  kPrimary,
  kSun,
  kLampShadows,
  kShaftRays,
  kDepth,
  kWater,
  kSurfaces,
  kLampLight,
  kSpecks,
  kFilm
};

inline constexpr std::array<const char*, 11> kStageNames = {"ripples and waves",
                                                            "primary and onward rays",
                                                            "sun's shadow rays",
                                                            "lamps' shadow rays",
                                                            "shafts' rays",
                                                            "exact depth, output",
                                                            "water",
                                                            "surfaces",
                                                            "light of lamps",
                                                            "particles",
                                                            "film"};

}  // namespace uwsim
