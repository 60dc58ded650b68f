#include "uwsim/camera/prepared_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/particle_scattering.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kSunlight_lx = 1e5;  // illuminance that corresponds to irradiance 1 in daylight.h

void assign(float (&to)[3], const Eigen::Vector3d& from) {
  for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(from(k));
}
void assign(float (&to)[3], const Bands& from) { assign(to, Eigen::Vector3d(from.matrix())); }

Bands particle_scattering(const WaterOptics& water) {
  return water.scattering - molecular_scattering().min(water.scattering);
}

/// The scattering that takes light out of the sun's beam; the rest still casts shadows.
Bands scattering_out_of_beam(const WaterOptics& water) {
  return water.scattering - scattered_within(kBeamEdge_rad) * particle_scattering(water);
}

/// At least the upward part of every ray's direction in the picture, and at least 0. The highest ray is at the edge of
/// the picture, unless the zenith is inside.
float highest_ray(const camera::View& view) {
  float highest = 0, widest = 1;
  const auto look = [&](int column, int row) {
    const int at = row * view.width + column;
    const float x = view.ray_x[at], y = view.ray_y[at], length = std::sqrt(x * x + y * y + 1);
    highest = std::max(highest, (view.right[2] * x + view.down[2] * y + view.ahead[2]) / length);
    widest = std::max(widest, length);
  };
  for (int column = 0; column < view.width; ++column) look(column, 0), look(column, view.height - 1);
  for (int row = 0; row < view.height; ++row) look(0, row), look(view.width - 1, row);
  if (1.01f * view.ahead[2] * widest > 1) return 1;
  return std::min(1.0f, highest + view.pixel_rad + 3 * view.wobble_rad);  // at most 2.2 wobble_rad along both axes
}

/// One coordinate of the camera in the patterns of materials, which begin one repeat before the world's origin.
struct PatternPlace {
  float texture_m;            // in the frame of textures
  double first_m;             // that frame's origin
  std::uint32_t whole, cell;  // the same, modulo 2^32, and its cell of large patches
  float patch;                // its place in that cell

  explicit PatternPlace(double x) {
    const double repeats = std::floor(x / camera::kTextureRepeat_m);
    texture_m = static_cast<float>(x - camera::kTextureRepeat_m * repeats);
    first_m = camera::kTextureRepeat_m * (repeats + 1);
    const double patches = first_m * static_cast<double>(camera::kPatch_per_m), cells = std::floor(patches);
    const auto modulo = [](double n) { return static_cast<std::uint32_t>(static_cast<std::int64_t>(n)); };
    whole = modulo(first_m), cell = modulo(cells);
    patch = static_cast<float>(patches - cells);
  }
};

}  // namespace

FocusedSun focused_sun(const Optics& optics) {
  return {optics.water.refractive_index, daylight(optics.sun).to_sun_world.head<2>(),
          particle_scattering(optics.water)(1)};
}

PreparedView::PreparedView(const CameraScene& scene, const Camera& camera, const Optics& optics,
                           const PictureRequest& request)
    : anchor_world_m(request.world_from_camera.position_m) {
  const Effects& on = request.effects;
  const bool has_water = on.has(Effect::kAttenuation) || on.has(Effect::kBackscatter) || on.has(Effect::kSunlight) ||
                         on.has(Effect::kSurface);
  set_terrain(scene.world());
  view.camera_z = static_cast<float>(anchor_world_m.z());
  view.surface_z =
      static_cast<float>(scene.world().water.surface_height_at(anchor_world_m.x(), anchor_world_m.y(), request.time_s));
  set_wobble(camera, optics, request);
  set_detail(scene, optics);
  set_patterns();
  view.camera_in_water = has_water && view.camera_z < view.surface_z;
  set_rays(camera, request);
  set_shutter(camera, request);
  view.has_surface = on.has(Effect::kSurface);
  if (has_water && !request.geometry_only) {
    view.waves = waves_.emplace(scene.world().water, anchor_world_m, request.time_s, request.threads).nodes();
  }
  set_light(optics, request);
  set_swell(scene.world().water, focused_sun(optics));
  const bool has_ripples =
      !request.geometry_only && optics.wind_m_s > 0 && (view.has_surface || on.has(Effect::kCaustics));
  if (has_ripples) {
    ripples_ = scene.ripples(optics.wind_m_s, optics.wind_towards_rad, optics.fetch_m, request.time_s,
                             focused_sun(optics), first_caustic_level(request), request.threads);
    view.slopes = ripples_->slopes.data();
    view.caustics = ripples_->caustics.data();
  }
  view.has_caustics = has_ripples && on.has(Effect::kCaustics) && view.has_sunlight && view.beam_level[1] > 0;
  set_lamps(request);
  view.materials = scene.materials().data();
  view.has_gloss = scene.has_gloss() ? 1 : 0;
  view.steep_material = 1;
  view.land_material = 2;
}

