#include "uwsim/world/heightfield.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {

Heightfield::Heightfield(std::vector<float> heights_m, std::size_t nx, std::size_t ny, double spacing_m,
                         const Eigen::Vector2d& origin_m)
    : heights_m_(std::move(heights_m)), nx_(nx), ny_(ny), spacing_m_(spacing_m), origin_m_(origin_m) {
  require(nx >= 2 && ny >= 2, "terrain.heights_m.shape", std::to_string(ny) + " x " + std::to_string(nx),
          "must be at least 2 x 2");
  require(heights_m_.size() == nx * ny, "terrain.heights_m.size", heights_m_.size(), "must be nx * ny");
  require(std::isfinite(spacing_m) && spacing_m > 0, "terrain.spacing_m", spacing_m, "must be positive");
  require(origin_m.allFinite(), "terrain.origin_m", origin_m.transpose(), "must be finite");
  require(nx * ny <= 100'000'000, "terrain.heights_m.size", nx * ny, "must be at most 100 million");
  for (const float h : heights_m_) require(std::isfinite(h), "terrain.heights_m", h, "must be finite");
  const auto [low, high] = std::minmax_element(heights_m_.begin(), heights_m_.end());
  lowest_m_ = *low;
  highest_m_ = *high;
}

Eigen::Vector2d Heightfield::far_corner_m() const {
  return origin_m_ + spacing_m_ * Eigen::Vector2d(static_cast<double>(nx_ - 1), static_cast<double>(ny_ - 1));
}

double Heightfield::height_at(double x_m, double y_m) const {
  const double u = (x_m - origin_m_.x()) / spacing_m_;
  const double v = (y_m - origin_m_.y()) / spacing_m_;
  const auto last_x = static_cast<double>(nx_ - 1);
  const auto last_y = static_cast<double>(ny_ - 1);
  if (!(u >= 0 && v >= 0 && u <= last_x && v <= last_y)) return std::numeric_limits<double>::quiet_NaN();
  const auto i = static_cast<std::size_t>(std::min(u, last_x - 1));
  const auto j = static_cast<std::size_t>(std::min(v, last_y - 1));
  const double fx = u - static_cast<double>(i);
  const double fy = v - static_cast<double>(j);
  const double h00 = heights_m_[j * nx_ + i], h10 = heights_m_[j * nx_ + i + 1];
  const double h01 = heights_m_[(j + 1) * nx_ + i], h11 = heights_m_[(j + 1) * nx_ + i + 1];
  if (fx + fy <= 1) return h00 + fx * (h10 - h00) + fy * (h01 - h00);
  return h11 + (1 - fx) * (h01 - h11) + (1 - fy) * (h10 - h11);
}

Eigen::Vector3d Heightfield::vertex(std::size_t index) const {
  return {origin_m_.x() + static_cast<double>(index % nx_) * spacing_m_,
          origin_m_.y() + static_cast<double>(index / nx_) * spacing_m_, heights_m_[index]};
}

Triangle Heightfield::triangle(std::size_t index) const {
  const std::size_t cell = index / 2;
  const auto corner = static_cast<std::uint32_t>(cell / (nx_ - 1) * nx_ + cell % (nx_ - 1));
  const auto row = static_cast<std::uint32_t>(nx_);
  if (index % 2 == 0) return {corner, corner + 1, corner + row};
  return {corner + 1, corner + row + 1, corner + row};
}

}  // namespace uwsim
