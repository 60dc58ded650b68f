#include "uwsim/dynamics/surface_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace uwsim {
namespace {

constexpr std::size_t kReserved = 4096;  // triangles, corners or contacts of one piece; further ones allocate
constexpr double kTolerance_m = 1e-9;    // rounding error of positions
constexpr double kCone = 1e-3;           // sine of the angle by which a normal may leave its cone
constexpr double kUpright = 1e-6;        // sine of the slant up to which a drum stands upright
constexpr double kFacesUp = 0.3;         // minimum cosine between the normal of a deep overlap and that of the terrain

bool meets(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& other_low,
           const Eigen::Vector3d& other_high) {
  return (low.array() <= other_high.array()).all() && (other_low.array() <= high.array()).all();
}

/// Whether the triangle's plane counts at a point `gap_m` above it: over the triangle itself, or beyond a concave edge,
/// where both planes count. At a flat edge, the planes' normals may leave a wedge between them.
bool holds_at(const SurfaceTriangle& triangle, const Eigen::Vector3d& point_m, double gap_m, double beyond_hollow_m) {
  for (std::size_t k = 0; k < 3; ++k) {
    const double inside_m = triangle.into[k].dot(point_m - triangle.corners_m[k]);
    double tolerance_m = kTolerance_m;
    if (triangle.bends[k] == Bend::kFlat) tolerance_m += 2 * kFlat * std::abs(gap_m);
    if (triangle.bends[k] == Bend::kConcave) tolerance_m += beyond_hollow_m;
    if (inside_m < -tolerance_m) return false;
  }
  return true;
}

/// The point on a polytope's surface nearest to a point outside it.
Eigen::Vector3d nearest_on_edges(const Polytope& polytope, const Eigen::Vector3d& point_m) {
  double least = std::numeric_limits<double>::infinity();
  Eigen::Vector3d nearest = point_m;
  for (const Polytope::Edge& edge : polytope.edges) {
    const Eigen::Vector3d& from = polytope.corners_m[edge.from];
    const Eigen::Vector3d on_edge = from + std::clamp(edge.along.dot(point_m - from), 0.0, edge.length_m) * edge.along;
    const double distance = (on_edge - point_m).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    nearest = on_edge;
  }
  return nearest;
}

bool is_separated(const Polytope& polytope, const std::array<Eigen::Vector3d, 3>& triangle_m) {
  return std::any_of(polytope.faces.begin(), polytope.faces.end(), [&](const Polytope::Face& face) {
    return std::all_of(triangle_m.begin(), triangle_m.end(),
                       [&](const Eigen::Vector3d& p) { return face.normal.dot(p) > face.offset_m; });
  });
}

}  // namespace

SurfaceContact::SurfaceContact() {
  close_.reserve(kReserved);
  corners_world_m_.reserve(kReserved);
  found_.reserve(kReserved);
}

std::span<const ContactPoint> SurfaceContact::find(const PlacedShape& placed, const SurfacePatch& patch, Under under,
                                                   ContactBudget& budget) {
  placed_ = &placed;
  under_ = under;
  budget_ = &budget;
  found_.clear();
  budget.spend(patch.triangles.size());
  find_close_triangles(patch);
  if (close_.empty()) return found_;
  budget.spend(patch.edges.size() + patch.peaks.size());
  place_corners();
  budget.spend(close_.size() * corners_world_m_.size());
  if (round_ != nullptr && round_->has_flat_ends) {
    for (const SurfaceTriangle* triangle : close_) add_rims(*triangle);
  } else {
    for (const Eigen::Vector3d& corner : corners_world_m_) add_corner(corner);
  }
  for (const SurfacePeak& peak : patch.peaks) add_peak(patch, peak);
  for (const SurfaceEdge& edge : patch.edges) add_edge(edge);
  if (round_ != nullptr && !found_.empty()) return found_;
  for (const SurfaceTriangle* triangle : close_) add_deep_overlap(*triangle);
  return found_;
}

