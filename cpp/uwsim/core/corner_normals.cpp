#include "uwsim/core/corner_normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace uwsim {
namespace {

constexpr std::size_t kMostAround = 64;  // a vertex with more triangles, such as a fan's tip, stays as it is
constexpr double kFlat = 1 - 1e-6;       // cosine between a facet's normal and its corners'

struct Corner {
  std::uint32_t triangle;
  int which;
  Eigen::Vector3d at;
};

double angle_at(const std::array<Eigen::Vector3d, 3>& corners, int which) {
  const auto corner = [&](int k) -> const Eigen::Vector3d& { return corners[static_cast<std::size_t>(k % 3)]; };
  const Eigen::Vector3d a = corner(which + 1) - corner(which), b = corner(which + 2) - corner(which);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

CornerNormals::CornerNormals(const TriangleMesh& mesh) : normals_(mesh.triangles.size()) {
  std::vector<Eigen::Vector3d> facets(mesh.triangles.size());
  std::vector<Corner> all;
  all.reserve(3 * facets.size());
  for (std::uint32_t t = 0; t < facets.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3d& from = mesh.vertices_m[a];
    facets[t] = (mesh.vertices_m[b] - from).cross(mesh.vertices_m[c] - from).stableNormalized();
    normals_[t].fill(facets[t].cast<float>());
    for (int k = 0; k < 3; ++k) all.push_back({t, k, mesh.vertices_m[mesh.triangles[t][static_cast<std::size_t>(k)]]});
  }
  std::ranges::stable_sort(all, [](const Corner& one, const Corner& other) {
    return std::lexicographical_compare(one.at.data(), one.at.data() + 3, other.at.data(), other.at.data() + 3);
  });
  const double crease = std::cos(kCrease_rad);
  for (auto first = all.begin(); first != all.end();) {
    const auto last = std::find_if(first, all.end(), [&](const Corner& each) { return each.at != first->at; });
    if (static_cast<std::size_t>(last - first) <= kMostAround) {
      for (auto own = first; own != last; ++own) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (auto other = first; other != last; ++other) {
          if (facets[other->triangle].dot(facets[own->triangle]) < crease) continue;
          const auto& [a, b, c] = mesh.triangles[other->triangle];
          sum += angle_at({mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]}, other->which) *
                 facets[other->triangle];
        }
        if (!(sum.norm() > 0)) continue;
        const Eigen::Vector3d normal = sum.normalized();
        normals_[own->triangle][static_cast<std::size_t>(own->which)] = normal.cast<float>();
        bend_ = bend_ || normal.dot(facets[own->triangle]) < kFlat;
      }
    }
    first = last;
  }
}

SmoothPlace CornerNormals::at(std::uint32_t triangle, float u, float v,
                              const std::array<Eigen::Vector3f, 3>& corners) const {
  const std::array<Eigen::Vector3f, 3>& normals = normals_[triangle];
  const std::array<float, 3> share = {1 - u - v, u, v};
  const Eigen::Vector3f point = share[0] * corners[0] + share[1] * corners[1] + share[2] * corners[2];
  SmoothPlace place;
  for (std::size_t k = 0; k < 3; ++k) {
    place.normal += share[k] * normals[k];
    place.rise_m += share[k] * std::max(0.0f, (corners[k] - point).dot(normals[k]));
  }
  place.normal.normalize();
  return place;
}

}  // namespace uwsim
