#pragma once

#include <cstdint>

/// A block of 4 x 4 pixels, which the kernels process together. It consists of plain arrays, so that it can be compiled
/// for several instruction sets (kernels_*.cpp) with the same layout in each. Positions are metres from the camera,
/// along world axes; light is in the units of daylight.h, in the order red, green, blue.
namespace uwsim::camera {

inline constexpr int kBlockSide = 4;
inline constexpr int kBlockPixels = kBlockSide * kBlockSide;

/// One value per pixel.
struct BlockFloats {
  alignas(64) float at[kBlockPixels];
};
struct BlockVectors {
  BlockFloats x, y, z;  ///< or red, green, blue
};
/// -1 for true, 0 for false.
struct BlockMask {
  alignas(64) std::int32_t at[kBlockPixels];
};

/// The state of sixteen light paths, each traced from a pixel back to its light source. A path is one or two straight
/// segments: to the first hit and, if that is the water's surface, onward from there.
struct Block {
  BlockVectors origin, direction;  ///< of the current segment
  BlockFloats distance;            ///< along the ray to its hit; infinity without one
  BlockFloats reach;               ///< to the end of the segment: hit, water surface or far away
  BlockVectors normal;             ///< unit, on the winding side; later towards the eye, with relief
  BlockFloats rise;                ///< of the smooth surface that a facet stands for, above the facet
  BlockMask active, in_water;
  BlockMask lit;     ///< whether the segment ends on a surface that is to be shaded
  BlockMask onward;  ///< whether the path continues from the water's surface
  BlockMask material;
  alignas(64) std::uint32_t label[kBlockPixels], primitive[kBlockPixels];
  BlockVectors point, albedo;
  BlockVectors texture_albedo;  ///< replaces the material's albedo where has_texture is set
  BlockFloats texel_m;          ///< the side of its pixels there, below which the material's detail shows
  BlockMask has_texture;
  BlockMask is_glossy;               ///< and the material of gloss.h:
  BlockFloats roughness, metalness;  ///< in [0, 1]
  BlockVectors throughput;           ///< fraction of the light from beyond that reaches the eye
  BlockVectors radiance;             ///< light gathered so far
  BlockVectors sun_backscatter;      ///< the sun beam's part of the backscatter, which shafts modulate
  BlockFloats first_reach;           ///< of the first segment
  // The light under test, which is added only if the path's shadow ray is not blocked:
  BlockVectors unshadowed;   ///< radiance that it adds unless blocked
  BlockVectors shadow_from;  ///< where its shadow ray starts; finite in all lanes
  BlockVectors to_light;
  BlockFloats light_distance;
  BlockMask needs_shadow_ray;  ///< lanes where that light matters
  // Daylight at the segments' starts. Most start at the camera, so the next block's are usually as deep.
  BlockFloats day_depth{{__builtin_nanf("")}};  ///< as if it were that of no block, at first
  BlockVectors day_total, day_beam;
};

}  // namespace uwsim::camera
