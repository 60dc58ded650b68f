#include "uwsim/camera/texture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr float kUnevenness = 0.004f;  // of the length of unit vectors in 8 bits
constexpr float kLargestTexel_m = 1e3f;
constexpr float kSmoothest = 0.08f;  // a smoother surface would mirror a lamp in less than a pixel

/// sRGB (IEC 61966-2-1).
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

std::uint8_t srgb_of_linear(float linear) {
  const auto& table = linear_of_srgb();
  const auto above = std::ranges::lower_bound(table, linear);
  if (above == table.begin()) return 0;
  if (above == table.end()) return 255;
  const auto k = static_cast<std::uint8_t>(above - table.begin());
  return linear - table[k - 1u] < table[k] - linear ? static_cast<std::uint8_t>(k - 1) : k;
}

int wrapped(int at, int size) { return (at % size + size) % size; }

/// The pixels of a row that the pixels of a row of half its length cover, with their weights.
struct Share {
  int first = 0, count = 0;
  std::array<float, 4> weight{};
};
std::vector<Share> halved(int size) {
  const int half = std::max(1, size / 2);
  std::vector<Share> shares(static_cast<std::size_t>(half));
  const double ratio = static_cast<double>(size) / half;
  for (int k = 0; k < half; ++k) {
    Share& share = shares[static_cast<std::size_t>(k)];
    const double low = k * ratio, high = (k + 1) * ratio;
    share.first = static_cast<int>(low);
    for (int pixel = share.first; pixel < size && pixel < high && share.count < 4; ++pixel) {
      const double covered = std::min<double>(high, pixel + 1) - std::max<double>(low, pixel);
      share.weight[static_cast<std::size_t>(share.count++)] = static_cast<float>(covered / ratio);
    }
  }
  return shares;
}

}  // namespace

void TextureImage::check() const {
  require(width >= 1 && height >= 1, "texture.size", width, "must be at least 1 x 1 pixels");
  require(bands == kColourBands || bands == kAllBands, "texture.bands", bands, "must be 3 or 8");
  require(pixels.size() ==
              static_cast<std::size_t>(bands) * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
          "texture.pixels", pixels.size(), "must hold one byte for each band of each pixel");
  for (const float corner : corners) require(std::abs(corner) < 1e4f, "texture.corners", corner, "must be finite");
  for (const float part : normals) require(std::abs(part) < 1.001f, "texture.normals", part, "must be of unit vectors");
}

Texture::Texture(TextureImage image, const TriangleMesh& mesh) : image_(std::move(image)) {
  image_.check();
  const std::size_t triangles = mesh.triangles.size();
  require(image_.corners.size() == 6 * triangles, "texture.corners", image_.corners.size(),
          "must be six for each triangle");
  require(image_.normals.empty() || image_.normals.size() == 9 * triangles, "texture.normals", image_.normals.size(),
          "must be nine for each triangle");
  frames_.reserve(triangles);
  for (std::size_t k = 0; k < triangles; ++k) {
    const Triangle& t = mesh.triangles[k];
    const Eigen::Vector3d ab = mesh.vertices_m[t[1]] - mesh.vertices_m[t[0]];
    const Eigen::Vector3d ac = mesh.vertices_m[t[2]] - mesh.vertices_m[t[0]];
    const Eigen::Vector3d normal = ab.cross(ac);
    const double square = normal.squaredNorm();
    Frame frame{};
    if (square > 0) {
      const Eigen::Vector3d u_per_m = ac.cross(normal) / square, v_per_m = normal.cross(ab) / square;
      const float* c = image_.corners.data() + 6 * k;
      frame.s_per_m = ((c[2] - c[0]) * u_per_m.cast<float>() + (c[4] - c[0]) * v_per_m.cast<float>()).eval();
      frame.t_per_m = ((c[3] - c[1]) * u_per_m.cast<float>() + (c[5] - c[1]) * v_per_m.cast<float>()).eval();
      const float texels_per_m = std::max(frame.s_per_m.norm() * static_cast<float>(image_.width),
                                          frame.t_per_m.norm() * static_cast<float>(image_.height));
      frame.texel_m = 1 / std::max(texels_per_m, 1 / kLargestTexel_m);
      frame.normal = (normal / std::sqrt(square)).cast<float>();
      frame.first = ab.normalized().cast<float>();
      frame.across = frame.normal.cross(frame.first);
    }
    frames_.push_back(frame);
  }
  add_levels();
}

