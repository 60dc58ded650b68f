#include "uwsim/camera/lens.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "uwsim/camera/refraction.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kLeastOpening = 1e-3;
constexpr long kMostPixels = 1 << 24;  // 4096 x 4096: rendering it needs about 1 GB

struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
  double opening;  ///< falls to 0 where the distortion folds the image over
};

Distorted bent_by_angle(const Lens& l, const Eigen::Vector2d& ray) {
  const double r = ray.norm(), a = std::atan(r), a2 = a * a;
  const double length = a * (1 + a2 * (l.k1 + a2 * (l.k2 + a2 * (l.k3 + a2 * l.k4))));
  const double by_angle = 1 + a2 * (3 * l.k1 + a2 * (5 * l.k2 + a2 * (7 * l.k3 + a2 * 9 * l.k4)));
  const double factor = r > 1e-8 ? length / r : 1, growth = by_angle / (1 + r * r);
  const Eigen::Vector2d outwards = r > 1e-8 ? Eigen::Vector2d(ray / r) : Eigen::Vector2d::Zero();
  Distorted d;
  d.point = factor * ray;
  d.jacobian = factor * Eigen::Matrix2d::Identity() + (growth - factor) * outwards * outwards.transpose();
  d.opening = by_angle;
  return d;
}

Distorted distorted(const Lens& l, const Eigen::Vector2d& ray) {
  if (l.is_equidistant) return bent_by_angle(l, ray);
  const double x = ray.x(), y = ray.y(), r2 = x * x + y * y;
  double radial = 1 + r2 * (l.k1 + r2 * (l.k2 + r2 * l.k3));
  double growth = 2 * (l.k1 + r2 * (2 * l.k2 + r2 * 3 * l.k3));  // d radial / dx = growth x
  if (l.k4 != 0 || l.k5 != 0 || l.k6 != 0) {
    const double divisor = 1 + r2 * (l.k4 + r2 * (l.k5 + r2 * l.k6));
    const double divisor_growth = 2 * (l.k4 + r2 * (2 * l.k5 + r2 * 3 * l.k6));
    radial /= divisor;
    growth = (growth - radial * divisor_growth) / divisor;
  }
  Distorted d;
  d.point = {x * radial + 2 * l.p1 * x * y + l.p2 * (r2 + 2 * x * x),
             y * radial + l.p1 * (r2 + 2 * y * y) + 2 * l.p2 * x * y};
  const double across = growth * x * y + 2 * l.p1 * x + 2 * l.p2 * y;
  d.jacobian << radial + growth * x * x + 2 * l.p1 * y + 6 * l.p2 * x, across, across,
      radial + growth * y * y + 6 * l.p1 * y + 2 * l.p2 * x;
  d.opening = d.jacobian.determinant();
  return d;
}

/// The tangent of a ray's angle in a medium of index n, divided by its tangent in air, r.
double slope_ratio(double r, double n) { return 1 / std::sqrt(n * n * (1 + r * r) - r * r); }

/// The distance of a ray from the axis at depth z in water, divided by r, the tangent of its angle in air.
double reach_ratio(const FlatPort& port, double r, double z_m) {
  const double in_water_m = z_m - port.distance_m - port.thickness_m;
  return port.distance_m + port.thickness_m * slope_ratio(r, port.refractive_index) +
         in_water_m * slope_ratio(r, kWaterIndex);
}

/// Rearranges a table row by row to one block by block.
std::vector<float> by_blocks(const std::vector<float>& rows, const Lens& lens) {
  constexpr int kSide = 4;
  std::vector<float> blocks;
  if (rows.empty()) return blocks;
  for (int top = 0; top + kSide <= lens.height; top += kSide) {
    for (int left = 0; left + kSide <= lens.width; left += kSide) {
      for (int k = 0; k < kSide * kSide; ++k) {
        blocks.push_back(rows[static_cast<std::size_t>((top + k / kSide) * lens.width + left + k % kSide)]);
      }
    }
  }
  return blocks;
}

}  // namespace

void FlatPort::check() const {
  require(distance_m >= 0 && distance_m <= 1, "camera.port.distance_m", distance_m, "must be in [0, 1] m");
  require(thickness_m >= 0 && thickness_m <= 1, "camera.port.thickness_m", thickness_m, "must be in [0, 1] m");
  require(refractive_index >= 1 && refractive_index <= 3, "camera.port.refractive_index", refractive_index,
          "must be in [1, 3]");
}

void Lens::check() const {
  const auto check_side = [](const char* name, int pixels) {
    require(pixels >= 1 && pixels <= kLargestSide, std::string("camera.") + name, pixels,
            "must be in [1, 8192] pixels");
  };
  check_side("width", width);
  check_side("height", height);
  require(static_cast<long>(width) * height <= kMostPixels, "camera.width", width,
          "times its height must be at most 16.8 million pixels");
  for (const double f : {fx, fy}) {
    require(f >= 1 && f <= 1e6, "camera.focal_length", f, "must be in [1, 1e6] pixels");
  }
  require(std::isfinite(cx) && std::isfinite(cy) && std::abs(cx) <= 1e6 && std::abs(cy) <= 1e6,
          "camera.principal_point", cx, "must be finite, within 1e6 pixels");
  for (const double k : {k1, k2, p1, p2, k3, k4, k5, k6}) {
    require(std::isfinite(k) && std::abs(k) <= 1e4, "camera.distortion", k, "must be in [-10000, 10000]");
  }
  if (port) port->check();
}

bool shows(const Lens& lens, const Eigen::Vector2d& ray) {
  return distorted(lens, ray).opening > kLeastOpening && !(lens.is_equidistant && ray.norm() > kWidestRay);
}

