#include "uwsim/world/tile_surfaces.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace uwsim {
namespace {

constexpr double kFloatError = 1e-6;  // of half the tile's diagonal: some sixteen units in the last place
constexpr double kLeastReach_m = 1e-8;
constexpr double kSharpest = 8;   // how many times the rim a corner may move
constexpr double kWithin = 1e-9;  // cells: what double leaves open
constexpr double kCrossing = 16;  // times the reach, within which surfaces count as near each other

Eigen::AlignedBox3d box_of(const RoundShape& shape) {
  const ShapeBounds limits = bounds(shape);
  return {limits.low_m, limits.high_m};
}

Eigen::AlignedBox3d box_of(const Corners& triangle) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& corner : triangle) box.extend(corner);
  return box;
}

/// Whether the box comes within `room` of the endless cylinder (or the sphere) that the shape is a piece of.
bool may_touch(const RoundShape& shape, const Eigen::AlignedBox3d& box, double room) {
  const Eigen::Vector3d from = box.center() - shape.ends[0].point_world_m;
  const double away = (from - shape.axis.dot(from) * shape.axis).norm();
  return away <= shape.radius_m + 0.5 * box.diagonal().norm() + room;
}

Corners solid_corners(const Solid& solid, std::uint32_t triangle) {
  const Triangle& t = solid.mesh_world.triangles[triangle];
  const auto& v = solid.mesh_world.vertices_m;
  return {v[t[0]], v[t[1]], v[t[2]]};
}

/// Sharper than 14 degrees: there, moving the edges outward would move the corner far.
bool has_sharp_corner(const Corners& triangle) {
  const auto side = [&](std::size_t k) { return (triangle[(k + 1) % 3] - triangle[k % 3]).stableNormalized(); };
  const auto is_sharp = [&](std::size_t k) { return 0.5 * (side(k) + side(k + 2)).norm() * kSharpest < 1; };
  return is_sharp(0) || is_sharp(1) || is_sharp(2);
}

}  // namespace

std::optional<TileHit> meet_triangle(const Corners& triangle, const TileRay& ray, double reach_m) {
  const Eigen::Vector3d ab = triangle[1] - triangle[0], ac = triangle[2] - triangle[0];
  const Eigen::Vector3d normal = ab.cross(ac);
  const double along = normal.dot(ray.direction_world);
  if (along == 0) return {};
  const Eigen::Vector3d from_a = ray.origin_world_m - triangle[0];
  const Eigen::Vector3d turn = ray.direction_world.cross(from_a);
  const double u = ac.dot(turn) / along, v = -ab.dot(turn) / along, w = 1 - u - v;
  if (!(u >= -kSeam && v >= -kSeam && w >= -kSeam)) return {};
  const double area = normal.norm();
  const bool clear =
      u * area > reach_m * ac.norm() && v * area > reach_m * ab.norm() && w * area > reach_m * (ac - ab).norm();
  return TileHit{-normal.dot(from_a) / along, normal / area, clear};
}

Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Corners& triangle) {
  const auto& [a, b, c] = triangle;
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return a + d1 / (d1 - d3) * ab;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  const double along_bc = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 >= d3 && d5 >= d6 && along_bc > 0) return b + (d4 - d3) / along_bc * (c - b);
  const double whole = va + vb + vc;
  return whole > 0 ? Eigen::Vector3d(a + (vb * ab + vc * ac) / whole) : a;
}