/// Those of the polytope; the ends of the axis of a ball and of a rod with round ends.
void SurfaceContact::place_corners() {
  const auto in_world = [&](const Eigen::Vector3d& point) -> Eigen::Vector3d {
    return placed_->world_from_body.position_m + placed_->rotation * point;
  };
  corners_world_m_.clear();
  corner_radius_m_ = 0;
  const std::optional<RoundPiece>& round = placed_->shape.round_body();
  round_ = round ? &*round : nullptr;
  if (round_ != nullptr) {
    half_length_m_ = round_->half_axis_m.norm();
    middle_world_m_ = in_world(round_->middle_m);
    axis_world_ = half_length_m_ > 0 ? Eigen::Vector3d(placed_->rotation * round_->half_axis_m / half_length_m_)
                                     : Eigen::Vector3d::Zero();
    if (!round_->has_flat_ends) {
      corner_radius_m_ = round_->radius_m;
      corners_world_m_.emplace_back(middle_world_m_ - half_length_m_ * axis_world_);
      if (half_length_m_ > 0) corners_world_m_.emplace_back(middle_world_m_ + half_length_m_ * axis_world_);
      return;
    }
  }
  for (const Eigen::Vector3d& corner : placed_->shape.polytope_body().corners_m)
    corners_world_m_.push_back(in_world(corner));
}

void SurfaceContact::add_corner(const Eigen::Vector3d& corner_m) {
  if (under_ == Under::kSolid) {
    add_corner_on_terrain(corner_m);
  } else {
    add_corner_at_solid(corner_m);
  }
}

/// The lowest point of each rim over the triangle, and three more of the lower one, on which a drum stands.
void SurfaceContact::add_rims(const SurfaceTriangle& triangle) {
  const double rise = axis_world_.dot(triangle.normal);
  Eigen::Vector3d down = rise * axis_world_ - triangle.normal;
  const double slant = down.norm();
  down = slant > kUpright ? Eigen::Vector3d(down / slant)
                          : Eigen::Vector3d(placed_->rotation * round_->half_axis_m.unitOrthogonal());
  const Eigen::Vector3d aside = axis_world_.cross(down);
  for (const double end : {-1.0, 1.0}) {
    const Eigen::Vector3d centre = middle_world_m_ + end * half_length_m_ * axis_world_;
    const bool is_lower = end * rise < 0;
    const std::array<Eigen::Vector3d, 4> out = {down, aside, -aside, -down};
    for (const Eigen::Vector3d& way : std::span(out).first(is_lower ? 4 : 1)) {
      const Eigen::Vector3d point = centre + round_->radius_m * way;
      const double gap_m = triangle.normal.dot(point) - triangle.offset_m;
      if (gap_m > placed_->reach_m) continue;
      if (under_ == Under::kSolid) {
        add_corner_over(triangle, point);
      } else if (gap_m >= -placed_->reach_m && holds_at(triangle, point, gap_m, placed_->reach_m)) {
        add_corner_at_solid(point);
      }
    }
  }
}

void SurfaceContact::find_close_triangles(const SurfacePatch& patch) {
  close_.clear();
  const Eigen::Vector3d low = placed_->low_m;
  Eigen::Vector3d high = placed_->high_m;
  if (under_ == Under::kSolid) high.z() = std::numeric_limits<double>::infinity();
  for (const SurfaceTriangle& triangle : patch.triangles) {
    if (meets(low, high, triangle.low_m, triangle.high_m) && lowest_over(triangle) <= placed_->reach_m)
      close_.push_back(&triangle);
  }
}

/// The smallest height of the piece's box above the triangle's plane.
double SurfaceContact::lowest_over(const SurfaceTriangle& triangle) const {
  const Eigen::Vector3d normal_body = placed_->rotation.transpose() * triangle.normal;
  return triangle.normal.dot(placed_->world_from_body.position_m) - triangle.offset_m +
         normal_body.dot(placed_->middle_m) - normal_body.cwiseAbs().dot(placed_->half_size_m);
}

