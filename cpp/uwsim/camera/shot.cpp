#include "uwsim/camera/shot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kTextureRepeat_m = 256;  // a whole number of ripple tiles: 40 of 6.4 m
// Share of scattering that takes light out of the sun's own beam; the rest goes forward within some 15 degrees and
// still casts shadows. Assumed, by the order of Petzold's 1972 measurements.
constexpr double kScatteredAway = 0.2;
constexpr double kSunlight_lx = 1e5;  // what is 1 in daylight.h

void put(float (&to)[3], const Eigen::Vector3d& from) {
  for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(from(k));
}
void put(float (&to)[3], const Bands& from) { put(to, Eigen::Vector3d(from.matrix())); }

float repeated(double x) { return static_cast<float>(x - kTextureRepeat_m * std::floor(x / kTextureRepeat_m)); }

}  // namespace

PreparedShot::PreparedShot(const CameraScene& scene, const Camera& camera, const Optics& optics,
                           const Exposure& exposure)
    : anchor_world_m(exposure.world_from_camera.position_m) {
  const Effects& on = exposure.effects;
  in_water_world = on.has(Effect::kAttenuation) || on.has(Effect::kBackscatter) || on.has(Effect::kSunlight) ||
                   on.has(Effect::kSurface);
  aim(camera, exposure);
  lay_terrain(scene.world());
  shot.camera_z = static_cast<float>(anchor_world_m.z());
  shot.surface_z = static_cast<float>(
      scene.world().water.surface_height_at(anchor_world_m.x(), anchor_world_m.y(), exposure.time_s));
  shot.texture_x = repeated(anchor_world_m.x());
  shot.texture_y = repeated(anchor_world_m.y());
  shot.camera_wet = in_water_world && shot.camera_z < shot.surface_z;
  shot.has_surface = on.has(Effect::kSurface);
  if (in_water_world && !exposure.geometry_only) {
    shot.waves = waves_.emplace(scene.world().water, anchor_world_m, exposure.time_s, exposure.threads).window();
  }
  fill_water(optics, on);
  const bool rippled =
      !exposure.geometry_only && optics.wind_m_s > 0 && (shot.has_surface || on.has(Effect::kCaustics));
  if (rippled) {
    ripples_ = scene.ripples(optics.wind_m_s, optics.wind_towards_rad, exposure.time_s, optics.water.refractive_index,
                             exposure.threads);
    shot.slopes = ripples_->slopes.data();
    shot.caustics = ripples_->caustics.data();
  }
  shot.has_caustics = rippled && on.has(Effect::kCaustics) && shot.has_depth_light && shot.beam_level[1] > 0;
  light_lamps(exposure);
  shot.materials = scene.materials().data();
  shot.terrain_rock = 1;
  shot.terrain_dry = 2;
}

void PreparedShot::aim(const Camera& camera, const Exposure& exposure) {
  const Lens& lens = camera.lens();
  const RayTable& rays = camera.rays(exposure.effects.has(Effect::kDistortion));
  const Eigen::Matrix3d turn = exposure.world_from_camera.rotation();
  shot.width = lens.width;
  shot.height = lens.height;
  shot.ray_x = rays.x.data();
  shot.ray_y = rays.y.data();
  shot.block_ray_x = rays.block_x.data();
  shot.block_ray_y = rays.block_y.data();
  put(shot.right, Eigen::Vector3d(-turn.col(1)));
  put(shot.down, Eigen::Vector3d(-turn.col(2)));
  put(shot.ahead, Eigen::Vector3d(turn.col(0)));
  shot.pixel_rad = static_cast<float>(1 / lens.fx);
  const bool wobbles = exposure.effects.has(Effect::kWobble);
  shot.wobble_rad = wobbles ? static_cast<float>(camera.sensor().wobble_rad) : 0;
  shot.wobble_phase = static_cast<float>(std::fmod(exposure.time_s, 20 * std::numbers::pi));
}

void PreparedShot::lay_terrain(const World& world) {
  shot.terrain_label = kTerrain;
  shot.anchor_z = anchor_world_m.z();
  if (const auto& terrain = world.terrain()) {
    shot.terrain_x = terrain->origin_m().x() - anchor_world_m.x();
    shot.terrain_y = terrain->origin_m().y() - anchor_world_m.y();
    shot.terrain_spacing = terrain->spacing_m();
    shot.heights = terrain->heights_m().data();
    shot.terrain_nx = static_cast<int>(terrain->nx());
  }
}

void PreparedShot::fill_water(const Optics& optics, const Effects& on) {
  const WaterOptics& water = optics.water;
  const Daylight above = daylight(optics.sun);
  const DaylightBelow below = daylight_below(above, water.refractive_index);
  const Bands molecules = molecular_scattering().min(water.scattering);
  const bool wet_light = on.has(Effect::kSunlight);
  shot.has_depth_light = wet_light;
  shot.has_attenuation = on.has(Effect::kAttenuation);
  shot.has_backscatter = on.has(Effect::kBackscatter);
  shot.index = static_cast<float>(water.refractive_index);
  shot.bend = static_cast<float>(1 - 1 / water.refractive_index);
  put(shot.c, water.beam_attenuation());
  put(shot.kd, wet_light ? water.diffuse_attenuation : Bands::Zero().eval());
  put(shot.kb, wet_light ? Bands(water.diffuse_attenuation + kScatteredAway * water.scattering / below.to_sun_world.z())
                         : Bands::Zero().eval());
  put(shot.particle_b, Bands(water.scattering - molecules));
  put(shot.molecule_b, molecules);
  put(shot.upwelling, upwelling_share(water));
  put(shot.beam_level, below.beam_level);
  put(shot.total_level, Bands(below.beam_level + below.sky_level));
  put(shot.to_sun_wet, below.to_sun_world);
  put(shot.beam, above.beam);
  put(shot.sky, above.sky);
  put(shot.to_sun, above.to_sun_world);
}

void PreparedShot::light_lamps(const Exposure& exposure) {
  if (!exposure.effects.has(Effect::kLamps)) return;
  for (const Lamp& lamp : exposure.lamps) {
    lamp.check();
    camera::LampLight light{};
    const Pose& pose = lamp.world_from_lamp;
    put(light.position, Eigen::Vector3d(pose.position_m - anchor_world_m));
    put(light.axis, pose.direction(Eigen::Vector3d::UnitX()));
    const double inner = lamp.half_angle_rad * (1 - lamp.soft_share);
    light.cos_outer = static_cast<float>(std::cos(lamp.half_angle_rad));
    light.cos_inner = static_cast<float>(std::cos(inner));
    // Smoothstep over the cosine: as much light as an even cone out to the middle of the soft edge's cosines.
    const double steradians = 2 * std::numbers::pi * (1 - 0.5 * (light.cos_outer + light.cos_inner));
    put(light.intensity, Bands(lamp.colour * (lamp.flux_lm / steradians / kSunlight_lx)));
    lamps_.push_back(light);
  }
  shot.lamps = lamps_.data();
  shot.lamp_count = static_cast<int>(lamps_.size());
}

}  // namespace uwsim