Eigen::Vector2d project(const Lens& lens, const Eigen::Vector2d& ray, bool distort) {
  const Eigen::Vector2d bent = distort ? distorted(lens, ray).point : ray;
  return {lens.fx * bent.x() + lens.cx, lens.fy * bent.y() + lens.cy};
}

namespace {

/// Returns the ray that the distortion bends to a point, or nullopt.
std::optional<Eigen::Vector2d> unbent(const Lens& lens, const Eigen::Vector2d& bent) {
  Eigen::Vector2d ray = bent;
  if (lens.is_equidistant && bent.norm() > 1e-8) {
    ray *= std::tan(std::min(bent.norm(), 1.4)) / bent.norm();  // Newton's method begins close to the root
  }
  bool ends = false;
  for (int k = 0; k < 50 && !ends; ++k) {
    const Distorted d = distorted(lens, ray);
    if (!(d.opening > kLeastOpening)) break;  // beyond the fold
    const Eigen::Vector2d step = d.jacobian.inverse() * (bent - d.point);
    ray += step;
    ends = step.norm() < 1e-13 * (1 + ray.norm());
  }
  if (!ends) {
    const Distorted d = distorted(lens, ray);
    ends = (d.point - bent).norm() < 1e-10 && d.opening > kLeastOpening;
  }
  if (!ends || (lens.is_equidistant && !(ray.norm() <= kWidestRay))) return std::nullopt;
  return ray;
}

/// The outermost rays that a lens shows, by direction from the principal point.
class OutermostRays {
 public:
  explicit OutermostRays(const Lens& lens) : rays_(kDirections) {
    const double across = std::max(std::abs(lens.cx), std::abs(lens.width - lens.cx)) / lens.fx;
    const double down = std::max(std::abs(lens.cy), std::abs(lens.height - lens.cy)) / lens.fy;
    for (std::size_t k = 0; k < rays_.size(); ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kDirections;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      double low = 0, high = std::hypot(across, down);
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (low + high);
        const std::optional<Eigen::Vector2d> ray = unbent(lens, middle * direction);
        (ray ? low : high) = middle;
        if (ray) rays_[k] = {middle, ray->norm()};
      }
    }
  }

  /// Returns a ray for a point that no ray is bent to; see RayTable.
  Eigen::Vector2d beyond(const Eigen::Vector2d& bent) const {
    const double turns = std::atan2(bent.y(), bent.x()) / (2 * std::numbers::pi);
    const long nearest = std::lround(kDirections * (turns + 1)) % kDirections;
    const Ray& last = rays_[static_cast<std::size_t>(nearest)];
    return (last.r + bent.norm() - last.bent) * bent.normalized();
  }

 private:
  static constexpr long kDirections = 1024;
  struct Ray {
    double bent = 0, r = 0;  ///< distances from the principal point, as bent and as undistorted
  };
  std::vector<Ray> rays_;
};

}  // namespace

std::optional<Eigen::Vector2d> unproject(const Lens& lens, const Eigen::Vector2d& pixel, bool distort) {
  const Eigen::Vector2d bent((pixel.x() - lens.cx) / lens.fx, (pixel.y() - lens.cy) / lens.fy);
  if (!distort) return bent;
  return unbent(lens, bent);
}

std::optional<Eigen::Vector2d> project_through_port(const Lens& lens, const Eigen::Vector3d& point_m, bool distort) {
  const FlatPort& port = *lens.port;
  const double z = point_m.z(), reach_m = point_m.head<2>().norm();
  if (!(z > port.distance_m + port.thickness_m)) return std::nullopt;
  // r reach_ratio(r) grows with r, at least as fast as r times its limit for large r; the root lies between.
  const double least = kWaterIndex, in_water_m = z - port.distance_m - port.thickness_m;
  double low = reach_m / z, high = reach_m / z * least + reach_m / in_water_m * least + 1e-12;
  while (high * reach_ratio(port, high, z) < reach_m) high *= 2;
  for (int k = 0; k < 200 && high - low > 1e-14 * (1 + high); ++k) {
    const double middle = 0.5 * (low + high);
    (middle * reach_ratio(port, middle, z) < reach_m ? low : high) = middle;
  }
  const Eigen::Vector2d direction =
      reach_m > 0 ? Eigen::Vector2d(point_m.head<2>() / reach_m) : Eigen::Vector2d::Zero();
  if (distort && !shows(lens, high * direction)) return std::nullopt;
  return project(lens, high * direction, distort);
}

RayTable ray_table(const Lens& lens, bool distort, bool through_port) {
  RayTable table;
  const auto count = static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height);
  std::optional<OutermostRays> outermost;
  table.x.reserve(count);
  table.y.reserve(count);
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      Eigen::Vector2d ray;
      if (const auto met = unproject(lens, {u, v}, distort)) {
        ray = *met;
      } else {
        if (!outermost) outermost.emplace(lens);
        ray = outermost->beyond({(u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy});
        ++table.folded;
      }
      if (through_port) {
        const double r = ray.norm();
        const Eigen::Vector2d offset_m = reach_ratio(*lens.port, r, 0) * ray;
        table.offset_x_m.push_back(static_cast<float>(offset_m.x()));
        table.offset_y_m.push_back(static_cast<float>(offset_m.y()));
        ray *= slope_ratio(r, kWaterIndex);
      }
      table.x.push_back(static_cast<float>(ray.x()));
      table.y.push_back(static_cast<float>(ray.y()));
    }
  }
  table.block_x = by_blocks(table.x, lens);
  table.block_y = by_blocks(table.y, lens);
  table.block_offset_x_m = by_blocks(table.offset_x_m, lens);
  table.block_offset_y_m = by_blocks(table.offset_y_m, lens);
  return table;
}

}  // namespace uwsim
