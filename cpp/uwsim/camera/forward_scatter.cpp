#include "uwsim/camera/forward_scatter.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include "uwsim/camera/parallel_rows.h"
#include "uwsim/camera/plane_transform.h"

namespace uwsim {
namespace {

constexpr int kLayers = 5;
constexpr double kMostLengths = 10;  // of attenuation, beyond which no direct light is left
constexpr int kMargin = 64;          // pixels on each side, which keep opposite edges apart

/// The least length from `least` on that is a product of small primes, for which transforms are fast.
int transform_length(int least) {
  for (int n = least;; ++n) {
    int left = n;
    for (const int prime : {2, 3, 5}) {
      while (left % prime == 0) left /= prime;
    }
    if (left == 1) return n;
  }
}

/// An index into a line of `size` that is continued by its mirror image.
int mirrored(int k, int size) {
  const int period = 2 * size;
  const int at = ((k % period) + period) % period;
  return at < size ? at : period - 1 - at;
}

using Complex = std::complex<float>;

/// A picture with its margins, transformed along both axes.
class Spectrum {
 public:
  Spectrum(int columns, int rows)
      : columns_(columns), rows_(rows), values_(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Complex& at(int column, int row) { return values_[static_cast<std::size_t>(row) * columns() + column]; }

  void transform(bool inverse) { transform_plane(values_, columns_, rows_, inverse); }

 private:
  int columns_, rows_;
  std::vector<Complex> values_;
};

/// The share of forward-scattered light that remains at a spatial frequency; `depth`: b r, `x`: 2 pi t p.
double kernel(double depth, double x) {
  const double k = x > 1e-6 ? -std::expm1(-x) / x : 1 - 0.5 * x;
  return std::expm1(depth * k) / std::expm1(depth);
}

}  // namespace

void DirectLight::resize(std::size_t pixels) {
  for (ImageBuffer<float>& band : bands) band.assign(pixels, 0.0f);
  path_m.assign(pixels, 0.0f);
}

void DirectLight::keep(const camera::View& view, int left, int top, const camera::Block& block, bool set_path,
                       float share) {
  for (int k = 0; k < camera::kBlockPixels; ++k) {
    const int u = left + k % camera::kBlockSide, v = top + k / camera::kBlockSide;
    if (u >= view.width || v >= view.height) continue;
    const auto at = static_cast<std::size_t>(v * view.width + u);
    bands[0][at] += share * (block.radiance.x.at[k] - block.veil.x.at[k]);
    bands[1][at] += share * (block.radiance.y.at[k] - block.veil.y.at[k]);
    bands[2][at] += share * (block.radiance.z.at[k] - block.veil.z.at[k]);
    if (set_path) path_m[at] = block.first_reach.at[k];
  }
}

void add_forward_scatter(const DirectLight& direct, int width, int height, double pixel_rad, const Optics& optics,
                         const std::array<std::span<float>, 3>& picture, int threads) {
  const Bands b = (optics.water.scattering - molecular_scattering()).max(0.0);
  const Bands c = optics.water.beam_attenuation();
  const double open_water_m = kMostLengths / c.minCoeff();
  double nearest_m = 1e30, farthest_m = 0;
  for (const double path : direct.path_m) {
    if (!(path > 0 && path < open_water_m)) continue;
    nearest_m = std::min(nearest_m, path);
    farthest_m = std::max(farthest_m, path);
  }
  if (farthest_m == 0) return;
  // Layers are spaced evenly in the logarithm of the path.
  const double first = std::log(nearest_m), gap = std::max(1e-3, (std::log(farthest_m) - first) / (kLayers - 1));
  const int columns = transform_length(width + 2 * kMargin), rows = transform_length(height + 2 * kMargin);
  for_rows(3, threads, [&](int band, int) {
    const auto colour = static_cast<std::size_t>(band);
    if (!(b(band) > 0)) return;
    Spectrum sum(columns, rows);
    for (int layer = 0; layer < kLayers; ++layer) {
      Spectrum part(columns, rows);
      for (int row = 0; row < rows; ++row) {
        const int v = mirrored(row - kMargin, height);
        for (int column = 0; column < columns; ++column) {
          const auto pixel = static_cast<std::size_t>(v * width + mirrored(column - kMargin, width));
          const double path_m = direct.path_m[pixel];
          if (!(path_m > 0 && path_m * c(band) < kMostLengths)) continue;
          const double share = 1 - std::abs((std::log(path_m) - first) / gap - layer);
          if (share <= 0) continue;
          part.at(column, row) = static_cast<float>(share * std::expm1(b(band) * path_m)) * direct.bands[colour][pixel];
        }
      }
      part.transform(false);
      const double depth = b(band) * std::exp(first + layer * gap);
      for (int row = 0; row < rows; ++row) {
        const double down = std::min(row, rows - row) / (rows * pixel_rad);
        for (int column = 0; column < columns; ++column) {
          const double across = std::min(column, columns - column) / (columns * pixel_rad);
          const double x = 2 * std::numbers::pi * optics.forward_scatter_rad * std::hypot(across, down);
          sum.at(column, row) += static_cast<float>(kernel(depth, x)) * part.at(column, row);
        }
      }
    }
    sum.transform(true);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const float light = std::max(0.0f, sum.at(u + kMargin, v + kMargin).real());
        picture[colour][static_cast<std::size_t>(v * width + u)] += light;
      }
    }
  });
}

}  // namespace uwsim
