#include "uwsim/world/round_shape.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kSharpestCosine = 0.1;  // cosine of half the angle of the sharpest bend

void require_round(const Eigen::Vector3d& point, double radius_m, const char* path) {
  require(point.allFinite(), std::string(path) + ".points_m", point.transpose(), "must be finite");
  require(std::isfinite(radius_m) && radius_m > 0, std::string(path) + ".radius_m", radius_m, "must be positive");
}

/// The nearest of the surfaces that a ray hits within a range of distances.
class Nearest {
 public:
  Nearest(double near_m, double far_m) : near_m_(near_m), far_m_(far_m) {}

  bool accepts(double distance_m) const { return distance_m >= near_m_ && distance_m <= far_m_; }
  void keep(double distance_m, const Eigen::Vector3d& normal) {
    hit_ = {distance_m, normal};
    far_m_ = distance_m;
  }
  const std::optional<ShapeHit>& hit() const { return hit_; }

 private:
  double near_m_, far_m_;
  std::optional<ShapeHit> hit_;
};

void meet_sphere(const RoundShape& shape, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 Nearest& nearest) {
  const Eigen::Vector3d& centre = shape.ends[0].point_world_m;
  const double closest = (centre - origin).dot(direction);
  const Eigen::Vector3d across = origin - centre + closest * direction;
  const double half_chord_squared = shape.radius_m * shape.radius_m - across.squaredNorm();
  if (half_chord_squared < 0) return;
  const double half_chord = std::sqrt(half_chord_squared);
  for (const double distance : {closest - half_chord, closest + half_chord}) {
    if (!nearest.accepts(distance)) continue;
    nearest.keep(distance, (across + (distance - closest) * direction) / shape.radius_m);
    return;
  }
}

bool within(const RoundShape::End& end, const Eigen::Vector3d& point) {
  return end.outward.dot(point - end.point_world_m) <= kSeam_m;
}

/// Returns false if the ray misses the infinite cylinder, and hence the caps, which are inside it.
bool meet_wall(const RoundShape& shape, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
               Nearest& nearest) {
  const auto off_axis = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d { return v - shape.axis.dot(v) * shape.axis; };
  const Eigen::Vector3d start = off_axis(origin - shape.ends[0].point_world_m), across_axis = off_axis(direction);
  const double sine_squared = across_axis.squaredNorm();
  if (sine_squared < kAlongAxis) return start.norm() <= shape.radius_m + kSeam_m;
  const double closest = -start.dot(across_axis) / sine_squared;
  const Eigen::Vector3d across = start + closest * across_axis;
  const double half_chord_squared = (shape.radius_m * shape.radius_m - across.squaredNorm()) / sine_squared;
  if (half_chord_squared < 0) return false;
  const double half_chord = std::sqrt(half_chord_squared);
  for (const double distance : {closest - half_chord, closest + half_chord}) {
    const Eigen::Vector3d point = origin + distance * direction;
    if (!nearest.accepts(distance) || !within(shape.ends[0], point) || !within(shape.ends[1], point)) continue;
    nearest.keep(distance, (across + (distance - closest) * across_axis) / shape.radius_m);
    break;
  }
  return true;
}

void meet_cap(const RoundShape& shape, std::size_t index, const Eigen::Vector3d& origin,
              const Eigen::Vector3d& direction, Nearest& nearest) {
  const RoundShape::End& end = shape.ends[index];
  if (!end.capped) return;
  const double along = end.outward.dot(direction);
  if (along == 0) return;
  const double distance = end.outward.dot(end.point_world_m - origin) / along;
  if (!nearest.accepts(distance)) return;
  const Eigen::Vector3d point = origin + distance * direction;
  const Eigen::Vector3d from_axis = point - end.point_world_m;
  const double radius_m = (from_axis - shape.axis.dot(from_axis) * shape.axis).norm();
  if (radius_m <= shape.radius_m + kSeam_m && within(shape.ends[1 - index], point)) nearest.keep(distance, end.outward);
}

}  // namespace

