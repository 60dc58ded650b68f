#include "uwsim/rays/cover_tile.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/rays/embree.h"
#include "uwsim/rays/tolerances.h"

namespace uwsim {
namespace {

constexpr double kUneven = 0.2;  // how much the lean of neighbours differs from their mean
constexpr double kGolden = 0.6180339887498949;
constexpr double kWider = 1 + 1e-4;  // a box that holds all rays' hits

struct NearestOnMesh {
  Eigen::Vector3d point;
  double distance;
  const CoverShape* shape;
};

bool visit_mesh_triangle(RTCPointQueryFunctionArguments* args) {
  auto* nearest = static_cast<NearestOnMesh*>(args->userPtr);
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = nearest->shape->vertices[nearest->shape->triangles[args->primID][k]].cast<double>();
  const double own = (closest_on_triangle(nearest->point, corners) - nearest->point).norm();
  if (!(own < nearest->distance)) return false;
  nearest->distance = own;
  args->query->radius = static_cast<float>(own * (1 + kFartherSearch));
  return true;
}

}  // namespace

CoverShape::CoverShape(RTCDeviceTy* device, const TriangleMesh& mesh, const CoverLayer& of_layer)
    : layer(&of_layer), triangles(mesh.triangles), normals(mesh), tree(make_ray_tree(device, true)) {
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    vertices.push_back(v.cast<float>());
    across = std::max(across, vertices.back().head<2>().norm());
    low = std::min(low, vertices.back().z()), high = std::max(high, vertices.back().z());
  }
  GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  void* vertex = rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                         sizeof(Eigen::Vector3f), vertices.size());
  void* index = rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Triangle),
                                        triangles.size());
  require(vertex != nullptr && index != nullptr, "cover.triangles", triangles.size(), "not enough memory for them");
  std::memcpy(vertex, vertices.data(), vertices.size() * sizeof(Eigen::Vector3f));
  std::memcpy(index, triangles.data(), triangles.size() * sizeof(Triangle));
  attach(tree.get(), owner, 0);
  commit(device, tree.get(), triangles.size());
}

Lean::Lean(const Eigen::Vector2d& top) : top_(top) {
  const double square = std::min(top.squaredNorm(), kFarthest * kFarthest), cosine = 1 / std::sqrt(1 + square);
  if (square > 0) shift_ << std::sqrt(square) * cosine * top.normalized(), cosine - 1;
}

Lean Lean::of(std::uint32_t piece) const {
  const double share = kGolden * piece;
  return Lean((1 + kUneven * (2 * (share - std::floor(share)) - 1)) * top_);
}

CoverTile::CoverTile(RTCDeviceTy* device, std::span<const CoverShape> shapes, CoverTilePlan plan)
    : device_(device),
      shapes_(shapes),
      middle_m_(plan.middle_m),
      soft_middle_m_(0, 0, 0),
      pieces_(std::move(plan.pieces)) {
  for (const CoverPiece& piece : pieces_) {
    if (!shapes_[piece.mesh].layer->sways()) continue;
    ++soft_;
    soft_middle_m_ += piece.at_m.cast<double>();
  }
  soft_middle_m_ = middle_m_ + soft_middle_m_ / std::max<double>(1, static_cast<double>(soft_));
  still_ = target(Which::kAll);
  box_ = still_.box;
  for (const CoverPiece& piece : pieces_) {
    const CoverShape& shape = shapes_[piece.mesh];
    if (!shape.layer->sways()) continue;
    // A leaning plant keeps its distance from the foot, except for the width of its stem.
    const double reach = kWider * piece.size_m * (shape.across + std::max(-shape.low, shape.high));
    const Eigen::Vector3d foot = middle_m_ + piece.at_m.cast<double>(), far = Eigen::Vector3d::Constant(reach);
    box_.extend(foot - far), box_.extend(foot + far);
  }
}

