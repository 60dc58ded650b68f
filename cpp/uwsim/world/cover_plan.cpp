#include "uwsim/world/cover_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace uwsim {
namespace {

constexpr double kPiecesATile = 1000;
constexpr double kNarrowestTile_m = 2, kWidestTile_m = 64;
constexpr int kNoiseSamples = 4096;
constexpr double kFringe = 0.15;  // width of a patch's fringe, in values of the noise
constexpr std::size_t kTrianglesAGroup = 32;
constexpr std::size_t kSizes = 256, kHeights = 64;  // of plants, for the mean of their frontal areas

/// Numbers of a piece's random draws.
enum Draw : std::uint32_t { kX, kY, kSize, kMesh, kYaw, kTurn, kTilt, kEdge, kDraws };

double smooth(double t) { return t * t * (3 - 2 * t); }

/// Value noise in the plane, of two octaves; x, y in sizes of a patch.
double patch_noise(const RandomStream& stream, double x, double y) {
  double sum = 0;
  for (int octave = 0; octave < 2; ++octave, x *= 2.03, y *= 2.03) {
    const double i = std::floor(x), j = std::floor(y), u = smooth(x - i), v = smooth(y - j);
    const auto at = [&](int di, int dj) {
      const auto column = static_cast<std::int32_t>(i) + di, row = static_cast<std::int32_t>(j) + dj;
      const auto tick = std::uint64_t{static_cast<std::uint32_t>(row)} << 32 | static_cast<std::uint32_t>(column);
      return stream.uniform(tick, static_cast<std::uint32_t>(octave));
    };
    const double low = at(0, 0) + u * (at(1, 0) - at(0, 0)), high = at(0, 1) + u * (at(1, 1) - at(0, 1));
    sum += (low + v * (high - low)) / (1 << octave);
  }
  return sum;
}

/// The value that the noise exceeds on a given share of the area, from samples far apart.
double threshold_for(const RandomStream& stream, double share) {
  if (share >= 1) return -1;
  std::vector<double> values(kNoiseSamples);
  for (int k = 0; k < kNoiseSamples; ++k)
    values[static_cast<std::size_t>(k)] = patch_noise(stream, 2.7 * (k % 64), 2.7 * (k / 64));
  std::ranges::sort(values);
  return values[static_cast<std::size_t>((1 - share) * (kNoiseSamples - 1))];
}

double size_of(const CoverLayer& layer, double share) {
  const auto [low, high] = layer.size_m;
  if (std::abs(layer.size_exponent) < 1e-9) return low * std::pow(high / low, share);
  const double k = -layer.size_exponent, a = std::pow(low, k), b = std::pow(high, k);
  return std::clamp(std::pow(a + share * (b - a), 1 / k), low, high);
}

Eigen::Vector3d bed_normal(const Heightfield& terrain, const Eigen::Vector2d& at) {
  const double step = 0.5 * terrain.spacing_m();
  const auto slope = [&](const Eigen::Vector2d& along) {
    const Eigen::Vector2d ahead = at + step * along, behind = at - step * along;
    return (terrain.height_at(ahead.x(), ahead.y()) - terrain.height_at(behind.x(), behind.y())) / (2 * step);
  };
  return Eigen::Vector3d(-slope({1, 0}), -slope({0, 1}), 1).normalized();  // NaN at the terrain's rim
}

Eigen::AngleAxisd about_z(double share) { return {2 * std::numbers::pi * share, Eigen::Vector3d::UnitZ()}; }

}  // namespace

CoverPlan::CoverPlan(const World& surfaces) : surfaces_(surfaces), from_solids_(surfaces) {
  const Heightfield& terrain = *surfaces.terrain();
  double density = 0;
  std::uint32_t meshes = 0;
  for (const auto& layer : surfaces.cover()) {
    const RandomStream patches(layer->seed, "cover." + layer->name + ".patches");
    Growth growth{layer,
                  RandomStream(layer->seed, "cover." + layer->name),
                  patches,
                  meshes,
                  {},
                  {},
                  layer->patch_m > 0 ? threshold_for(patches, layer->patch_share) : -1,
                  0,
                  0,
                  {}};
    for (const TriangleMesh& mesh : layer->meshes) {
      double reach = 0, top = 0;
      for (const Eigen::Vector3d& v : mesh.vertices_m) reach = std::max(reach, v.norm()), top = std::max(top, v.z());
      growth.reach.push_back(reach);
      growth.top.push_back(layer->stance == CoverStance::kTumbled ? reach : top);
      const double reach_m = (reach + std::abs(layer->sunk)) * layer->size_m.high;
      for (const Of layers : {Of::kAll, Of::kSolid}) {
        double& most_m = reach_m_[static_cast<std::size_t>(layers)];
        if (layers == Of::kAll || layer->solid) most_m = std::max(most_m, reach_m);
      }
    }
    if (layer->drag_coefficient > 0) set_frontal_area(growth);
    meshes += static_cast<std::uint32_t>(layer->meshes.size());
    density += layer->density_per_m2;
    growths_.push_back(std::move(growth));
  }
  tile_m_ = std::clamp(std::sqrt(kPiecesATile / std::max(density, 1e-9)), kNarrowestTile_m, kWidestTile_m);
  for (Growth& growth : growths_) {
    growth.first_number = numbers_a_tile_;
    numbers_a_tile_ += static_cast<std::uint32_t>(growth.layer->density_per_m2 * tile_m_ * tile_m_) + 1;
  }
  origin_m_ = terrain.origin_m();
  const Eigen::Vector2d size = terrain.far_corner_m() - origin_m_;
  columns_ = static_cast<std::uint32_t>(std::ceil(size.x() / tile_m_));
  rows_ = static_cast<std::uint32_t>(std::ceil(size.y() / tile_m_));
}

