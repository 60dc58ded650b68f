#pragma once

#include <cstdint>

#include "uwsim/camera/kernels/block.h"
#include "uwsim/camera/kernels/view.h"

/// The pixel kernels, which renderer.cpp calls for one block at a time. `left`, `top`: the block's first pixel.
namespace uwsim::camera {

/// Light before exposure, width x height.
struct RadiancePlanes {
  float *red, *green, *blue;
};

/// Images of geometry, width x height; normals x 3.
struct GeometryPlanes {
  float *depth, *normals;
  std::uint16_t* labels;
  std::uint8_t* classes;
  const std::uint8_t* class_of_label;
};

/// The settings of the image sensor, for the conversion of radiance to bytes.
struct Development {
  float gain, iso, vignetting;
  float full_well, read_noise;  ///< electrons
  int has_noise;
  std::uint64_t key, tick;
  std::uint32_t stream;
};

/// Sixteen boxes, relative to the camera, and how far along a ray each matters; infinity where there is none.
struct BoxLanes {
  BlockVectors low, high;
  BlockFloats least;
};

struct Kernels {
  // Pixels to rays, and hits to geometry.
  void (*primary_rays)(const View&, int left, int top, Block&);
  void (*shaft_rays)(const View&, int left, int top, int scale, Block&);
  void (*start_paths)(const View&, Block&);
  /// False if no ray from a point meets a box where that matters, for directions that differ from a unit vector by at
  /// most `aside` along each axis.
  bool (*may_meet)(const BoxLanes&, const float* from, const float* direction, float aside);
  void (*locate_hits)(const View&, Block&);
  void (*write_geometry)(const View&, int left, int top, const Block&, const GeometryPlanes&);
  // Light along one segment and at its end.
  void (*limit_to_sight)(const View&, const Block&, BlockFloats& far_m);
  void (*apply_water)(const View&, Block&);
  void (*refract_or_reflect)(const View&, Block&);
  void (*add_sky)(const View&, Block&);
  void (*shade_daylight)(const View&, Block&);
  void (*shade_lamp)(const View&, int lamp, Block&);
  void (*add_unblocked_light)(const View&, const BlockMask& blocked, Block&);
  void (*add_glow)(const View&, int left, int top, Block&);
  void (*shaft_sample_point)(const View&, float share, Block&);
  void (*shaft_sample_light)(const View&, const Block&, BlockFloats& weight, BlockFloats& caustic);
  // Paths to radiance, and radiance to bytes.
  void (*write_radiance)(const View&, int left, int top, const Block&, const RadiancePlanes&,
                         BlockFloats& root_luminance);
  void (*develop_row)(const View&, const Development&, const RadiancePlanes&, int row, std::uint8_t* rgb);
};

/// The kernels for the widest instruction set that this CPU supports; all produce the same bits.
const Kernels& kernels();
const Kernels& baseline_kernels();
const Kernels& avx2_kernels();
const Kernels& avx512_kernels();

}  // namespace uwsim::camera