/// Ripples of sand lie across the scene's direction, or else across the waves that made them: the highest of the
/// world's waves, or those of the wind. Scenes without detail and direction keep one direction everywhere.
void PreparedView::set_detail(const CameraScene& scene, const Optics& optics) {
  view.ripple_x = camera::kRippleX, view.ripple_y = camera::kRippleY;
  view.detail_end = scene.has_detail() ? scene.materials_of_fixed() : 0;
  if (view.detail_end == 0 && !scene.ripples_rad()) return;
  double towards_rad = optics.wind_towards_rad, highest_m = 0;
  if (const auto& waves = scene.world().water.waves) {
    for (const WaveComponent& wave : waves->components()) {
      if (wave.amplitude_m > highest_m) highest_m = wave.amplitude_m, towards_rad = wave.heading_rad;
    }
  }
  towards_rad = scene.ripples_rad().value_or(towards_rad);
  view.ripple_x = static_cast<float>(std::cos(towards_rad)), view.ripple_y = static_cast<float>(std::sin(towards_rad));
}

/// Places the patterns of materials in the world, so that they do not depend on where the camera is.
void PreparedView::set_patterns() {
  const PatternPlace x(anchor_world_m.x()), y(anchor_world_m.y());
  view.texture_x = x.texture_m, view.texture_y = y.texture_m;
  view.texture_first_x = x.whole, view.texture_first_y = y.whole;
  view.patch_cell_x = x.cell, view.patch_cell_y = y.cell;
  view.patch_x = x.patch, view.patch_y = y.patch;
  const double first_m =
      static_cast<double>(view.ripple_x) * x.first_m + static_cast<double>(view.ripple_y) * y.first_m;
  view.ripple_first_m = static_cast<float>(first_m);
}

void PreparedView::set_rays(const Camera& camera, const PictureRequest& request) {
  const Lens& lens = camera.lens();
  const bool distort = request.effects.has(Effect::kDistortion);
  const RayTable &rays = camera.rays(distort, view.camera_in_water), &inside = camera.rays(distort, false);
  const Eigen::Matrix3d turn = request.world_from_camera.rotation();
  view.width = lens.width;
  view.height = lens.height;
  view.ray_x = rays.x.data();
  view.ray_y = rays.y.data();
  view.block_ray_x = rays.block_x.data();
  view.block_ray_y = rays.block_y.data();
  view.lens_x = inside.x.data();
  view.lens_y = inside.y.data();
  view.has_offsets = !rays.offset_x_m.empty();
  view.offset_x = rays.offset_x_m.data();
  view.offset_y = rays.offset_y_m.data();
  view.block_offset_x = rays.block_offset_x_m.data();
  view.block_offset_y = rays.block_offset_y_m.data();
  assign(view.right, Eigen::Vector3d(-turn.col(1)));
  assign(view.down, Eigen::Vector3d(-turn.col(2)));
  assign(view.ahead, Eigen::Vector3d(turn.col(0)));
  view.pixel_rad = static_cast<float>(1 / (view.has_offsets ? kWaterIndex * lens.fx : lens.fx));
}