/// Appends the image at half its resolution, at a quarter, and so on down to a single pixel. Colours are averaged as
/// light.
void Texture::add_levels() {
  levels_.push_back({image_.width, image_.height, 0});
  const auto bands = static_cast<std::size_t>(image_.bands);
  const auto& linear = linear_of_srgb();
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level from = levels_.back();
    const std::vector<Share> columns = halved(from.width), rows = halved(from.height);
    const Level to = {static_cast<int>(columns.size()), static_cast<int>(rows.size()), image_.pixels.size()};
    image_.pixels.resize(to.first + bands * columns.size() * rows.size());
    std::uint8_t* out = image_.pixels.data() + to.first;
    for (const Share& row : rows) {
      for (const Share& column : columns) {
        Bands sum{};
        for (int j = 0; j < row.count; ++j) {
          const std::size_t line = static_cast<std::size_t>(row.first + j) * static_cast<std::size_t>(from.width);
          for (int i = 0; i < column.count; ++i) {
            const float weight = row.weight[static_cast<std::size_t>(j)] * column.weight[static_cast<std::size_t>(i)];
            const std::uint8_t* pixel =
                image_.pixels.data() + from.first + bands * (line + static_cast<std::size_t>(column.first + i));
            for (std::size_t b = 0; b < bands; ++b)
              sum[b] += weight * (b < 3 ? linear[pixel[b]] : static_cast<float>(pixel[b]));
          }
        }
        for (std::size_t b = 0; b < bands; ++b) {
          *out++ = b < 3 ? srgb_of_linear(sum[b]) : static_cast<std::uint8_t>(std::lround(sum[b]));
        }
      }
    }
    levels_.push_back(to);
  }
}

/// Adds a level's value at texture coordinates, interpolated between its four nearest pixels.
void Texture::add(const Level& level, const Eigen::Vector2f& at, float weight, Bands& sum) const {
  const float x = at.x() * static_cast<float>(level.width) - 0.5f;
  const float y = (1 - at.y()) * static_cast<float>(level.height) - 0.5f;
  const float left = std::floor(x), top = std::floor(y);
  const float fx = x - left, fy = y - top;
  const int i = wrapped(static_cast<int>(left), level.width), i1 = wrapped(i + 1, level.width);
  const int j = wrapped(static_cast<int>(top), level.height), j1 = wrapped(j + 1, level.height);
  const auto bands = static_cast<std::size_t>(image_.bands);
  const auto pixel = [&](int column, int row) {
    const std::size_t number =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(level.width) + static_cast<std::size_t>(column);
    return image_.pixels.data() + level.first + bands * number;
  };
  const std::uint8_t *a = pixel(i, j), *b = pixel(i1, j), *c = pixel(i, j1), *d = pixel(i1, j1);
  const auto& linear = linear_of_srgb();
  for (std::size_t band = 0; band < bands; ++band) {
    const auto value = [&](const std::uint8_t* from) {
      return band < 3 ? linear[from[band]] : static_cast<float>(from[band]) * (1 / 255.0f);
    };
    sum[band] +=
        weight * ((1 - fy) * ((1 - fx) * value(a) + fx * value(b)) + fy * ((1 - fx) * value(c) + fx * value(d)));
  }
}