CoverTiles CoverPlan::tiles_near(const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m, double far_m) const {
  const auto numbers = [&](int axis, std::uint32_t count) {
    const double low = low_m(axis) - origin_m_(axis) - far_m, high = high_m(axis) - origin_m_(axis) + far_m;
    return std::pair(static_cast<std::int64_t>(std::clamp(std::floor(low / tile_m_), 0.0, 1.0 * count)),
                     static_cast<std::int64_t>(std::clamp(std::floor(high / tile_m_), -1.0, count - 1.0)));
  };
  const auto [left, right] = numbers(0, columns_);
  const auto [low, high] = numbers(1, rows_);
  return {left, right, low, high};
}

CoverTilePlan CoverPlan::pieces(std::uint32_t column, std::uint32_t row, Of layers) const {
  CoverTilePlan plan;
  plan.middle_m.head<2>() = origin_m_ + tile_m_ * Eigen::Vector2d(column + 0.5, row + 0.5);
  const Eigen::Vector2d inside =
      plan.middle_m.head<2>().cwiseMin(surfaces_.terrain()->far_corner_m()).cwiseMax(surfaces_.terrain()->origin_m());
  plan.middle_m.z() = surfaces_.terrain()->height_at(inside.x(), inside.y());
  const std::uint64_t tile = std::uint64_t{row} << 32 | column;
  for (const Growth& growth : growths_) {
    if (layers == Of::kSolid && !growth.layer->solid) continue;
    const double expected = growth.layer->density_per_m2 * tile_m_ * tile_m_;
    const auto count = static_cast<std::uint32_t>(expected + growth.stream.uniform(tile, ~0u));
    for (std::uint32_t k = 0; k < count; ++k) add_piece(growth, tile, k, plan);
  }
  return plan;
}

void CoverPlan::add_piece(const Growth& growth, std::uint64_t tile, std::uint32_t k, CoverTilePlan& plan) const {
  const CoverLayer& layer = *growth.layer;
  const auto draw = [&](Draw what) { return growth.stream.uniform(tile, kDraws * k + what); };
  const Eigen::Vector2d at =
      plan.middle_m.head<2>() + tile_m_ * (Eigen::Vector2d(draw(kX), draw(kY)).array() - 0.5).matrix();
  // A patch ends in a fringe, in which fewer pieces stand.
  const double fringe = kFringe * (draw(kEdge) - 0.5);
  if (layer.patch_m > 0 &&
      patch_noise(growth.patches, at.x() / layer.patch_m, at.y() / layer.patch_m) + fringe < growth.threshold)
    return;
  const Heightfield& terrain = *surfaces_.terrain();
  const Eigen::Vector3d foot(at.x(), at.y(), terrain.height_at(at.x(), at.y())), up = bed_normal(terrain, at);
  if (!up.allFinite() || !grows_at(growth, foot, up)) return;
  const double size = size_of(layer, draw(kSize));
  const auto mesh = std::min(static_cast<std::size_t>(draw(kMesh) * static_cast<double>(layer.meshes.size())),
                             layer.meshes.size() - 1);
  if (foot.z() + size * (growth.top[mesh] - layer.sunk) > 0) return;  // it would reach out of the water
  Eigen::Quaterniond turn(about_z(draw(kYaw)));
  if (layer.stance == CoverStance::kOnBed)
    turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up) * turn;
  if (layer.stance == CoverStance::kTumbled) {  // uniform over all rotations
    const double tilt = std::acos(1 - 2 * draw(kTilt));
    turn = about_z(draw(kTurn)) * Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()) * turn;
  }
  const std::uint64_t number = (std::uint64_t{columns_} * (tile >> 32) + (tile & 0xffffffffu)) * numbers_a_tile_;
  const Eigen::Vector3d origin = foot - layer.sunk * size * up - plan.middle_m;
  plan.pieces.push_back({origin.cast<float>(), (size * turn.toRotationMatrix()).cast<float>(), static_cast<float>(size),
                         growth.first_mesh + static_cast<std::uint32_t>(mesh),
                         static_cast<std::uint16_t>(&growth - growths_.data()),
                         static_cast<std::uint32_t>(number + growth.first_number + k + 1)});
}