void SurfaceContact::add_above(const SurfaceTriangle& triangle, const Eigen::Vector3d& corner_m, double height_m) {
  found_.push_back({corner_m - height_m * triangle.normal, triangle.normal, height_m - corner_radius_m_});
}

void SurfaceContact::add_corner_on_terrain(const Eigen::Vector3d& corner_m) {
  for (const SurfaceTriangle* triangle : close_) add_corner_over(*triangle, corner_m);
}

/// A corner below the terrain touches the triangle above it, at any depth.
void SurfaceContact::add_corner_over(const SurfaceTriangle& triangle, const Eigen::Vector3d& corner_m) {
  const double height_m = triangle.normal.dot(corner_m) - triangle.offset_m;
  if (height_m - corner_radius_m_ > placed_->reach_m) return;
  if (height_m >= 0) {
    if (holds_at(triangle, corner_m, height_m, placed_->reach_m)) add_above(triangle, corner_m, height_m);
    return;
  }
  const Eigen::Vector3d above = corner_m - height_m / triangle.normal.z() * Eigen::Vector3d::UnitZ();
  if (holds_at(triangle, above, 0, 0)) add_above(triangle, corner_m, height_m);
}

/// A corner inside a solid is pushed out through the nearest triangle; a corner outside touches all nearby triangles.
void SurfaceContact::add_corner_at_solid(const Eigen::Vector3d& corner_m) {
  const double reach_m = placed_->reach_m + corner_radius_m_;
  const SurfaceTriangle* nearest = nullptr;
  double nearest_height_m = 0;
  for (const SurfaceTriangle* triangle : close_) {
    const double height_m = triangle->normal.dot(corner_m) - triangle->offset_m;
    if (std::abs(height_m) > reach_m || !holds_at(*triangle, corner_m, height_m, 0)) continue;
    if (nearest != nullptr && std::abs(height_m) >= std::abs(nearest_height_m)) continue;
    nearest = triangle;
    nearest_height_m = height_m;
  }
  if (nearest != nullptr && nearest_height_m < 0) return add_above(*nearest, corner_m, nearest_height_m);
  for (const SurfaceTriangle* triangle : close_) {
    const double height_m = triangle->normal.dot(corner_m) - triangle->offset_m;
    if (height_m < 0 || height_m > reach_m) continue;
    if (holds_at(*triangle, corner_m, height_m, placed_->reach_m)) add_above(*triangle, corner_m, height_m);
  }
}

/// A peak touches the wall of a round piece, or the nearest face, edge or corner of the polytope.
void SurfaceContact::add_peak(const SurfacePatch& patch, const SurfacePeak& peak) {
  if (!meets(placed_->low_m, placed_->high_m, peak.point_m, peak.point_m)) return;
  if (round_ != nullptr && add_wall_at_peak(patch, peak)) return;
  const Polytope& polytope = placed_->shape.polytope_body();
  budget_->spend(polytope.faces.size());
  const auto height_over = [](const Polytope::Face& face, const Eigen::Vector3d& point) {
    return face.normal.dot(point) - face.offset_m;
  };
  const Eigen::Vector3d point = placed_->rotation.transpose() * (peak.point_m - placed_->world_from_body.position_m);
  const Polytope::Face* face = nullptr;
  double gap_m = -std::numeric_limits<double>::infinity();
  for (const Polytope::Face& candidate : polytope.faces) {
    const double height_m = height_over(candidate, point);
    if (height_m <= gap_m) continue;
    face = &candidate;
    gap_m = height_m;
  }
  if (face == nullptr || std::abs(gap_m) > placed_->reach_m) return;
  Eigen::Vector3d normal_body = -face->normal;
  const Eigen::Vector3d foot = point - gap_m * face->normal;
  const bool beside_face = std::any_of(polytope.faces.begin(), polytope.faces.end(), [&](const Polytope::Face& other) {
    return height_over(other, foot) > kTolerance_m;
  });
  if (gap_m > 0 && beside_face) {
    const Eigen::Vector3d way = nearest_on_edges(polytope, point) - point;
    gap_m = way.norm();
    normal_body = way / gap_m;
  }
  if (!(gap_m <= placed_->reach_m)) return;
  add_touching_peak(patch, peak, placed_->rotation * normal_body, gap_m);
}

