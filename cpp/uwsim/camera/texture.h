#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// The image of a mesh's surface, rows from the top, and its place on each triangle: texture coordinates [0, 1] from
/// the lower left, which repeat outside that range. Bands of 8 bits: red, green and blue as sRGB; or these, the normal
/// in the frame of the image (x right, y up, 0..255 for -1..1), roughness and metalness, as in glTF 2.0.
struct TextureImage {
  static constexpr int kColourBands = 3, kAllBands = 8;

  int width = 0, height = 0, bands = kColourBands;
  std::vector<std::uint8_t> pixels;
  std::vector<float> corners;  ///< triangles x 3 corners x (s, t)
  /// triangles x 3 corners x 3: unit normals, interpolated over the triangle; empty for a faceted surface. Axes: from
  /// the first corner to the second, across in the triangle's plane, and the triangle's own normal.
  std::vector<float> normals;

  /// Throws InvalidValue.
  void check() const;
};

/// A surface at one point: what its material would have been there.
struct TextureSample {
  Eigen::Vector3f albedo;
  Eigen::Vector3f normal_mesh;  ///< unit
  float roughness = 1, metalness = 0;
  float texel_m = 0;  ///< the shorter side of the image's pixels, in the mesh's frame
};

/// An image laid on a mesh. A pixel of a picture shows the image's mean over the pixel's footprint: from levels of
/// half, a quarter, ... of the resolution (Williams 1983, "Pyramidal parametrics"), along the longer side of the
/// footprint at up to eight places (as in anisotropic filtering: McCormack et al. 1999, "Feline"). Where normals differ
/// within a footprint, the surface is rougher (Toksvig 2005, "Mipmapping normal maps").
class Texture {
 public:
  /// Throws InvalidValue for an image made for a different mesh.
  Texture(TextureImage image, const TriangleMesh& mesh);

  /// True if it has normals of its own; has_gloss: roughness and metalness, too.
  bool has_relief() const { return image_.bands == TextureImage::kAllBands || !image_.normals.empty(); }
  bool has_gloss() const { return image_.bands == TextureImage::kAllBands; }

  /// The sample at barycentric (u, v) of a triangle. `across_m`, `along_m`: the sides of the footprint, in the mesh's
  /// frame; zero for the image itself.
  TextureSample at(std::uint32_t triangle, float u, float v, const Eigen::Vector3f& across_m,
                   const Eigen::Vector3f& along_m) const;

 private:
  static constexpr int kMostPlaces = 8;
  using Bands = std::array<float, TextureImage::kAllBands>;
  struct Level {
    int width, height;
    std::size_t first;  // of `pixels`
  };
  struct Frame {                       // of a triangle, in the mesh's frame
    Eigen::Vector3f s_per_m, t_per_m;  // gradients of the coordinates
    Eigen::Vector3f first, across, normal;
    float texel_m;
  };
  void add_levels();
  void add(const Level& level, const Eigen::Vector2f& at, float weight, Bands& sum) const;
  Bands mean(const Eigen::Vector2f& at, const Eigen::Vector2f& across, const Eigen::Vector2f& along) const;

  TextureImage image_;  // its pixels are followed by those of the other levels
  std::vector<Level> levels_;
  std::vector<Frame> frames_;
};

}  // namespace uwsim
