#include "uwsim/vehicle/buoyant_hull.h"

#include <algorithm>
#include <array>
#include <utility>

namespace uwsim {
namespace {

/// Sums signed tetrahedra from the origin, which must lie on the water surface.
struct TetrahedronSum {
  double volume = 0;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();

  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const double det = a.dot(b.cross(c));
    volume += det / 6;
    first_moment += det / 24 * (a + b + c);
  }
};

/// The point where the edge from `wet` (z < 0) to `dry` (z >= 0) pierces the surface.
Eigen::Vector3d pierce(const Eigen::Vector3d& wet, const Eigen::Vector3d& dry) {
  Eigen::Vector3d p = wet + wet.z() / (wet.z() - dry.z()) * (dry - wet);
  p.z() = 0;
  return p;
}

/// Adds the part of the triangle that lies under z = 0.
void add_wet_part(TetrahedronSum& sum, std::array<Eigen::Vector3d, 3> t) {
  const auto wet = std::count_if(t.begin(), t.end(), [](const Eigen::Vector3d& v) { return v.z() < 0; });
  if (wet == 0) return;
  if (wet == 3) return sum.add(t[0], t[1], t[2]);
  // Turn the triangle, keeping its winding, so that the vertex that differs from the other two comes first.
  const bool lone_is_wet = wet == 1;
  while ((t[0].z() < 0) != lone_is_wet || (t[1].z() < 0) == lone_is_wet) std::rotate(t.begin(), t.begin() + 1, t.end());
  if (lone_is_wet) return sum.add(t[0], pierce(t[0], t[1]), pierce(t[0], t[2]));
  const Eigen::Vector3d p = pierce(t[1], t[0]);
  sum.add(p, t[1], t[2]);
  sum.add(p, t[2], pierce(t[2], t[0]));
}

}  // namespace

BuoyantHull::BuoyantHull(TriangleMesh mesh_body) : mesh_body_(std::move(mesh_body)) {
  require_closed(mesh_body_, "hull");
  solid_ = solid_properties(mesh_body_);
  Eigen::Vector3d low = mesh_body_.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& v : mesh_body_.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  middle_body_m_ = 0.5 * (low + high);
  for (const Eigen::Vector3d& v : mesh_body_.vertices_m) radius_m_ = std::max(radius_m_, (v - middle_body_m_).norm());
}

Displacement BuoyantHull::displacement(const Pose& world_from_body) const {
  const double middle_z = world_from_body.point(middle_body_m_).z();
  if (middle_z + radius_m_ <= 0) return {solid_.volume_m3, world_from_body.point(solid_.centroid_m)};
  if (middle_z - radius_m_ >= 0) return {0, world_from_body.position_m};
  return cut_at_surface(world_from_body);
}

Displacement BuoyantHull::cut_at_surface(const Pose& world_from_body) const {
  const Eigen::Matrix3d rotation = world_from_body.rotation();
  const Eigen::Vector3d on_surface(world_from_body.position_m.x(), world_from_body.position_m.y(), 0);
  const Eigen::Vector3d shift = world_from_body.position_m - on_surface;
  TetrahedronSum sum;
  for (const Triangle& t : mesh_body_.triangles) {
    add_wet_part(sum, {rotation * mesh_body_.vertices_m[t[0]] + shift, rotation * mesh_body_.vertices_m[t[1]] + shift,
                       rotation * mesh_body_.vertices_m[t[2]] + shift});
  }
  if (sum.volume <= 0) return {0, world_from_body.position_m};
  return {sum.volume, on_surface + sum.first_moment / sum.volume};
}

}  // namespace uwsim
