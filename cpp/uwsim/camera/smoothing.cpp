#include "uwsim/camera/smoothing.h"

#include <algorithm>

#include "uwsim/camera/block_lane.h"

namespace uwsim {
namespace {

// Cosine between the eye and the slope of a surface, which cannot be seen from behind
constexpr float kLeastFacing = 0.05f;

using camera::lane, camera::set_lane;

/// Barycentric coordinates of the second and third corner, for a point near the triangle.
std::array<float, 2> coordinates(const Corners& corners, const Eigen::Vector3d& point) {
  const Eigen::Vector3d ab = corners[1] - corners[0], ac = corners[2] - corners[0], to = point - corners[0];
  const Eigen::Vector3d normal = ab.cross(ac);
  const double area = std::max(normal.squaredNorm(), 1e-300);
  const double u = std::clamp(to.cross(ac).dot(normal) / area, 0.0, 1.0);
  return {static_cast<float>(u), static_cast<float>(std::clamp(ab.cross(to).dot(normal) / area, 0.0, 1 - u))};
}

}  // namespace

Eigen::Vector3f seen_normal(const Eigen::Vector3f& normal, const Eigen::Vector3f& direction) {
  const float away = normal.dot(direction) + kLeastFacing;
  return away > 0 ? (normal - away * direction).normalized() : normal;
}

void set_smooth_normals(const CameraScene& scene, const Tracer& tracer, const HitPacket& hits, camera::Block& block) {
  for (std::size_t k = 0; k < camera::kBlockPixels; ++k) {
    block.rise.at[k] = 0;
    const std::uint32_t label = block.label[k];
    if (label <= kTerrain) continue;
    if (const Texture* const texture = scene.texture_of(label); texture != nullptr && texture->has_relief()) continue;
    SmoothPlace smooth{{hits.smooth_x[k], hits.smooth_y[k], hits.smooth_z[k]}, hits.rise_m[k]};
    if (const SmoothMesh* const mesh = scene.smooth_mesh(label)) {
      if (hits.u[k] == 0 && hits.v[k] == 0) continue;  // a round shape, which has no facets
      smooth = mesh->at(block.primitive[k], tracer.on_mesh(static_cast<Label>(label), lane(block.point, k)),
                        tracer.mesh_turn(static_cast<Label>(label), 0));
    }
    if (smooth.normal.isZero(0)) continue;
    const Eigen::Vector3f direction = lane(block.direction, k);
    const bool from_behind = lane(block.normal, k).dot(direction) > 0;
    const Eigen::Vector3f towards_eye = (from_behind ? -1.0f : 1.0f) * smooth.normal;
    set_lane(seen_normal(towards_eye, direction), k, block.normal);
    if (!from_behind) block.rise.at[k] = smooth.rise_m;
  }
}

SmoothPlace SmoothMesh::at(std::uint32_t triangle, const Eigen::Vector3d& point, const Eigen::Matrix3f& turn) const {
  const CornerNormals& normals = normals_.get([this] { return CornerNormals(mesh_); });
  if (!normals.bend() || triangle >= mesh_.triangles.size()) return {};
  Corners corners;
  std::array<Eigen::Vector3f, 3> near;  // exact in float relative to the first
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k] = mesh_.vertices_m[mesh_.triangles[triangle][k]];
    near[k] = (corners[k] - corners[0]).cast<float>();
  }
  const auto [u, v] = coordinates(corners, point);
  SmoothPlace place = normals.at(triangle, u, v, near);
  place.normal = turn * place.normal;
  return place;
}

}  // namespace uwsim
