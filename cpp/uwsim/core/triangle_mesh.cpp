#include "uwsim/core/triangle_mesh.h"

#include <cmath>
#include <numbers>
#include <string>
#include <unordered_map>

#include "uwsim/core/check.h"

namespace uwsim {

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

SolidProperties solid_properties(const TriangleMesh& mesh) {
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // integral of x x^T over the volume, about the origin
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    const Eigen::Vector3d& b = mesh.vertices_m[t[1]];
    const Eigen::Vector3d& c = mesh.vertices_m[t[2]];
    const double det = a.dot(b.cross(c));
    const Eigen::Vector3d sum = a + b + c;
    volume += det / 6;
    first += det / 24 * sum;
    second += det / 120 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  SolidProperties solid;
  solid.volume_m3 = volume;
  if (volume == 0) return solid;
  solid.centroid_m = first / volume;
  const Eigen::Matrix3d about_centroid = second - volume * solid.centroid_m * solid.centroid_m.transpose();
  solid.inertia_per_density_m5 = about_centroid.trace() * Eigen::Matrix3d::Identity() - about_centroid;
  return solid;
}

double winding_number(const TriangleMesh& mesh, const Eigen::Vector3d& point_m) {
  double half_angles = 0;
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_m[t[0]] - point_m, b = mesh.vertices_m[t[1]] - point_m,
                          c = mesh.vertices_m[t[2]] - point_m;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    half_angles += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return half_angles / (2 * std::numbers::pi);
}

void require_well_formed(const TriangleMesh& mesh, std::string_view path) {
  const std::string name(path);
  require(!mesh.triangles.empty(), name + ".triangles", mesh.triangles.size(), "must hold at least one triangle");
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    require(v.allFinite(), name + ".vertices_m", v.transpose(), "must be finite");
  }
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t index : t) {
      require(index < mesh.vertices_m.size(), name + ".triangles", index, "must be the index of a vertex");
    }
  }
}

void require_closed(const TriangleMesh& mesh, std::string_view path) {
  require_well_formed(mesh, path);
  std::unordered_map<std::uint64_t, int> uses;  // by directed edge
  const auto key = [](std::uint32_t from, std::uint32_t to) { return (std::uint64_t{from} << 32) | to; };
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++uses[key(t[k], t[(k + 1) % 3])];
  }
  std::size_t bad = 0;
  for (const auto& [edge, count] : uses) {
    const auto back = uses.find((edge << 32) | (edge >> 32));
    if (back == uses.end() || back->second != count) ++bad;
  }
  require(bad == 0, std::string(path) + ".open_edges", bad, "must be 0: the mesh must be closed");
  const double volume = solid_properties(mesh).volume_m3;
  require(volume > 0, std::string(path) + ".volume_m3", volume, "must be positive: triangles must wind outward");
}

}  // namespace uwsim
