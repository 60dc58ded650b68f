#include <algorithm>
#include <cmath>
#include <limits>

#include "uwsim/sonar/imaging/surface_echo.h"

// Ghosts in imaging sonars: as in ghosts.cpp of the multibeam, but along every fourth ray of an arc, each of which
// stands for four. Transmitter and receiver count as having the same pattern, the root of the two-way one: a ray's
// patch, L^2 dO / cos i, is seen over the direct path with the pattern of the ray that is nearest to that path in
// angle, and across the arc with a Gaussian pattern, which the direct path meets at L / D times the angle: sqrt(2 / (1
// + (L/D)^2)) of the integral over the pattern remains. Both ways around count. Ghosts have no labels.
namespace uwsim {
namespace {

constexpr std::size_t kRaysTogether = 4;
constexpr int kMostBounces = 2;
constexpr double kClearance_m = 2e-3;  // a reflected ray starts this far from the surface
constexpr double kNearest_m = 0.05;

struct BouncedRay {
  std::size_t ray;
  double gain_sr, width_rad;
  Ray at;
  double length_m = 0, reflected = 1;
};

}  // namespace

void SurfaceEchoes::add_ghosts(const RayArc& arc, std::span<const ArcRay> rays, std::span<double> profile) const {
  std::vector<BouncedRay> going;
  for (std::size_t first = 0; first < rays.size(); first += kRaysTogether) {
    const std::size_t count = std::min(kRaysTogether, rays.size() - first), middle = first + count / 2;
    double gain_sr = 0;
    for (std::size_t k = first; k < first + count; ++k) gain_sr += rays[k].gain_sr;
    going.push_back({middle,
                     gain_sr,
                     rays[first + count - 1].upper_rad - rays[first].lower_rad,
                     {head_world_m_, arc.direction(rays[middle].angle_rad)}});
  }
  const FluidBottom usual;
  for (int bounce = 0; bounce <= kMostBounces && !going.empty(); ++bounce) {
    std::vector<Ray> cast;
    for (const BouncedRay& ray : going) cast.push_back(ray.at);
    std::vector<RayHit> hits(cast.size());
    scene_->cast(cast, 2 * range_max_m_, hits);
    std::vector<BouncedRay> left;
    std::vector<RayHit> met;
    std::vector<Ray> straight;
    for (std::size_t k = 0; k < going.size(); ++k) {
      BouncedRay ray = going[k];
      const Eigen::Vector3d direction = ray.at.direction_world;
      const double to_surface_m =
          direction.z() > 0 ? -ray.at.origin_world_m.z() / direction.z() : std::numeric_limits<double>::infinity();
      const bool surfaces = to_surface_m < hits[k].distance_m;
      const double step_m = surfaces ? to_surface_m : hits[k].distance_m;
      if (!(ray.length_m + step_m < 2 * range_max_m_)) continue;
      const Eigen::Vector3d normal =
          surfaces ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d(hits[k].normal_world.cast<double>());
      ray.length_m += step_m;
      ray.at.origin_world_m += step_m * direction;
      RayHit hit = hits[k];
      if (surfaces) hit.label = kNothing;
      ray.at.direction_world = direction - 2 * normal.dot(direction) * normal;
      left.push_back(ray);
      met.push_back(hit);
      straight.push_back({head_world_m_, (ray.at.origin_world_m - head_world_m_).normalized()});
    }
    std::vector<RayHit> seen(left.size());
    if (bounce > 0) scene_->cast(straight, 2 * range_max_m_, seen);
    for (std::size_t k = 0; k < left.size(); ++k) {
      BouncedRay& ray = left[k];
      const Label label = met[k].label;
      if (label != kNothing) {
        const Eigen::Vector3d normal = met[k].normal_world.cast<double>();
        const double cosine = std::clamp(std::abs(normal.dot(ray.at.direction_world)), 1e-3, 1.0);
        const double direct_m = (ray.at.origin_world_m - head_world_m_).norm();
        const double half_m = 0.5 * ray.length_m * ray.width_rad * std::sqrt(1 - cosine * cosine) / cosine;
        const auto add = [&](double power, double range_m, double spread_m) {
          if (!(range_m < range_max_m_)) return;
          const double lost = std::pow(10.0, -0.2 * absorption_db_m_ * range_m);
          spread(power * lost, std::max(range_m - spread_m, 0.0) / bin_m_, (range_m + spread_m) / bin_m_, profile);
        };
        if (bounce > 0) {
          const double length_m = std::max(ray.length_m, kNearest_m);
          add(ray.gain_sr * scattered(label, cosine) / cosine * ray.reflected * ray.reflected / (length_m * length_m),
              length_m, half_m);
        }
        if (bounce > 0 && direct_m > kNearest_m && seen[k].distance_m > 0.999 * direct_m - 0.01) {
          const Eigen::Vector3d& along = straight[k].direction_world;
          const double angle_rad = std::atan2(along.dot(arc.up_world), along.dot(arc.ahead_world));
          const auto nearest = std::min_element(rays.begin(), rays.end(), [&](const ArcRay& a, const ArcRay& b) {
            return std::abs(a.angle_rad - angle_rad) < std::abs(b.angle_rad - angle_rad);
          });
          if (angle_rad >= rays.front().lower_rad && angle_rad <= rays.back().upper_rad) {
            const double other = std::clamp(std::abs(normal.dot(along)), 1e-3, 1.0);
            const double gain_sr = std::sqrt(ray.gain_sr * nearest->gain_sr * static_cast<double>(kRaysTogether));
            const double ratio = ray.length_m / direct_m, across = std::sqrt(2 / (1 + ratio * ratio));
            const double power = 2 * gain_sr * across * std::sqrt(scattered(label, cosine) * scattered(label, other)) *
                                 ray.reflected / (cosine * direct_m * direct_m);
            add(power, 0.5 * (ray.length_m + direct_m), 0.5 * half_m);
          }
        }
        const FluidBottom& fluid = label < acoustics_->materials.size() ? acoustics_->materials[label].fluid : usual;
        ray.reflected *= std::pow(10.0, -0.1 * bottom_loss_db(fluid, std::asin(cosine)));
      }
      ray.at.origin_world_m += kClearance_m * ray.at.direction_world;
    }
    going = std::move(left);
  }
}

}  // namespace uwsim
