#include "uwsim/dynamics/tether_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

constexpr double kTiny_m = 1e-9, kSame_m = 1e-3, kSameWay = 0.9999, kConeSine = 1e-3;
constexpr double kOnHull_m = 0.05;  // a tether that is fastened no deeper is fastened on the hull
constexpr int kCuts = 24;
constexpr std::size_t kKeptTriangles = 256;  // of a solid near an element; a step that needs more allocates

/// The points of two segments that are closest to each other, as shares of their lengths.
std::pair<double, double> closest(const Eigen::Vector3d& from, const Eigen::Vector3d& way, const Eigen::Vector3d& from2,
                                  const Eigen::Vector3d& way2) {
  const Eigen::Vector3d between = from - from2;
  const double a = way.squaredNorm(), b = way.dot(way2), e = way2.squaredNorm();
  const double c = way.dot(between), f = way2.dot(between), area = a * e - b * b;
  double s = area > 1e-12 * a * e ? std::clamp((b * f - c * e) / area, 0.0, 1.0) : 0.5;
  const double t = std::clamp((b * s + f) / e, 0.0, 1.0);
  s = std::clamp((b * t - c) / a, 0.0, 1.0);
  return {s, std::clamp((b * s + f) / e, 0.0, 1.0)};
}

/// The greatest height of a point over a face of a polytope, negative inside, and that face.
std::pair<double, const Polytope::Face*> height_over(const Polytope& piece, const Eigen::Vector3d& point) {
  std::pair<double, const Polytope::Face*> highest = {-1e300, nullptr};
  for (const Polytope::Face& face : piece.faces) {
    const double height = face.normal.dot(point) - face.offset_m;
    if (height > highest.first) highest = {height, &face};
  }
  return highest;
}

bool is_over(const SurfaceTriangle& triangle, const Eigen::Vector3d& point) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (triangle.into[k].dot(point - triangle.corners_m[k]) < -kTiny_m) return false;
  }
  return true;
}

/// True if a segment passes through a triangle (Moeller and Trumbore 1997).
bool passes(const Eigen::Vector3d& from, const Eigen::Vector3d& way, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
            const Eigen::Vector3d& c) {
  const Eigen::Vector3d one = b - a, two = c - a, across = way.cross(two);
  const double volume = one.dot(across);
  if (std::abs(volume) < 1e-300) return false;
  const Eigen::Vector3d to = from - a;
  const double u = to.dot(across) / volume;
  const Eigen::Vector3d turned = to.cross(one);
  const double v = way.dot(turned) / volume, t = two.dot(turned) / volume;
  return u >= 0 && v >= 0 && u + v <= 1 && t >= 0 && t <= 1;
}

}  // namespace

TetherContactFinder::TetherContactFinder(const World& world, const TetherSpec& spec, std::span<const MovedBody> bodies)
    : fixed_(fixed_surfaces(world)), spec_(spec), stack_(std::make_shared<SolidTriangles::Stack>()) {
  for (std::size_t k = 0; k < std::min<std::size_t>(2, world.solids().size()); ++k)
    patches_.emplace_back().reserve(kKeptTriangles);
  set_bodies(bodies);
}

void TetherContactFinder::set_bodies(std::span<const MovedBody> bodies) {
  hulls_.clear();
  for (const MovedBody& body : bodies) hulls_.push_back(convex_body(body.spec.collision_pieces_body_m));
  const TetherEnd* const ends[] = {&spec_.first, &spec_.second};
  for (std::size_t k = 0; k < 2; ++k) {
    own_m_[k] = 0;
    if (ends[k]->body >= hulls_.size()) continue;
    double height_m = 1e300;
    for (const ConvexBody::Piece& piece : hulls_[ends[k]->body]->pieces)
      height_m = std::min(height_m, height_over(piece.shape.polytope_body(), ends[k]->point_m).first);
    if (height_m < -kOnHull_m) own_m_[k] = hulls_[ends[k]->body]->radius_m + ends[k]->point_m.norm();
  }
}

