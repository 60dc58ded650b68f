#pragma once

#include <cstdint>

/// The constants of one picture: camera, terrain, water, light, lamps. Units and axes are as in block.h.
namespace uwsim::camera {

inline constexpr int kRippleCells = 128, kCausticLevels = 8;
inline constexpr float kRippleTile_m = 6.4f, kFirstCausticLevel_m = 0.5f;
inline constexpr double kTextureRepeat_m = 256;             // an integer number of ripple tiles: 40
inline constexpr float kPatch_per_m = 0.7f;                 ///< number of large patches of materials per metre
inline constexpr float kRippleX = 0.83f, kRippleY = 0.56f;  ///< across the ripples of sand in scenes without detail

/// Relief and pattern of a material that are finer than its grain, which scenes with detail show; see detail.h. The
/// numbers of cells per metre are whole.
struct MaterialDetail {
  float grit_per_m, grit_slope, grit_contrast;  ///< of noise: cells of the coarsest octave, slope and contrast of each
  float flatness;                               ///< how many times longer than high the noise's cells are
  float spots_per_m, spot_share;                ///< cells for pebbles or pits, and the share of cells that have one
  float spot_rise;                              ///< slope at a spot's rim; negative for a pit
  float spot_shade, spot_spread;  ///< albedo of spots relative to the surface around them: mean, and spread about it
};

/// A procedural material: two colours mixed in patches of two sizes, and relief.
struct Material {
  float base[3], other[3];  ///< albedo
  float contrast;           ///< of the patches; 0 for none
  float fine_per_m;         ///< number of small patches per metre, whole; the large ones measure 1.4 m in all materials
  float bump;               ///< tilt of the normal by the small patches [rad]
  float ripple_m;           ///< length of sand ripples; 0 for none
  float ripple_tilt;        ///< steepest slope of the ripples
  MaterialDetail detail;
};

/// A spot lamp. The intensity is in [irradiance m2]; the axis points away from the lamp.
struct SpotLight {
  float position[3], axis[3], intensity[3];
  float cos_outer, cos_inner;  ///< dark outside the outer cone, uniform within the inner
};

/// Heights and slopes of the world's waves at the nodes of a grid around the camera, [y][x][height, slope x, slope y].
struct WaveNodes {
  const float* values;  ///< null if the water is still
  int side;
  float spacing_m, left_m, bottom_m;  ///< of the first node, relative to the camera
};

/// The lamps' backscatter along rays that nothing ends early, for one pixel of each block; see lamp_glow.h.
inline constexpr int kGlowPixel = 2;  ///< the column and the row of that pixel in its block
struct LampGlow {
  float near_m, reach_m;  ///< most of the light comes from nearer than near_m, all but a negligible part from reach_m
  const float* bands[3];
  const std::uint8_t* is_smooth;  ///< whether interpolating between blocks is accurate; null if there is no glow
};

struct View {
  int width, height;
  const float *ray_x, *ray_y;              ///< each pixel's direction at unit depth
  const float *block_ray_x, *block_ray_y;  ///< the same for whole blocks, block by block
  const float *lens_x, *lens_y;            ///< each pixel's direction at the lens, inside a flat port
  /// Behind a flat port: the points where the extended rays meet the plane at depth 0, by pixel and by block.
  int has_offsets;
  const float *offset_x, *offset_y, *block_offset_x, *block_offset_y;
  float right[3], down[3], ahead[3];
  /// The camera's motion during the exposure: velocity [m/s] and rotation, the time between rows, and the time of the
  /// part being rendered, relative to the middle of the exposure.
  int moves;
  float velocity[3], spin_axis[3], spin_turns_per_s, row_s, part_s;
  float pixel_rad;  ///< angle across one pixel, approximately
  float wobble_rad, wobble_phase;
  float camera_z, surface_z;   ///< world z of the camera, and of the surface above or below it
  float texture_x, texture_y;  ///< position of the camera in the frame of textures and ripples, below kTextureRepeat_m
  /// That frame's origin in the patterns of materials, which do not repeat: in metres, whole and modulo 2^32; and in
  /// their large patches: the cell, and the place in it.
  std::uint32_t texture_first_x, texture_first_y, patch_cell_x, patch_cell_y;
  float patch_x, patch_y, ripple_first_m;
  double terrain_x, terrain_y;  ///< first node relative to the camera
  double terrain_spacing, anchor_z;
  const float* heights;  ///< null if there is no terrain
  int terrain_nx, terrain_ny;
  std::uint32_t terrain_label;

  int has_surface, camera_in_water, has_sunlight, has_attenuation, has_backscatter, has_caustics;
  float untested_share;  ///< see PictureRequest
  float refractive_index;
  float c[3], kd[3], kb[3];             ///< attenuation [1/m] of a beam, of daylight, of daylight's direct beam
  float particle_b[3], molecule_b[3];   ///< scattering [1/m]
  float upwelling[3];                   ///< fraction of downwelling light that returns
  float beam_level[3], total_level[3];  ///< irradiance on a level surface just below the water's surface
  float to_sun_in_water[3];
  float beam[3], sky[3], to_sun[3];  ///< in air
  const float *caustics, *slopes;    ///< from Ripples::Snapshot; null if there are no ripples
  float bend, slant[2];              ///< of the sun's beam in water: see FocusedSun
  float beam_b;                      ///< scattering [1/m] within the beam
  float swell_left[kCausticLevels];  ///< the share of the waves' focusing that is left
  WaveNodes waves;

  const Material* materials;
  int has_gloss;                      ///< whether any surface may be glossy
  int steep_material, land_material;  ///< indices of steep and of dry ground; the bed's index is 0
  int detail_end;  ///< materials below this index have detail; 0: none. Vehicles move through the patterns' frame
  float ripple_x, ripple_y;  ///< horizontal unit vector across the crests of the sand's ripples
  int lamp_count;
  const SpotLight* lamps;
  LampGlow glow;
  int shaft_width;                    ///< number of blocks in a row of the shafts' image; 0 for no shafts
  const float *shafts, *shaft_reach;  ///< the light along each block's ray, and how far along it counts [m]
};

}  // namespace uwsim::camera