/// A triangle that holds one with a corner so sharp that moving its edges outward would move the corner far: of the
/// longest edge a to b the line moves out by the rim; the other two go round the corners, farther than need be.
Corners widened_sharp(const Corners& triangle, double rim_m) {
  std::size_t first = 0;
  const auto length = [&](std::size_t k) { return (triangle[(k + 1) % 3] - triangle[k % 3]).squaredNorm(); };
  for (const std::size_t k : {1, 2}) first = length(k) > length(first) ? k : first;
  const Eigen::Vector3d &a = triangle[first], &b = triangle[(first + 1) % 3], &c = triangle[(first + 2) % 3];
  const Eigen::Vector3d along = (b - a).stableNormalized(), up = (c - a) - along.dot(c - a) * along;
  const Eigen::Vector3d across = up.stableNormalized();
  const double height = up.norm(), apex = height + 4 * rim_m, foot = std::max(0.0, along.dot(c - a));
  const auto beyond = [&](double to_foot) {
    return std::max(rim_m * (2 * to_foot + height + 5 * rim_m) / (height + 3 * rim_m), 0.5 * (apex + rim_m));
  };
  Corners wide;
  wide[first] = a - beyond(foot) * along - rim_m * across;
  wide[(first + 1) % 3] = b + beyond(std::max(0.0, (b - a).norm() - foot)) * along - rim_m * across;
  wide[(first + 2) % 3] = a + foot * along + apex * across;
  return wide;
}

Corners widened(const Corners& triangle, double rim_m) {
  if (has_sharp_corner(triangle)) return widened_sharp(triangle, rim_m);
  Corners wide = triangle;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d one = (triangle[(k + 1) % 3] - triangle[k]).stableNormalized();
    const Eigen::Vector3d two = (triangle[(k + 2) % 3] - triangle[k]).stableNormalized();
    const Eigen::Vector3d inward = one + two;
    const double sine = 0.5 * (one - two).norm(), cosine = 0.5 * inward.norm();  // of half the corner's angle
    if (cosine < 1e-9) continue;
    wide[k] -= rim_m / sine * inward / (2 * cosine);
  }
  return wide;
}

TileSurfaces::TileSurfaces(const World& world, TileContents contents)
    : world_(world), contents_(std::move(contents)), share_of_geometry_(world.solids().size() + kTerrain + 1, -1) {
  for (std::size_t k = 0; k < contents_.solids.size(); ++k) {
    share_of_geometry_[contents_.solids[k].label] = static_cast<std::int32_t>(k);
  }
  whole_terrain_ = world_.terrain() && contents_.columns == world_.terrain()->nx() - 1 &&
                   contents_.rows == world_.terrain()->ny() - 1;
  measure();
  find_crossings();
}

void TileSurfaces::measure() {
  for (std::uint32_t j = 0; contents_.columns > 0 && j <= contents_.rows; ++j) {
    for (std::uint32_t i = 0; i <= contents_.columns; ++i) {
      box_.extend(
          world_.terrain()->vertex((contents_.first_row + j) * world_.terrain()->nx() + contents_.first_column + i));
      if (i < contents_.columns && j < contents_.rows) {
        steepest_ = std::max({steepest_, steepness(i, j, 1), steepness(i + 1, j + 1, -1)});
      }
    }
  }
  for (const TileContents::Share& share : contents_.solids) {
    for (std::uint32_t k = 0; k < share.members.size(); ++k) {
      box_.extend(is_round(share.label) ? box_of(shape(share.label, k)) : box_of(corners(share.label, k)));
    }
  }
  for (const TileContents::Share& share : contents_.meshes) {
    for (const std::uint32_t t : share.members) {
      box_.extend(box_of(solid_corners(*world_.solids()[share.label - kTerrain - 1], t)));
    }
  }
  middle_m_ = box_.center();
  diagonal_m_ = box_.diagonal().norm();
  reach_m_ = std::max(kLeastReach_m, kFloatError * 0.5 * diagonal_m_);
  const auto has_triangles = [&](const TileContents::Share& share) { return !is_round(share.label); };
  back_m_ = std::ranges::any_of(contents_.solids, has_triangles) ? kBack * reach_m_ : 0;
  box_.min().array() -= 2 * kSharpest * rim_m();
  box_.max().array() += 2 * kSharpest * rim_m();
}

