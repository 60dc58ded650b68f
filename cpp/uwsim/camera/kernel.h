#pragma once

#include <cstdint>

/// What the pixel kernels read and write: plain figures and arrays, so that they can be compiled for several kinds of
/// CPU (kernel_*.cpp) and mean the same in each. Positions are metres from the camera, along world axes; x, y, z and
/// red, green, blue in order; light in the units of daylight.h.
namespace uwsim::camera {

inline constexpr int kBlockSide = 4;
inline constexpr int kBlockPixels = kBlockSide * kBlockSide;
inline constexpr int kCausticCells = 128, kCausticLevels = 6;
inline constexpr float kCausticTile_m = 6.4f, kCausticFirst_m = 0.5f;

struct Row {
  alignas(64) float at[kBlockPixels];
};
struct Row3 {
  Row x, y, z;
};
struct Mask {
  alignas(64) std::int32_t at[kBlockPixels];
};

/// A surface as it looks in light: two colours that patches of two sizes mix, and a bumpy normal.
struct MaterialRow {
  float base[3], other[3];
  float contrast;     ///< of the patches, 0 none
  float fine_per_m;   ///< small patches a metre; large ones are 1.4 m for all
  float bump;         ///< tilt of the normal by the small patches [rad]
  float ripple_m;     ///< length of sand ripples, 0 none
  float ripple_tilt;  ///< their steepest slope
};

/// Light of a lamp in the water: intensity [irradiance m2], axis away from the lamp.
struct LampLight {
  float position[3], axis[3], intensity[3];
  float cos_outer, cos_inner;  ///< dark outside the outer cone, even within the inner
};

/// Heights and slopes of the world's waves around the camera, [y][x][height, slope x, slope y].
struct WaveWindow {
  const float* cells;  ///< null: still
  int side;
  float spacing, left, bottom;  ///< of the first node, relative to the camera
};

/// One picture's constants.
struct Shot {
  int width, height;
  const float *ray_x, *ray_y;              ///< a pixel's direction at unit depth
  const float *block_ray_x, *block_ray_y;  ///< the same of whole blocks, block by block
  float right[3], down[3], ahead[3];
  float pixel_rad;  ///< across one pixel, about
  float wobble_rad, wobble_phase;
  float camera_z, surface_z;    ///< world; of the surface above or below the camera
  float texture_x, texture_y;   ///< camera in the frame of textures and ripples, which repeat
  double terrain_x, terrain_y;  ///< first node relative to the camera
  double terrain_spacing, anchor_z;
  const float* heights;  ///< null: no terrain
  int terrain_nx;
  std::uint32_t terrain_label;

  int has_surface, camera_wet, has_depth_light, has_attenuation, has_backscatter, has_caustics;
  float index;               ///< of refraction
  float c[3], kd[3], kb[3];  ///< beam; daylight; of it the sun's own beam
  float particle_b[3], molecule_b[3];
  float upwelling[3];                                  ///< share of downwelling light that comes back up
  float beam_level[3], total_level[3], to_sun_wet[3];  ///< just below the surface
  float beam[3], sky[3], to_sun[3];                    ///< in air
  const float *caustics, *slopes;                      ///< Ripples::Moment's, null: flat
  float bend;                                          ///< 1 - 1 / index
  WaveWindow waves;

  const MaterialRow* materials;
  int terrain_rock, terrain_dry;  ///< rows of steep and of dry ground; its row is that of the label
  int lamp_count;
  const LampLight* lamps;
  int shaft_width;  ///< blocks a row of the shafts' picture, 0: none
  const float* shafts;
};

/// Sixteen pixels on their way from a ray to a colour.
struct Block {
  Row3 origin, direction;
  Row distance;  ///< along the ray to what was hit, infinity for nothing
  Row reach;     ///< to where this piece of the ray ends: hit, surface or afar
  Row3 normal;   ///< unit, of the winding side; then towards the eye, with bumps
  Mask active, wet, lit, onward;
  Mask material;
  alignas(64) std::uint32_t label[kBlockPixels], primitive[kBlockPixels];
  Row3 point, albedo, given;  ///< given: a texture's colour where has_given
  Mask has_given;
  Row3 through, light;  ///< what of later light reaches the eye, and what has
  Row3 veil_beam;       ///< part of the veil that the sun's beam makes
  Row3 share;           ///< irradiance by the light under test, if nothing is in its way
  Row3 to_light;
  Row light_distance;
  Mask wants;  ///< lanes whose shadow ray is worth casting
};

/// Light before exposure, planes of width x height.
struct Film {
  float *red, *green, *blue;
};

/// Where geometry goes, width x height.
struct GeometryPlanes {
  float *depth, *normals;  ///< normals x 3
  std::uint16_t* labels;
  std::uint8_t* classes;
  const std::uint8_t* class_of_label;
};

struct Developing {
  float gain, iso, vignetting;
  float full_well, read_noise;  ///< electrons
  int has_noise;
  std::uint64_t key, tick;
  std::uint32_t stream;
};

struct Kernels {
  const char* name;
  void (*aim)(const Shot&, int left, int top, Block&);
  void (*open_eye)(const Shot&, Block&);
  void (*aim_shafts)(const Shot&, int left, int top, int scale, Block&);
  void (*place)(const Shot&, Block&);
  void (*write_geometry)(const Shot&, int left, int top, const Block&, const GeometryPlanes&);
  void (*pass_water)(const Shot&, Block&);
  void (*go_on)(const Shot&, Block&);
  void (*sky)(const Shot&, Block&);
  void (*light_by_day)(const Shot&, Block&);
  void (*light_by_lamp)(const Shot&, int lamp, Block&);
  void (*add_light)(const Shot&, const Mask& blocked, Block&);
  void (*lamp_veil)(const Shot&, int lamp, Block&);
  void (*shaft_point)(const Shot&, float share, Block&);
  void (*shaft_light)(const Shot&, const Block&, Row& weight, Row& caustic);
  void (*expose)(const Shot&, int left, int top, const Block&, const Film&, Row& brightness);
  void (*develop)(const Shot&, const Developing&, const Film&, int row, std::uint8_t* rgb);
};

/// The fastest that this CPU runs; all give the same bits.
const Kernels& kernels();
const Kernels& baseline_kernels();
const Kernels* avx2_kernels();  ///< null where not compiled in
const Kernels* avx512_kernels();

}  // namespace uwsim::camera
