#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace uwsim {

/// The image of a mesh's surface, 8-bit sRGB, rows from the top, and the texture coordinates of each triangle's
/// corners: [0, 1] from the lower left, repeating outside that range.
struct Texture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  std::vector<float> corners;  ///< triangles x 3 corners x (s, t)

  /// Throws InvalidValue.
  void check() const;
  /// Albedo at barycentric (u, v) of a triangle, interpolated between the four nearest pixels.
  std::array<float, 3> at(std::uint32_t triangle, float u, float v) const;
};

}  // namespace uwsim