CoverTile::Target CoverTile::target(Which which, std::span<const Lean> leans) const {
  RayTree tree = make_ray_tree(device_, true);
  std::size_t count = 0;
  for (std::uint32_t k = 0; k < pieces_.size(); ++k) {
    const CoverPiece& piece = pieces_[k];
    if (which != Which::kAll && shapes_[piece.mesh].layer->sways() != (which == Which::kSoft)) continue;
    Eigen::Matrix3f turn = piece.turn;
    if (!leans.empty()) {
      const Lean lean = leans[piece.mesh].of(piece.number);
      for (Eigen::Index column = 0; column < 3; ++column)
        turn.col(column) = lean.leaned(piece.turn.col(column).cast<double>()).cast<float>();
    }
    GeometryOwner owner(rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(owner.get(), shapes_[piece.mesh].tree.get());
    std::array<float, 12> place;  // columns of the rotation, then the translation
    std::copy_n(turn.data(), 9, place.begin());
    std::copy_n(piece.at_m.data(), 3, place.begin() + 9);
    rtcSetGeometryTransform(owner.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, place.data());
    attach(tree.get(), owner, k);
    ++count;
  }
  commit(device_, tree.get(), count);
  Target made{std::move(tree), {}};
  if (count == 0) return made;  // its box is empty, so that no ray enters it
  RTCBounds bounds;
  rtcGetSceneBounds(made.tree.get(), &bounds);
  constexpr double kMargin_m = 1e-3;
  made.box = {middle_m_ + Eigen::Vector3d(bounds.lower_x, bounds.lower_y, bounds.lower_z) -
                  Eigen::Vector3d::Constant(kMargin_m),
              middle_m_ + Eigen::Vector3d(bounds.upper_x, bounds.upper_y, bounds.upper_z) +
                  Eigen::Vector3d::Constant(kMargin_m)};
  return made;
}

const CoverTile::Target& CoverTile::stiff() const {
  return stiff_.get([this] { return target(Which::kStiff); });
}

std::shared_ptr<const CoverTile::Plants> CoverTile::plants(const std::shared_ptr<const Sway>& sway) const {
  const std::scoped_lock lock(changing_);
  if (!plants_ || (&plants_->sway() != sway.get() && !plants_->sway().same_as(*sway)))
    plants_ = std::make_shared<const Plants>(*this, sway);
  return plants_;
}

CoverTile::Plants::Plants(const CoverTile& tile, std::shared_ptr<const Sway> sway)
    : tile_(tile), sway_(std::move(sway)), leans_(tile.shapes_.size()) {
  for (std::size_t k = 0; k < leans_.size(); ++k) {
    const CoverLayer& layer = *tile.shapes_[k].layer;
    if (!layer.sways()) continue;
    const bool same = k > 0 && tile.shapes_[k - 1].layer == &layer;
    leans_[k] = same ? leans_[k - 1] : Lean(sway_->lean(layer, tile.soft_middle_m_));
  }
  for (const CoverPiece& piece : tile.pieces_) {
    const CoverShape& shape = tile.shapes_[piece.mesh];
    if (!shape.layer->sways()) continue;
    const Eigen::Vector3d foot = tile.middle_m_ + piece.at_m.cast<double>();
    const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ() + leans_[piece.mesh].of(piece.number).shift();
    const double size = piece.size_m, aside = kWider * size * shape.across;
    for (const float z : {shape.low, shape.high}) {
      const Eigen::Vector3d at = foot + kWider * size * z * axis;
      box_.extend(at - Eigen::Vector3d(aside, aside, 0)), box_.extend(at + Eigen::Vector3d(aside, aside, 0));
    }
  }
}

const CoverTile::Target& CoverTile::Plants::target() const {
  return target_.get([this] { return tile_.target(Which::kSoft, leans_); });
}

Corners CoverTile::corners(const CoverPiece& piece, std::uint32_t triangle, std::span<const Lean> leans) const {
  const CoverShape& shape = shapes_[piece.mesh];
  const Eigen::Matrix3d turn = piece.turn.cast<double>();
  const Eigen::Vector3d at = middle_m_ + piece.at_m.cast<double>();
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = turn * shape.vertices[shape.triangles[triangle][k]].cast<double>();
  if (!leans.empty() && !leans[piece.mesh].upright()) {
    const Lean lean = leans[piece.mesh].of(piece.number);
    for (Eigen::Vector3d& corner : corners) corner = lean.leaned(corner);
  }
  for (Eigen::Vector3d& corner : corners) corner += at;
  return corners;
}

SmoothPlace CoverTile::smooth(const CoverPiece& piece, std::uint32_t triangle, float u, float v,
                              std::span<const Lean> leans) const {
  const CoverShape& shape = shapes_[piece.mesh];
  if (!shape.normals.bend() || (!leans.empty() && !leans[piece.mesh].upright())) return {};
  const auto& [a, b, c] = shape.triangles[triangle];
  SmoothPlace place = shape.normals.at(triangle, u, v, {shape.vertices[a], shape.vertices[b], shape.vertices[c]});
  place.normal = (piece.turn * place.normal).normalized();
  place.rise_m *= piece.size_m;
  return place;
}

double CoverTile::distance(const Eigen::Vector3d& point_world_m, double nearest_m, std::span<const Lean> leans) const {
  for (const CoverPiece& piece : pieces_) {
    const CoverShape& shape = shapes_[piece.mesh];
    const Eigen::Vector3d from = point_world_m - middle_m_ - piece.at_m.cast<double>();
    const double size = piece.size_m;
    if (from.norm() - size * (shape.across + std::max(-shape.low, shape.high)) >= nearest_m) continue;
    if (!leans.empty() && !leans[piece.mesh].upright()) {
      for (std::uint32_t t = 0; t < shape.triangles.size(); ++t) {
        const Eigen::Vector3d closest = closest_on_triangle(point_world_m, corners(piece, t, leans));
        nearest_m = std::min(nearest_m, (closest - point_world_m).norm());
      }
      continue;
    }
    NearestOnMesh nearest{piece.turn.cast<double>().inverse() * from, nearest_m / size, &shape};
    const Eigen::Vector3f at = nearest.point.cast<float>();
    RTCPointQuery query{at.x(), at.y(), at.z(), 0,
                        static_cast<float>(std::min(nearest.distance * (1 + kFartherSearch), 1e30))};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(shape.tree.get(), &query, &context, &visit_mesh_triangle, &nearest);
    nearest_m = std::min(nearest_m, nearest.distance * size);
  }
  return nearest_m;
}

}  // namespace uwsim