bool TetherContactFinder::may_touch(const WorldBox& box) const {
  return fixed_->has_solids() && fixed_->may_touch(box.low_m, box.high_m);
}

std::string TetherContactFinder::crossed(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const {
  const WorldBox box{from_m.cwiseMin(to_m), from_m.cwiseMax(to_m)};
  for (const auto& solid : fixed_->world.solids()) {
    if (!box.meets({solid->low_world_m, solid->high_world_m})) continue;
    const auto& corners = solid->mesh_world.vertices_m;
    for (const Triangle& t : solid->mesh_world.triangles) {
      if (passes(from_m, to_m - from_m, corners[t[0]], corners[t[1]], corners[t[2]])) return solid->name;
    }
  }
  return "";
}

bool TetherContactFinder::crosses_cover(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const {
  const WorldBox box{from_m.cwiseMin(to_m), from_m.cwiseMax(to_m)};
  if (!fixed_->cover || !fixed_->may_touch(box.low_m, box.high_m)) return false;
  bool found = false;
  fixed_->cover->visit(box.low_m, box.high_m, [&](const Corners& triangle) {
    found = found || passes(from_m, to_m - from_m, triangle[0], triangle[1], triangle[2]);
  });
  return found;
}

Eigen::Vector3d TetherContactFinder::point(std::size_t element, double share) const {
  return (1 - share) * line_.points_m[element] + share * line_.points_m[element + 1];
}

bool TetherContactFinder::owns_end(std::size_t element) const {
  return element + 2 == line_.points_m.size() || line_.broken == element + 1;
}

/// The elements' box, with their reach.
WorldBox TetherContactFinder::box_of(std::size_t first, std::size_t last) const {
  Eigen::Vector3d low = line_.points_m[first], high = low;
  double reach_m = 0;
  for (std::size_t i = first; i <= last; ++i) {
    low = low.cwiseMin(line_.points_m[i + 1]);
    high = high.cwiseMax(line_.points_m[i + 1]);
    reach_m = std::max(reach_m, line_.reach_m[i]);
  }
  return {low.array() - reach_m, high.array() + reach_m};
}

void TetherContactFinder::find(const TetherLine& line, std::span<const MovedBody> bodies,
                               std::vector<TetherContact>& contacts) {
  line_ = line;
  contacts_ = &contacts;
  contacts.clear();
  budget_.begin(0, Eigen::Vector3d::Constant(spec_.diameter_m));
  const WorldBox whole = box_of(0, line.points_m.size() - 2);
  if (may_touch(whole)) find_solids(whole);
  find_hulls(whole, bodies);
}

void TetherContactFinder::find_solids(const WorldBox& whole) {
  const auto near = [](const WorldBox& box, const Solid& solid) {
    return box.meets({solid.low_world_m, solid.high_world_m});
  };
  const auto& solids = fixed_->world.solids();
  if (!fixed_->cover && std::ranges::none_of(solids, [&](const auto& solid) { return near(whole, *solid); })) return;
  for (std::size_t i = 0; i + 1 < line_.points_m.size(); ++i) {
    if (i == line_.broken) continue;
    const WorldBox box = box_of(i, i);
    if (!fixed_->may_touch(box.low_m, box.high_m)) continue;
    const std::size_t count = fixed_->find(box.low_m, box.high_m, *stack_, patches_, budget_);
    for (std::size_t k = 0; k < count; ++k) {
      const SurfacePatch& patch = patches_[k];
      meet_node(i, 0, patch);
      if (owns_end(i)) meet_node(i, 1, patch);
      if ((line_.points_m[i + 1] - line_.points_m[i]).norm() < kTiny_m) continue;
      for (const SurfaceEdge& edge : patch.edges) meet_edge(i, edge);
      for (const SurfacePeak& peak : patch.peaks) meet_peak(i, patch, peak);
    }
  }
}

/// A node inside a solid is pushed out through the nearest triangle; one outside meets all near triangles.
void TetherContactFinder::meet_node(std::size_t element, double share, const SurfacePatch& patch) {
  const Eigen::Vector3d at = point(element, share);
  const double reach_m = line_.reach_m[element];
  const SurfaceTriangle* nearest = nullptr;
  double nearest_m = reach_m;
  for (const SurfaceTriangle& triangle : patch.triangles) {
    const double gap_m = triangle.normal.dot(at) - triangle.offset_m;
    if (std::abs(gap_m) > std::abs(nearest_m) || !is_over(triangle, at)) continue;
    nearest = &triangle;
    nearest_m = gap_m;
  }
  if (nearest == nullptr) return;
  if (nearest_m < 0) return add(element, share, at - nearest_m * nearest->normal, nearest->normal);
  for (const SurfaceTriangle& triangle : patch.triangles) {
    const double gap_m = triangle.normal.dot(at) - triangle.offset_m;
    if (gap_m < 0 || gap_m > reach_m || !is_over(triangle, at)) continue;
    add(element, share, at - gap_m * triangle.normal, triangle.normal);
  }
}

void TetherContactFinder::meet_edge(std::size_t element, const SurfaceEdge& edge) {
  const Eigen::Vector3d& from = line_.points_m[element];
  const Eigen::Vector3d way = line_.points_m[element + 1] - from;
  const auto [share, along] = closest(from, way, edge.from_m, edge.length_m * edge.along);
  if (along <= 0 || along >= 1 || (share >= 1 && !owns_end(element))) return;
  const Eigen::Vector3d foot = edge.from_m + along * edge.length_m * edge.along;
  const Eigen::Vector3d off = from + share * way - foot;
  const double gap_m = off.norm();
  if (gap_m > line_.reach_m[element]) return;
  if (gap_m < kTiny_m) return add(element, share, foot, edge.middle_normal);
  const double one = edge.into[0].dot(off), two = edge.into[1].dot(off), tolerance = kTiny_m;
  if (one <= tolerance && two <= tolerance) {
    add(element, share, foot, off / gap_m);
  } else if (one > 0 && two > 0) {
    add(element, share, foot, -off / gap_m);  // it has passed into the solid
  }
}

void TetherContactFinder::meet_peak(std::size_t element, const SurfacePatch& patch, const SurfacePeak& peak) {
  const Eigen::Vector3d& from = line_.points_m[element];
  const Eigen::Vector3d way = line_.points_m[element + 1] - from;
  const double share = std::clamp(way.dot(peak.point_m - from) / way.squaredNorm(), 0.0, 1.0);
  if (share >= 1 && !owns_end(element)) return;
  const Eigen::Vector3d off = from + share * way - peak.point_m;
  const double gap_m = off.norm();
  if (gap_m > line_.reach_m[element] || gap_m < kTiny_m) return;
  const Eigen::Vector3d normal = off / gap_m;
  for (std::uint32_t k = 0; k < peak.neighbour_count; ++k) {
    const Eigen::Vector3d side = patch.neighbours_m[peak.first_neighbour + k] - peak.point_m;
    if (normal.dot(side) > kConeSine * side.norm()) return;
  }
  add(element, share, peak.point_m, normal);
}

bool TetherContactFinder::is_own(std::size_t element, std::uint64_t body) const {
  const std::size_t last = line_.points_m.size() - 2;
  if (body == spec_.first.body && (element == 0 || line_.from_m[element] < own_m_[0])) return true;
  return body == spec_.second.body &&
         (element == last || line_.from_m[last + 1] - line_.from_m[element + 1] < own_m_[1]);
}

void TetherContactFinder::find_hulls(const WorldBox& whole, std::span<const MovedBody> bodies) {
  for (std::size_t b = 0; b < hulls_.size(); ++b) {
    const MovedBody& moved = bodies[b];
    const ConvexBody& hull = *hulls_[b];
    const Eigen::Vector3d& middle = moved.state.world_from_body.position_m;
    if (moved.held || !whole.meets({middle.array() - hull.radius_m, middle.array() + hull.radius_m})) continue;
    for (std::size_t i = 0; i + 1 < line_.points_m.size(); ++i) {
      if (i == line_.broken || is_own(i, b)) continue;
      const double near_m = (line_.points_m[i + 1] - line_.points_m[i]).norm() + hull.radius_m + line_.reach_m[i];
      if ((line_.points_m[i] - middle).squaredNorm() > near_m * near_m) continue;
      for (const ConvexBody::Piece& piece : hull.pieces) meet_piece(i, piece.shape.polytope_body(), b, moved);
    }
  }
}

/// The height over the piece's faces is convex along the element: Kelley's cutting planes find where it is least.
/// There, the normal is the combination of the two faces' that is perpendicular to the element.
void TetherContactFinder::meet_piece(std::size_t element, const Polytope& piece, std::uint64_t body,
                                     const MovedBody& moved) {
  const Pose& pose = moved.state.world_from_body;
  const Eigen::Matrix3d rotation = pose.rotation();
  const Eigen::Vector3d from = rotation.transpose() * (line_.points_m[element] - pose.position_m);
  const Eigen::Vector3d way = rotation.transpose() * (line_.points_m[element + 1] - line_.points_m[element]);
  const double reach_m = line_.reach_m[element];
  const auto touch = [&](double share, double height_m, const Eigen::Vector3d& normal) {
    if (height_m > reach_m) return;
    const Eigen::Vector3d at = from + share * way - height_m * normal;
    const BodyState& state = moved.state;
    add(element, share, pose.position_m + rotation * at, rotation * normal,
        line_.step_s * rotation * (state.linear_body_m_s() + state.angular_body_rad_s().cross(at)), body);
  };
  auto [low_m, low] = height_over(piece, from);
  auto [high_m, high] = height_over(piece, from + way);
  touch(0, low_m, low->normal);
  if (owns_end(element)) touch(1, high_m, high->normal);
  double start = 0, end = 1;
  for (int cut = 0; cut < kCuts; ++cut) {
    const double down = low->normal.dot(way), up = high->normal.dot(way);
    if (down >= 0 || up <= 0) return;
    const double share = (low_m - high_m - down * start + up * end) / (up - down);
    const double bound_m = low_m + down * (share - start);
    if (bound_m > reach_m) return;
    const auto [height_m, face] = height_over(piece, from + share * way);
    if (height_m - bound_m < kTiny_m) {
      const Eigen::Vector3d mixed = (up * low->normal - down * high->normal) / (up - down);
      const double length = mixed.norm();
      if (length > kConeSine && share > 0 && share < 1) touch(share, height_m / length, mixed / length);
      return;
    }
    if (face->normal.dot(way) < 0) {
      low = face, low_m = height_m, start = share;
    } else {
      high = face, high_m = height_m, end = share;
    }
  }
}

/// Keeps the nearest of several contacts at the same place of an element.
void TetherContactFinder::add(std::size_t element, double share, const Eigen::Vector3d& point_m,
                              const Eigen::Vector3d& normal, const Eigen::Vector3d& moves_m, std::uint64_t body) {
  const Eigen::Vector3d at = point(element, share);
  for (auto known = contacts_->rbegin(); known != contacts_->rend(); ++known) {
    if (known->element != element || known->body != body) break;
    if (known->normal_world.dot(normal) < kSameWay || (point(element, known->share) - at).norm() > kSame_m) continue;
    if (normal.dot(at - point_m) >= normal.dot(at - known->point_world_m)) return;
    known->share = share;
    known->point_world_m = point_m;
    known->normal_world = normal;
    return;
  }
  TetherContact& made = contacts_->emplace_back();
  made.element = element;
  made.share = share;
  made.point_world_m = point_m;
  made.normal_world = normal;
  made.moves_m = moves_m;
  made.body = body;
}

}  // namespace uwsim
