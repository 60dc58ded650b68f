#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "uwsim/camera/kernels/block.h"
#include "uwsim/camera/kernels/view.h"
#include "uwsim/camera/optics.h"
#include "uwsim/core/image_buffer.h"

namespace uwsim {

/// For each pixel, the light of the scene attenuated by the beam coefficient, and the length of the light's path
/// through the water.
struct DirectLight {
  std::array<ImageBuffer<float>, 3> bands;
  ImageBuffer<float> path_m;

  /// Creates a dark image with room for this many pixels.
  void resize(std::size_t pixels);
  /// Adds a share of a finished block's light, without the light scattered by the water in front of the scene, and sets
  /// the path length.
  void keep(const camera::View& view, int left, int top, const camera::Block& block, bool set_path, float share);
};

/// Adds to a picture the light that particles scatter by small angles on its way to the camera, which blurs and
/// brightens the picture. It is computed as a convolution of the direct light (McGlamery 1975; Jaffe 1990, IEEE J.
/// Oceanic Eng. 15:101). The transfer function is that of the small-angle theory of Wells 1973, as compared with
/// measurements by Hou, Gray, Weidemann and Arnone 2008, Opt. Express 16:9958: over a path r it is
///
///   exp(-c r) exp(b r k), k = (1 - exp(-2 pi t p)) / (2 pi t p),
///
/// with p in cycles per radian, b the scattering coefficient of particles and t the mean scattering angle; the direct
/// light is the factor exp(-c r). All light that is scattered forward arrives, so a wide, even surface loses light by
/// absorption alone. The kernel's width is interpolated between kLayers path lengths; its energy is exact. Valid up to
/// about 5 attenuation lengths, beyond which the total scattering angles are large; the light beyond the picture's edge
/// is taken as its mirror image.
void add_forward_scatter(const DirectLight& direct, int width, int height, double pixel_rad, const Optics& optics,
                         const std::array<std::span<float>, 3>& picture, int threads);

}  // namespace uwsim