RoundShape sphere(const Eigen::Vector3d& centre_world_m, double radius_m) {
  require_round(centre_world_m, radius_m, "sphere");
  const RoundShape::End middle{centre_world_m, Eigen::Vector3d::Zero(), false};
  return {radius_m, {middle, middle}, Eigen::Vector3d::Zero()};
}

RoundShape cylinder(const Eigen::Vector3d& start_world_m, const Eigen::Vector3d& end_world_m, double radius_m) {
  return pipe({start_world_m, end_world_m}, radius_m).front();
}

std::vector<RoundShape> pipe(const std::vector<Eigen::Vector3d>& line_world_m, double radius_m) {
  const std::size_t count = line_world_m.size();
  require(count >= 2, "pipe.points_m", count, "must be at least two points");
  for (const Eigen::Vector3d& point : line_world_m) require_round(point, radius_m, "pipe");
  std::vector<RoundShape> pieces;
  for (std::size_t k = 0; k + 1 < count; ++k) {
    const Eigen::Vector3d &from = line_world_m[k], &to = line_world_m[k + 1];
    const double length = (to - from).norm();
    require(length > 1e-9, "pipe.points_m", from.transpose(), "must not come twice in a row");
    const Eigen::Vector3d axis = (to - from) / length;
    pieces.push_back({radius_m, {{{from, -axis, k == 0}, {to, axis, k + 2 == count}}}, axis});
    if (k == 0) continue;
    RoundShape &before = pieces[k - 1], &after = pieces[k];
    const Eigen::Vector3d middle = (before.axis + after.axis).stableNormalized();
    require(middle.dot(after.axis) > kSharpestCosine, "pipe.points_m", from.transpose(),
            "must not bend by over 168 deg");
    before.ends[1].outward = middle;
    after.ends[0].outward = -middle;
  }
  return pieces;
}

std::optional<ShapeHit> first_hit(const RoundShape& shape, const Eigen::Vector3d& origin_world_m,
                                  const Eigen::Vector3d& direction_world, double near_m, double far_m) {
  Nearest nearest(near_m, far_m);
  if (shape.is_sphere()) {
    meet_sphere(shape, origin_world_m, direction_world, nearest);
  } else if (meet_wall(shape, origin_world_m, direction_world, nearest)) {
    meet_cap(shape, 0, origin_world_m, direction_world, nearest);
    meet_cap(shape, 1, origin_world_m, direction_world, nearest);
  }
  return nearest.hit();
}

double depth_within(const RoundShape& shape, const Eigen::Vector3d& point_world_m) {
  // For a sphere, the vector from its centre
  const Eigen::Vector3d from_end = point_world_m - shape.ends[0].point_world_m;
  double depth = shape.radius_m - (from_end - shape.axis.dot(from_end) * shape.axis).norm();
  if (shape.is_sphere()) return depth;
  for (const RoundShape::End& end : shape.ends) {
    depth = std::min(depth, end.outward.dot(end.point_world_m - point_world_m));
  }
  return depth;
}

ShapeBounds bounds(const RoundShape& shape) {
  ShapeBounds box{shape.ends[0].point_world_m, shape.ends[0].point_world_m};
  for (const RoundShape::End& end : shape.ends) {
    // A mitred end is an ellipse whose tip lies radius / tilt from the end of the axis.
    const double tilt = shape.is_sphere() ? 1 : std::abs(end.outward.dot(shape.axis));
    const Eigen::Vector3d extent = Eigen::Vector3d::Constant(shape.radius_m / tilt + kSeam_m);
    box.low_m = box.low_m.cwiseMin(end.point_world_m - extent);
    box.high_m = box.high_m.cwiseMax(end.point_world_m + extent);
  }
  return box;
}

}  // namespace uwsim