/// Returns false if it is a flat end of the piece that is nearest.
bool SurfaceContact::add_wall_at_peak(const SurfacePatch& patch, const SurfacePeak& peak) {
  const double along_m = axis_world_.dot(peak.point_m - middle_world_m_);
  const double within_m = std::clamp(along_m, -half_length_m_, half_length_m_);
  const Eigen::Vector3d way = middle_world_m_ + within_m * axis_world_ - peak.point_m;
  const double distance_m = way.norm(), gap_m = distance_m - round_->radius_m;
  if (round_->has_flat_ends && (within_m != along_m || std::abs(along_m) - half_length_m_ > gap_m)) return false;
  if (std::abs(gap_m) <= placed_->reach_m && distance_m > kTolerance_m)
    add_touching_peak(patch, peak, way / distance_m, gap_m);
  return true;
}

/// The normal must lie in the peak's cone.
void SurfaceContact::add_touching_peak(const SurfacePatch& patch, const SurfacePeak& peak,
                                       const Eigen::Vector3d& normal, double gap_m) {
  for (std::uint32_t k = 0; k < peak.neighbour_count; ++k) {
    const Eigen::Vector3d way = patch.neighbours_m[peak.first_neighbour + k] - peak.point_m;
    if (normal.dot(way) > kCone * way.norm()) return;
  }
  found_.push_back({peak.point_m, normal, gap_m});
}

void SurfaceContact::add_edge(const SurfaceEdge& edge) {
  const Eigen::Vector3d to = edge.from_m + edge.length_m * edge.along;
  if (!meets(placed_->low_m, placed_->high_m, edge.from_m.cwiseMin(to), edge.from_m.cwiseMax(to))) return;
  budget_->spend(corners_world_m_.size());
  // No part of the piece is near unless its support along the edge's mean normal is.
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& corner : corners_world_m_)
    lowest_m = std::min(lowest_m, edge.middle_normal.dot(corner - edge.from_m));
  if (lowest_m - (round_ != nullptr ? round_->radius_m : 0) > placed_->reach_m) return;

  for (const Eigen::Vector3d& corner : corners_world_m_) {
    const double along_m = edge.along.dot(corner - edge.from_m);
    if (along_m < 0 || along_m > edge.length_m) continue;
    const Eigen::Vector3d foot = edge.from_m + along_m * edge.along, way = corner - foot;
    const double distance_m = way.norm(), gap_m = distance_m - corner_radius_m_;
    if (gap_m > placed_->reach_m || distance_m < kTolerance_m) continue;
    if (edge.into[0].dot(way) <= 0 && edge.into[1].dot(way) <= 0) found_.push_back({foot, way / distance_m, gap_m});
  }
  if (round_ != nullptr) add_wall_at_edge(edge);
  if (round_ != nullptr && !round_->has_flat_ends) return;

  const Eigen::Matrix3d body_from_world = placed_->rotation.transpose();
  const Eigen::Vector3d from = body_from_world * (edge.from_m - placed_->world_from_body.position_m);
  const Eigen::Vector3d along = body_from_world * edge.along;
  const Eigen::Vector3d into[] = {body_from_world * edge.into[0], body_from_world * edge.into[1]};
  const Polytope& polytope = placed_->shape.polytope_body();
  budget_->spend(polytope.edges.size());
  for (const Polytope::Edge& other : polytope.edges) {
    Eigen::Vector3d across = along.cross(other.along);
    const double side[] = {across.dot(other.into[0]), across.dot(other.into[1])};
    // Rejects most edges at little cost
    if (std::min(side[0], side[1]) < -kCone && std::max(side[0], side[1]) > kCone) continue;
    const double sine = across.norm();
    if (sine < kCone) continue;  // parallel edges: their corners touch instead
    if (round_ != nullptr && std::abs(other.along.dot(round_->half_axis_m)) > half_length_m_ / 2) continue;  // the wall
    const double tolerance = kCone * sine;
    if (side[0] <= tolerance && side[1] <= tolerance) {
      across = -across;
    } else if (side[0] < -tolerance || side[1] < -tolerance) {
      continue;  // the piece is on both sides
    }
    if (across.dot(into[0]) > tolerance || across.dot(into[1]) > tolerance) continue;
    const Eigen::Vector3d normal = across / sine;
    const Eigen::Vector3d between = polytope.corners_m[other.from] - from;
    const double gap_m = normal.dot(between);
    if (std::abs(gap_m) > placed_->reach_m) continue;
    // Both lines lie in the plane perpendicular to the normal: they cross at `at_m` along ours and `other_at_m` along
    // the other.
    const Eigen::Vector3d cross = along.cross(other.along);
    const double at_m = between.cross(other.along).dot(cross) / (sine * sine);
    const double other_at_m = between.cross(along).dot(cross) / (sine * sine);
    const bool crosses = at_m >= -kTolerance_m && at_m <= edge.length_m + kTolerance_m && other_at_m >= -kTolerance_m &&
                         other_at_m <= other.length_m + kTolerance_m;
    if (crosses) found_.push_back({edge.from_m + at_m * edge.along, placed_->rotation * normal, gap_m});
  }
}