/// Of the triangle with its right angle at a vertex of the block, its sides along the rows and columns running up (side
/// 1) or down (-1): length of the normal whose height is 1.
double TileSurfaces::steepness(std::uint32_t column, std::uint32_t row, int side) const {
  const Heightfield& terrain = *world_.terrain();
  const float* here =
      &terrain.heights_m()[(contents_.first_row + row) * terrain.nx() + contents_.first_column + column];
  const double x = (double{here[side]} - *here) / terrain.spacing_m();
  const double y = (double{here[side * static_cast<std::ptrdiff_t>(terrain.nx())]} - *here) / terrain.spacing_m();
  return std::sqrt(1 + x * x + y * y);
}

double TileSurfaces::steepest_at(std::uint32_t column, std::uint32_t row) const {
  double most = 1;
  const bool left = column > 0, right = column<contents_.columns, below = row> 0, above = row < contents_.rows;
  if (right && above) most = std::max(most, steepness(column, row, 1));
  if (left && below) most = std::max(most, steepness(column, row, -1));
  if (left && above) most = std::max({most, steepness(column - 1, row, 1), steepness(column, row + 1, -1)});
  if (right && below) most = std::max({most, steepness(column, row - 1, 1), steepness(column + 1, row, -1)});
  return most;
}

Eigen::Vector3d TileSurfaces::raised_vertex_m(std::uint32_t column, std::uint32_t row) const {
  const auto outward = [](std::uint32_t at, std::uint32_t last) { return at == 0 ? -1.0 : at == last ? 1.0 : 0.0; };
  Eigen::Vector3d move(outward(column, contents_.columns), outward(row, contents_.rows), 0);
  // Outward is downward where the terrain falls that way; that is made up for.
  const double steep = steepest_at(column, row), slope = std::sqrt(steep * steep - 1);
  move.z() = steep + slope * (std::abs(move.x()) + std::abs(move.y()));
  const std::size_t number = (contents_.first_row + row) * world_.terrain()->nx() + contents_.first_column + column;
  return world_.terrain()->vertex(number) - middle_m_ + raise_m() * move;
}

void TileSurfaces::find_crossings() {
  is_crossed_.assign(std::size_t{contents_.columns} * contents_.rows, 0);
  if (contents_.columns == 0) return;
  std::vector<std::pair<std::uint32_t, Member>> found;
  for (const TileContents::Share& share : contents_.solids) {
    for (std::uint32_t k = 0; k < share.members.size(); ++k) add_cells_near({share.label, k}, found);
  }
  std::ranges::stable_sort(found, {}, [](const auto& entry) { return entry.first; });
  for (const auto& [cell, member] : found) {
    if (is_crossed_[cell] == 0) crossings_.push_back({cell, static_cast<std::uint32_t>(company_.size()), 0});
    is_crossed_[cell] = 1;
    ++crossings_.back().count;
    company_.push_back(member);
  }
}

void TileSurfaces::add_cells_near(const Member& member, std::vector<std::pair<std::uint32_t, Member>>& found) const {
  const bool round = is_round(member.geometry);
  const double room = kCrossing * reach_m_ + clearance_m();
  Eigen::AlignedBox3d solid =
      round ? box_of(shape(member.geometry, member.primitive)) : box_of(corners(member.geometry, member.primitive));
  solid.min().array() -= room;
  solid.max().array() += room;
  const Heightfield& terrain = *world_.terrain();
  const auto cell = [&](double at_m, double origin_m, std::uint32_t first, std::uint32_t count) {
    const double local = std::floor((at_m - origin_m) / terrain.spacing_m()) - first;
    return static_cast<std::int64_t>(std::clamp(local, -1.0, static_cast<double>(count)));
  };
  const auto column = [&](double x) {
    return cell(x, terrain.origin_m().x(), contents_.first_column, contents_.columns);
  };
  const auto row = [&](double y) { return cell(y, terrain.origin_m().y(), contents_.first_row, contents_.rows); };
  const std::int64_t last_row = std::min<std::int64_t>(row(solid.max().y()), contents_.rows - 1);
  const std::int64_t last_column = std::min<std::int64_t>(column(solid.max().x()), contents_.columns - 1);
  for (std::int64_t j = std::max<std::int64_t>(0, row(solid.min().y())); j <= last_row; ++j) {
    for (std::int64_t i = std::max<std::int64_t>(0, column(solid.min().x())); i <= last_column; ++i) {
      const auto at = static_cast<std::uint32_t>(j * contents_.columns + i);
      Eigen::AlignedBox3d bed = box_of(corners(kPlainTerrain, 2 * at));
      bed.extend(box_of(corners(kPlainTerrain, 2 * at + 1)));
      if (!solid.intersects(bed)) continue;
      if (round && !may_touch(shape(member.geometry, member.primitive), bed, room)) continue;
      found.push_back({at, member});
    }
  }
}