/// Rays that nothing bends rise at most as far as the highest of them is seen, so that the points in view are at least
/// as deep as the result, and none of them reaches the surface.
int PreparedView::first_caustic_level(const PictureRequest& request) const {
  if (!view.camera_in_water || view.has_offsets || view.moves || view.waves.values != nullptr) return 0;
  const float up = highest_ray(view);
  camera::Block block{};
  camera::BlockFloats sight_m;
  std::fill_n(block.in_water.at, camera::kBlockPixels, -1);
  std::fill_n(block.direction.z.at, camera::kBlockPixels, up);
  const camera::Kernels& kernels = request.kernels != nullptr ? *request.kernels : camera::kernels();
  kernels.limit_to_sight(view, block, sight_m);
  const float depth_m = view.surface_z - view.camera_z - up * sight_m.at[0];
  const float level = std::floor(std::log2(depth_m / (view.to_sun_in_water[2] * camera::kFirstCausticLevel_m)));
  return depth_m > 0 ? static_cast<int>(std::clamp(level, 0.0f, camera::kCausticLevels - 2.0f)) : 0;
}

/// During exposure and readout, the camera moves at constant velocity, and everything else is at rest.
void PreparedView::set_shutter(const Camera& camera, const PictureRequest& request) {
  const ImageSensor& sensor = camera.sensor();
  const bool takes_time = sensor.shutter_s > 0 || sensor.readout_s > 0;
  view.moves = takes_time && request.effects.has(Effect::kShutter) && !request.velocity_camera.isZero(0);
  if (!view.moves) return;
  const Eigen::Matrix3d turn = request.world_from_camera.rotation();
  const Eigen::Vector3d spin = turn * request.velocity_camera.tail<3>();
  assign(view.velocity, Eigen::Vector3d(turn * request.velocity_camera.head<3>()));
  assign(view.spin_axis, Eigen::Vector3d(spin.norm() > 0 ? spin.normalized() : Eigen::Vector3d::UnitZ()));
  view.spin_turns_per_s = static_cast<float>(spin.norm() / (2 * std::numbers::pi));
  view.row_s = static_cast<float>(sensor.readout_s / view.height);
}

/// Rays bend only in water; rays from above bend at the surface, due to waves and ripples.
void PreparedView::set_wobble(const Camera& camera, const Optics& optics, const PictureRequest& request) {
  const bool bends = request.effects.has(Effect::kWobble) && anchor_world_m.z() < view.surface_z;
  // The waves of kernels/primary_rays.h have a standard deviation of sqrt(5 / 8) along each axis.
  const double wobble_rad =
      camera.sensor().wobble_rad.value_or(turbulence_bend_rad(optics.turbulence_k) / std::sqrt(0.625));
  view.wobble_rad = bends ? static_cast<float>(wobble_rad) : 0;
  view.wobble_phase = static_cast<float>(std::fmod(request.time_s, 20 * std::numbers::pi));
}

void PreparedView::set_terrain(const World& world) {
  view.terrain_label = kTerrain;
  view.anchor_z = anchor_world_m.z();
  if (const auto& terrain = world.terrain()) {
    view.terrain_x = terrain->origin_m().x() - anchor_world_m.x();
    view.terrain_y = terrain->origin_m().y() - anchor_world_m.y();
    view.terrain_spacing = terrain->spacing_m();
    view.heights = terrain->heights_m().data();
    view.terrain_nx = static_cast<int>(terrain->nx());
    view.terrain_ny = static_cast<int>(terrain->ny());
  }
}

void PreparedView::set_light(const Optics& optics, const PictureRequest& request) {
  const Effects& on = request.effects;
  const WaterOptics& water = optics.water;
  const Daylight above = daylight(optics.sun);
  const DaylightBelow below = daylight_below(above, water.refractive_index);
  const Bands particles = particle_scattering(water);
  const bool sunlight = on.has(Effect::kSunlight);
  view.has_sunlight = sunlight;
  view.has_attenuation = on.has(Effect::kAttenuation);
  view.has_backscatter = on.has(Effect::kBackscatter);
  view.untested_share = request.untested_share;
  view.refractive_index = static_cast<float>(water.refractive_index);
  assign(view.c, water.beam_attenuation());
  assign(view.kd, sunlight ? water.diffuse_attenuation : Bands::Zero().eval());
  assign(view.kb, sunlight ? Bands(water.diffuse_attenuation + scattering_out_of_beam(water) / below.to_sun_world.z())
                           : Bands::Zero().eval());
  assign(view.particle_b, particles);
  assign(view.molecule_b, Bands(water.scattering - particles));
  assign(view.upwelling, upwelling_share(water));
  assign(view.beam_level, below.beam_level);
  assign(view.total_level, Bands(below.beam_level + below.sky_level));
  assign(view.to_sun_in_water, below.to_sun_world);
  assign(view.beam, above.beam);
  assign(view.sky, above.sky);
  assign(view.to_sun, above.to_sun_world);
}

