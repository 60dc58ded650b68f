#include "uwsim/camera/lens.h"

#include <Eigen/LU>
#include <cmath>
#include <string>

#include "uwsim/camera/refraction.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr long kMostPixels = 1 << 24;  // 4096 x 4096: rendering it needs about 1 GB

struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

Distorted distorted(const Lens& l, const Eigen::Vector2d& ray) {
  const double x = ray.x(), y = ray.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (l.k1 + r2 * (l.k2 + r2 * l.k3));
  const double growth = 2 * (l.k1 + r2 * (2 * l.k2 + r2 * 3 * l.k3));  // d radial / dx = growth x
  Distorted d;
  d.point = {x * radial + 2 * l.p1 * x * y + l.p2 * (r2 + 2 * x * x),
             y * radial + l.p1 * (r2 + 2 * y * y) + 2 * l.p2 * x * y};
  const double across = growth * x * y + 2 * l.p1 * x + 2 * l.p2 * y;
  d.jacobian << radial + growth * x * x + 2 * l.p1 * y + 6 * l.p2 * x, across, across,
      radial + growth * y * y + 6 * l.p1 * y + 2 * l.p2 * x;
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
  for (const double k : {k1, k2, p1, p2, k3}) {
    require(std::isfinite(k) && std::abs(k) <= 100, "camera.distortion", k, "must be in [-100, 100]");
  }
  if (port) port->check();
  // unproject() must converge along the border, where distortion is strongest, and on rings inside it.
  for (const double part : {0.25, 0.5, 0.75, 1.0}) {
    for (int k = 0; k < 64; ++k) {
      const double s = k % 16 / 8.0 - 1;
      const Eigen::Vector2d edge = k < 16   ? Eigen::Vector2d(s, -1)
                                   : k < 32 ? Eigen::Vector2d(1, s)
                                   : k < 48 ? Eigen::Vector2d(-s, 1)
                                            : Eigen::Vector2d(-1, -s);
      const Eigen::Vector2d middle(0.5 * (width - 1), 0.5 * (height - 1));
      unproject(*this, middle + part * edge.cwiseProduct(Eigen::Vector2d(0.5 * width, 0.5 * height)));
    }
  }
}

Eigen::Vector2d project(const Lens& lens, const Eigen::Vector2d& ray, bool distort) {
  const Eigen::Vector2d bent = distort ? distorted(lens, ray).point : ray;
  return {lens.fx * bent.x() + lens.cx, lens.fy * bent.y() + lens.cy};
}

Eigen::Vector2d unproject(const Lens& lens, const Eigen::Vector2d& pixel, bool distort) {
  const Eigen::Vector2d bent((pixel.x() - lens.cx) / lens.fx, (pixel.y() - lens.cy) / lens.fy);
  if (!distort) return bent;
  Eigen::Vector2d ray = bent;
  for (int k = 0; k < 50; ++k) {
    const Distorted d = distorted(lens, ray);
    const double area = d.jacobian.determinant();
    if (!(area > 1e-3)) break;  // beyond the fold
    const Eigen::Vector2d step = d.jacobian.inverse() * (bent - d.point);
    ray += step;
    if (step.norm() < 1e-13 * (1 + ray.norm())) return ray;
  }
  const double error = (distorted(lens, ray).point - bent).norm();
  require(error < 1e-10 && distorted(lens, ray).jacobian.determinant() > 1e-3, "camera.distortion", pixel.transpose(),
          "is a pixel that no ray meets: the distortion folds the image over; make it smaller");
  return ray;
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
  return project(lens, high * direction, distort);
}

RayTable ray_table(const Lens& lens, bool distort, bool through_port) {
  RayTable table;
  const auto count = static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height);
  table.x.reserve(count);
  table.y.reserve(count);
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      Eigen::Vector2d ray = unproject(lens, {u, v}, distort);
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