bool CoverPlan::grows_at(const Growth& growth, const Eigen::Vector3d& foot_m, const Eigen::Vector3d& up) const {
  const CoverLayer& layer = *growth.layer;
  if (!layer.depth_m.contains(-foot_m.z()) || !layer.slope_rad.contains(std::acos(std::min(1.0, up.z())))) return false;
  const CoverRange& range = layer.from_solids_m;
  if (range.low <= 0 && range.high == std::numeric_limits<double>::infinity()) return true;
  // Inside a solid, the distance is 0. That test is by far the dearest, so it is made only where it decides.
  const double enough = std::isfinite(range.high) ? std::max(range.low, range.high) : range.low;
  const bool near_surface = range.contains(from_solids_(foot_m, enough));
  if (near_surface == range.contains(0)) return near_surface;
  return (surfaces_.solid_around(foot_m) != nullptr) != near_surface;
}

double CoverPlan::density_at(std::size_t layer, const Eigen::Vector2d& at_m) const {
  const Growth& growth = growths_[layer];
  const CoverLayer& of = *growth.layer;
  double share = 1;
  if (of.patch_m > 0) {
    const double noise = patch_noise(growth.patches, at_m.x() / of.patch_m, at_m.y() / of.patch_m);
    share = std::clamp((noise - growth.threshold) / kFringe + 0.5, 0.0, 1.0);
  }
  if (share == 0) return 0;
  const Eigen::Vector3d foot(at_m.x(), at_m.y(), surfaces_.terrain()->height_at(at_m.x(), at_m.y()));
  const Eigen::Vector3d up = bed_normal(*surfaces_.terrain(), at_m);
  return up.allFinite() && grows_at(growth, foot, up) ? share * of.density_per_m2 : 0;
}

double CoverPlan::frontal_area_below(std::size_t layer, double height_m) const {
  const Growth& growth = growths_[layer];
  if (height_m <= 0 || growth.frontal_m2.empty()) return 0;
  const std::size_t last = growth.frontal_m2.size() - 1;
  const double at = std::min(height_m / growth.tallest_m, 1.0) * static_cast<double>(last);
  const auto below = std::min(static_cast<std::size_t>(at), last - 1);
  return std::lerp(growth.frontal_m2[below], growth.frontal_m2[below + 1], at - static_cast<double>(below));
}

/// The area of a piece is that of its triangles, seen from the side, as a mean over all directions: 2 / pi of a
/// triangle's area times the horizontal part of its normal. It is spread evenly over the piece's height.
void CoverPlan::set_frontal_area(Growth& growth) {
  const CoverLayer& layer = *growth.layer;
  growth.frontal_m2.assign(kHeights + 1, 0);
  growth.tallest_m = (*std::ranges::max_element(growth.top) - layer.sunk) * layer.size_m.high;
  if (growth.tallest_m <= 0) return growth.frontal_m2.clear();
  for (std::size_t m = 0; m < layer.meshes.size(); ++m) {
    const TriangleMesh& mesh = layer.meshes[m];
    double area = 0;
    for (const Triangle& t : mesh.triangles) {
      const Eigen::Vector3d &a = mesh.vertices_m[t[0]], &b = mesh.vertices_m[t[1]], &c = mesh.vertices_m[t[2]];
      area += (b - a).cross(c - a).head<2>().norm() / std::numbers::pi;
    }
    for (std::size_t k = 0; k < kSizes; ++k) {
      const double size = size_of(layer, (static_cast<double>(k) + 0.5) / kSizes);
      const double height_m = (growth.top[m] - layer.sunk) * size;
      const double of_all = 1 / static_cast<double>(kSizes * layer.meshes.size());
      for (std::size_t h = 1; h <= kHeights && height_m > 0; ++h) {
        const double share = growth.tallest_m * static_cast<double>(h) / (kHeights * height_m);
        growth.frontal_m2[h] += of_all * area * size * size * std::min(1.0, share);
      }
    }
  }
}

CoverPlan::SolidDistance::SolidDistance(const World& surfaces) {
  for (const auto& solid : surfaces.solids()) {
    const TriangleMesh& mesh = solid->mesh_world;
    for (std::size_t first = 0; first < mesh.triangles.size(); first += kTrianglesAGroup) {
      Group group{{}, &mesh, first, std::min(first + kTrianglesAGroup, mesh.triangles.size())};
      for (std::size_t k = group.first; k < group.last; ++k) {
        for (const std::uint32_t v : mesh.triangles[k]) group.box.extend(mesh.vertices_m[v]);
      }
      groups_.push_back(group);
    }
  }
}

double CoverPlan::SolidDistance::operator()(const Eigen::Vector3d& point_m, double enough_m) const {
  double distance = std::numeric_limits<double>::infinity(), far_m = enough_m;
  for (const Group& group : groups_) {
    if (group.box.exteriorDistance(point_m) > far_m) continue;
    for (std::size_t k = group.first; k < group.last; ++k) {
      const auto& [a, b, c] = group.mesh->triangles[k];
      const auto& at = group.mesh->vertices_m;
      distance = std::min(distance, (closest_on_triangle(point_m, {at[a], at[b], at[c]}) - point_m).norm());
    }
    far_m = std::min(far_m, distance);
  }
  return distance;
}

}  // namespace uwsim