const TileContents::Share& TileSurfaces::share(std::uint32_t geometry) const {
  return contents_.solids[static_cast<std::size_t>(share_of_geometry_[geometry])];
}

std::size_t TileSurfaces::count(std::uint32_t geometry) const {
  if (geometry == kCrossedTerrain) return 2 * crossings_.size();
  if (geometry == kPlainTerrain) return 2 * std::size_t{contents_.columns} * contents_.rows;
  return share_of_geometry_[geometry] < 0 ? 0 : share(geometry).members.size();
}

bool TileSurfaces::is_round(std::uint32_t geometry) const {
  return geometry > kTerrain && !world_.solids()[geometry - kTerrain - 1]->shapes.empty();
}

std::uint32_t TileSurfaces::terrain_number(std::uint32_t plain_triangle) const {
  if (whole_terrain_) return plain_triangle;
  const std::uint32_t cell = plain_triangle / 2;
  const auto columns = static_cast<std::uint32_t>(world_.terrain()->nx() - 1);
  const std::uint32_t row = contents_.first_row + cell / contents_.columns;
  const std::uint32_t column = contents_.first_column + cell % contents_.columns;
  return 2 * (row * columns + column) + plain_triangle % 2;
}

std::uint32_t TileSurfaces::other_number(std::uint32_t geometry, std::uint32_t primitive) const {
  if (geometry == kCrossedTerrain) return terrain_number(plain_number(primitive));
  if (geometry == kPlainTerrain) return terrain_number(primitive);
  return share(geometry).members[primitive];
}

Corners TileSurfaces::corners(std::uint32_t geometry, std::uint32_t primitive) const {
  const std::uint32_t number = world_number(geometry, primitive);
  if (geometry > kTerrain) return solid_corners(*world_.solids()[geometry - kTerrain - 1], number);
  const Triangle t = world_.terrain()->triangle(number);
  return {world_.terrain()->vertex(t[0]), world_.terrain()->vertex(t[1]), world_.terrain()->vertex(t[2])};
}

Corners TileSurfaces::mesh_corners(std::size_t mesh, std::uint32_t member) const {
  const TileContents::Share& share = contents_.meshes[mesh];
  return solid_corners(*world_.solids()[share.label - kTerrain - 1], share.members[member]);
}

const RoundShape& TileSurfaces::shape(std::uint32_t geometry, std::uint32_t primitive) const {
  return world_.solids()[geometry - kTerrain - 1]->shapes[world_number(geometry, primitive)];
}

std::optional<TileHit> TileSurfaces::meet(std::uint32_t geometry, std::uint32_t primitive, const TileRay& ray) const {
  if (!is_round(geometry)) return meet_triangle(corners(geometry, primitive), ray, reach_m_);
  const auto hit = first_hit(shape(geometry, primitive), ray.origin_world_m, ray.direction_world, 0, ray.far_m);
  return hit ? std::optional(TileHit{hit->distance_m, hit->normal_world, true}) : std::nullopt;
}

TerrainBlock TileSurfaces::terrain_block() const {
  const Heightfield& terrain = *world_.terrain();
  return {terrain.heights_m().data(),
          terrain.origin_m().x(),
          terrain.origin_m().y(),
          1 / terrain.spacing_m(),
          kWithin,
          clearance_m(),
          static_cast<std::uint32_t>(terrain.nx()),
          contents_.first_column,
          contents_.first_row,
          contents_.columns,
          contents_.rows};
}

}  // namespace uwsim