/// Where the axis of a round piece passes the edge between its ends.
void SurfaceContact::add_wall_at_edge(const SurfaceEdge& edge) {
  const Eigen::Vector3d cross = edge.along.cross(axis_world_);
  const double sine = cross.norm();
  if (sine < kCone) return;  // parallel to the edge, or a ball: corners and triangles touch instead
  const Eigen::Vector3d between = middle_world_m_ - edge.from_m;
  const double at_m = between.cross(axis_world_).dot(cross) / (sine * sine);
  const double axis_at_m = between.cross(edge.along).dot(cross) / (sine * sine);
  if (at_m < 0 || at_m > edge.length_m || std::abs(axis_at_m) > half_length_m_) return;
  const double side_m = between.dot(cross) / sine, gap_m = std::abs(side_m) - round_->radius_m;
  const Eigen::Vector3d normal = cross / (side_m > 0 ? sine : -sine);
  if (std::abs(gap_m) > placed_->reach_m || edge.into[0].dot(normal) > kCone || edge.into[1].dot(normal) > kCone)
    return;
  found_.push_back({edge.from_m + at_m * edge.along, normal, gap_m});
}

void SurfaceContact::add_deep_overlap(const SurfaceTriangle& triangle) {
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(placed_->reach_m);
  if (lowest_over(triangle) >= -placed_->reach_m ||
      !meets(placed_->low_m + reach, placed_->high_m - reach, triangle.low_m, triangle.high_m))
    return;
  std::array<Eigen::Vector3d, 3> in_body;
  for (std::size_t k = 0; k < 3; ++k)
    in_body[k] = placed_->rotation.transpose() * (triangle.corners_m[k] - placed_->world_from_body.position_m);
  budget_->spend(placed_->shape.polytope_body().faces.size());
  if (is_separated(placed_->shape.polytope_body(), in_body)) return;
  budget_->spend(ContactBudget::kTestsPerOverlap);
  for (const ContactPoint& found :
       convex_contact_.with_triangle(placed_->shape, placed_->world_from_body, triangle.corners_m, 0)) {
    if (found.distance_m >= -placed_->reach_m) continue;
    if (under_ == Under::kClosed || found.normal_world.dot(triangle.normal) >= kFacesUp) found_.push_back(found);
  }
}

}  // namespace uwsim