/// The mean over a footprint with these sides, in texture coordinates.
Texture::Bands Texture::mean(const Eigen::Vector2f& at, const Eigen::Vector2f& across,
                             const Eigen::Vector2f& along) const {
  const Eigen::Array2f size(static_cast<float>(image_.width), static_cast<float>(image_.height));
  const float one = (across.array() * size).matrix().norm(), other = (along.array() * size).matrix().norm();
  const float longer = std::max(one, other), shorter = std::min(one, other);
  const Eigen::Vector2f& way = other >= one ? along : across;
  Bands sum{};
  if (!(longer > 1)) {  // of a pixel
    add(levels_.front(), at, 1, sum);
    return sum;
  }
  const int places = static_cast<int>(std::ceil(std::min({longer, longer / shorter, float{kMostPlaces}})));
  const float wide = std::clamp(std::max(shorter, longer / static_cast<float>(places)), 1.0f, 1e6f);
  const float level = std::min(std::log2(wide), static_cast<float>(levels_.size() - 1));
  const auto finer = static_cast<std::size_t>(level);
  const float coarse = level - static_cast<float>(finer), weight = 1 / static_cast<float>(places);
  for (int k = 0; k < places; ++k) {
    const Eigen::Vector2f place = at + ((static_cast<float>(k) + 0.5f) * weight - 0.5f) * way;
    add(levels_[finer], place, weight * (1 - coarse), sum);
    if (coarse > 0) add(levels_[finer + 1], place, weight * coarse, sum);
  }
  return sum;
}

TextureSample Texture::at(std::uint32_t triangle, float u, float v, const Eigen::Vector3f& across_m,
                          const Eigen::Vector3f& along_m) const {
  const float* c = image_.corners.data() + std::size_t{6} * triangle;
  const Frame& frame = frames_[triangle];
  const float w = 1 - u - v;
  const Eigen::Vector2f place(w * c[0] + u * c[2] + v * c[4], w * c[1] + u * c[3] + v * c[5]);
  const Bands found = mean(place, {frame.s_per_m.dot(across_m), frame.t_per_m.dot(across_m)},
                           {frame.s_per_m.dot(along_m), frame.t_per_m.dot(along_m)});
  TextureSample sample{{found[0], found[1], found[2]}, frame.normal};
  sample.texel_m = frame.texel_m;
  if (!image_.normals.empty()) {
    const float* n = image_.normals.data() + std::size_t{9} * triangle;
    const Eigen::Vector3f own(w * n[0] + u * n[3] + v * n[6], w * n[1] + u * n[4] + v * n[7],
                              w * n[2] + u * n[5] + v * n[8]);
    sample.normal_mesh = (own.x() * frame.first + own.y() * frame.across + own.z() * frame.normal).normalized();
  }
  if (!has_gloss()) return sample;
  const Eigen::Vector3f relief = 2 * Eigen::Vector3f(found[3], found[4], found[5]) - Eigen::Vector3f::Ones();
  const float length = std::clamp(relief.norm(), 0.1f, 1.0f);
  const Eigen::Vector3f right = frame.s_per_m - sample.normal_mesh * sample.normal_mesh.dot(frame.s_per_m);
  if (right.squaredNorm() > 0) {
    const Eigen::Vector3f x = right.normalized(), side = sample.normal_mesh.cross(x);
    const Eigen::Vector3f y = side.dot(frame.t_per_m) < 0 ? Eigen::Vector3f(-side) : side;
    sample.normal_mesh = (relief.x() * x + relief.y() * y + relief.z() * sample.normal_mesh).normalized();
  }
  // Slopes of variance s^2 per axis shorten the mean of unit normals to 1 - s^2, and add 2 s^2 to the square of GGX's
  // width, which is the square of roughness.
  const float shortened = std::max(1 - length - kUnevenness, 0.0f);
  const float width = found[6] * found[6];
  sample.roughness = std::clamp(std::pow(width * width + 2 * shortened, 0.25f), kSmoothest, 1.0f);
  sample.metalness = found[7];
  return sample;
}

}  // namespace uwsim