/// The share of the waves' focusing that is left at the paths of the caustics' levels. Beyond their focus, at a path of
/// 1 / (bend curvature), the sheets of light from several waves overlap and even out; the water spreads them
/// (`pattern_left` in caustics.h, at the wave number that has most of the curvature).
void PreparedView::set_swell(const Water& water, const FocusedSun& sun) {
  const Eigen::Vector2d slant = sun.slant();
  view.bend = static_cast<float>(sun.bend());
  view.slant[0] = static_cast<float>(slant.x()), view.slant[1] = static_cast<float>(slant.y());
  view.beam_b = static_cast<float>(sun.scattering_per_m * scattered_within(kBeamEdge_rad));
  if (!water.waves) return;
  double fourth = 0, sixth = 0;
  for (const WaveComponent& wave : water.waves->components()) {
    const double k = wave_number_rad_m(wave.angular_frequency_rad_s, water.waves->depth_m(), water.gravity_m_s2);
    const double along = slant.dot(Eigen::Vector2d(std::cos(wave.heading_rad), std::sin(wave.heading_rad)));
    const double stretched = 1 + along * along, curvature = k * k * wave.amplitude_m * stretched;
    fourth += 0.5 * curvature * curvature, sixth += 0.5 * curvature * curvature * k * k * stretched;
  }
  const double per_m = fourth > 0 ? std::sqrt(sixth / fourth) : 0;
  for (int level = 0; level < camera::kCausticLevels; ++level) {
    const double path_m = kFirstCausticLevel_m * std::exp2(level), beyond = path_m * sun.bend() * std::sqrt(fourth);
    view.swell_left[level] =
        static_cast<float>(pattern_left(sun.scattering_per_m, per_m, path_m) / (1 + beyond * beyond));
  }
}

void PreparedView::set_lamps(const PictureRequest& request) {
  if (!request.effects.has(Effect::kLamps)) return;
  for (const SpotLamp& lamp : request.lamps) {
    lamp.check();
    camera::SpotLight light{};
    const Pose& pose = lamp.world_from_lamp;
    assign(light.position, Eigen::Vector3d(pose.position_m - anchor_world_m));
    assign(light.axis, pose.direction(Eigen::Vector3d::UnitX()));
    const double inner = lamp.half_angle_rad * (1 - lamp.soft_share);
    light.cos_outer = static_cast<float>(std::cos(lamp.half_angle_rad));
    light.cos_inner = static_cast<float>(std::cos(inner));
    // A smoothstep over the cosine emits as much light as a uniform cone that ends at the mean of the soft edge's
    // cosines.
    const double steradians = 2 * std::numbers::pi * (1 - 0.5 * (light.cos_outer + light.cos_inner));
    assign(light.intensity, Bands(lamp.colour * (lamp.flux_lm / steradians / kSunlight_lx)));
    lamps_.push_back(light);
  }
  view.lamps = lamps_.data();
  view.lamp_count = static_cast<int>(lamps_.size());
  // From the point of a ray that is nearest to a lamp, at most 1.4 times the lamp's distance away, the light there and
  // back decreases by exp(-2 c): to 0.25 % after three attenuation lengths. Nothing is noticeable after eight.
  double farthest_m = 0;
  for (const camera::SpotLight& lamp : lamps_) {
    farthest_m = std::max(farthest_m, std::hypot(double{lamp.position[0]}, lamp.position[1], lamp.position[2]));
  }
  const float clearest = std::min({view.c[0], view.c[1], view.c[2]});
  view.glow.near_m = static_cast<float>(2.5 * farthest_m);
  view.glow.reach_m = std::min(8 / view.c[1], static_cast<float>(1.4 * farthest_m) + 3 / clearest);
}

}  // namespace uwsim
