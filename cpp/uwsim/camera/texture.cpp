#include "uwsim/camera/texture.h"

#include <cmath>
#include <cstddef>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

const std::array<float, 256>& linear_of_srgb() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> all{};
    for (int k = 0; k < 256; ++k) {
      const double x = k / 255.0;
      all[static_cast<std::size_t>(k)] =
          static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
    }
    return all;
  }();
  return table;
}

int wrapped(int at, int size) { return (at % size + size) % size; }

}  // namespace

void Texture::check() const {
  require(width >= 1 && height >= 1, "texture.size", width, "must be at least 1 x 1 pixels");
  require(rgb.size() == 3u * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), "texture.rgb",
          rgb.size(), "must hold three bytes for each pixel");
  for (const float corner : corners) require(std::abs(corner) < 1e4f, "texture.corners", corner, "must be finite");
}

std::array<float, 3> Texture::at(std::uint32_t triangle, float u, float v) const {
  const float* c = corners.data() + std::size_t{6} * triangle;
  const float w = 1 - u - v;
  const float s = w * c[0] + u * c[2] + v * c[4], t = w * c[1] + u * c[3] + v * c[5];
  const float x = s * static_cast<float>(width) - 0.5f, y = (1 - t) * static_cast<float>(height) - 0.5f;
  const float left = std::floor(x), top = std::floor(y);
  const float fx = x - left, fy = y - top;
  const int i = wrapped(static_cast<int>(left), width), i1 = wrapped(i + 1, width);
  const int j = wrapped(static_cast<int>(top), height), j1 = wrapped(j + 1, height);
  const auto value = [&](int column, int row, std::size_t band) {
    const std::size_t pixel =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
    return linear_of_srgb()[rgb[3 * pixel + band]];
  };
  std::array<float, 3> colour{};
  for (std::size_t band = 0; band < 3; ++band) {
    colour[band] = (1 - fy) * ((1 - fx) * value(i, j, band) + fx * value(i1, j, band)) +
                   fy * ((1 - fx) * value(i, j1, band) + fx * value(i1, j1, band));
  }
  return colour;
}

}  // namespace uwsim
