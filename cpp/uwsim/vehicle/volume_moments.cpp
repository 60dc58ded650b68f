#include "uwsim/vehicle/volume_moments.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>

namespace uwsim {
namespace {

using Corners = std::array<Eigen::Vector3d, 3>;

constexpr std::size_t kClusterSize = 16;

/// Adds the tetrahedron of the origin, a, b, c.
struct TetrahedronSum {
  VolumeMoments moments;
  bool with_second;

  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const double det = a.dot(b.cross(c));
    const Eigen::Vector3d sum = a + b + c;
    moments.volume_m3 += det / 6;
    moments.first_m4 += det / 24 * sum;
    if (!with_second) return;
    moments.second_m5 +=
        det / 120 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
};

/// A triangle's corners and their heights over the plane.
struct Facing {
  Corners corner;
  std::array<double, 3> height_m;

  void turn() {
    corner = {corner[1], corner[2], corner[0]};
    height_m = {height_m[1], height_m[2], height_m[0]};
  }
  /// Where the edge from the wet corner (height < 0) to the dry one pierces the plane: the same for both its triangles.
  Eigen::Vector3d pierce(std::size_t wet, std::size_t dry) const {
    return corner[wet] + height_m[wet] / (height_m[wet] - height_m[dry]) * (corner[dry] - corner[wet]);
  }
};

/// Adds the wet part of a triangle with one or two wet corners, and its share of the cut face, seen from `foot`.
void add_cut(TetrahedronSum& sum, Facing t, bool one_is_wet, const Eigen::Vector3d& foot) {
  // Turn the triangle, keeping its winding, so that the corner that differs from the other two comes first.
  while ((t.height_m[0] < 0) != one_is_wet || (t.height_m[1] < 0) == one_is_wet) t.turn();
  if (one_is_wet) {
    const Eigen::Vector3d p = t.pierce(0, 1), q = t.pierce(0, 2);
    sum.add(t.corner[0], p, q);
    return sum.add(foot, q, p);
  }
  const Eigen::Vector3d p = t.pierce(1, 0), q = t.pierce(2, 0);
  sum.add(p, t.corner[1], t.corner[2]);
  sum.add(p, t.corner[2], q);
  sum.add(foot, p, q);
}

/// Orders triangles so that neighbours in space are neighbours in the list: halved across the longest side, to the end.
void sort_by_place(std::span<Triangle> triangles, const TriangleMesh& mesh) {
  if (triangles.size() <= kClusterSize) return;
  const auto middle = [&mesh](const Triangle& t) -> Eigen::Vector3d {
    return mesh.vertices_m[t[0]] + mesh.vertices_m[t[1]] + mesh.vertices_m[t[2]];
  };
  Eigen::Vector3d low = middle(triangles[0]), high = low;
  for (const Triangle& t : triangles) {
    low = low.cwiseMin(middle(t));
    high = high.cwiseMax(middle(t));
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t half = (triangles.size() / kClusterSize + 1) / 2 * kClusterSize;
  std::nth_element(triangles.begin(), triangles.begin() + static_cast<std::ptrdiff_t>(half), triangles.end(),
                   [&](const Triangle& a, const Triangle& b) { return middle(a)(axis) < middle(b)(axis); });
  sort_by_place(triangles.first(half), mesh);
  sort_by_place(triangles.subspan(half), mesh);
}

}  // namespace

VolumeMoments& VolumeMoments::operator+=(const VolumeMoments& other) {
  volume_m3 += other.volume_m3;
  first_m4 += other.first_m4;
  second_m5 += other.second_m5;
  return *this;
}

CutVolume::CutVolume(const TriangleMesh& mesh) : triangles_(mesh.triangles) {
  sort_by_place(triangles_, mesh);
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    x_m_.push_back(v.x());
    y_m_.push_back(v.y());
    z_m_.push_back(v.z());
  }
  for (const Triangle& t : triangles_) {
    TetrahedronSum one{.moments = {}, .with_second = true};
    one.add(mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]);
    facets_.push_back({one.moments.volume_m3, one.moments.first_m4});
    facet_seconds_m5_.push_back(one.moments.second_m5);
  }
  for (std::size_t k = 0; k < triangles_.size(); k += kClusterSize) {
    add_cluster(k, std::min(k + kClusterSize, triangles_.size()), mesh);
    whole_ += clusters_.back().moments;
  }
}

void CutVolume::add_cluster(std::size_t first, std::size_t last, const TriangleMesh& mesh) {
  Cluster cluster{first, last, Eigen::Vector3d::Zero(), 0, {}};
  Eigen::Vector3d low = mesh.vertices_m[triangles_[first][0]], high = low;
  for (std::size_t k = first; k < last; ++k) {
    cluster.moments += {facets_[k].volume_m3, facets_[k].first_m4, facet_seconds_m5_[k]};
    for (const std::uint32_t v : triangles_[k]) {
      low = low.cwiseMin(mesh.vertices_m[v]);
      high = high.cwiseMax(mesh.vertices_m[v]);
    }
  }
  cluster.middle_m = 0.5 * (low + high);
  for (std::size_t k = first; k < last; ++k) {
    for (const std::uint32_t v : triangles_[k]) {
      cluster.radius_m = std::max(cluster.radius_m, (mesh.vertices_m[v] - cluster.middle_m).norm());
    }
  }
  clusters_.push_back(cluster);
}

VolumeMoments CutVolume::below(const Eigen::Vector3d& up, double level_m, bool with_second) const {
  static thread_local std::vector<double> scratch;
  if (scratch.size() < x_m_.size()) scratch.resize(x_m_.size());
  double* const height = scratch.data();
  const double ux = up.x(), uy = up.y(), uz = up.z();
  for (std::size_t k = 0; k < x_m_.size(); ++k) height[k] = ux * x_m_[k] + uy * y_m_[k] + uz * z_m_[k] - level_m;

  const Eigen::Vector3d foot = level_m * up;
  TetrahedronSum sum{.moments = {}, .with_second = with_second};
  const auto corner = [&](std::uint32_t v) { return Eigen::Vector3d(x_m_[v], y_m_[v], z_m_[v]); };
  const auto add_one = [&](std::size_t k) {
    const auto [a, b, c] = triangles_[k];
    const int wet = (height[a] < 0) + (height[b] < 0) + (height[c] < 0);
    if (wet == 0) return;
    if (wet == 3) {
      sum.moments.volume_m3 += facets_[k].volume_m3;
      sum.moments.first_m4 += facets_[k].first_m4;
      if (with_second) sum.moments.second_m5 += facet_seconds_m5_[k];
    } else {
      add_cut(sum, {{corner(a), corner(b), corner(c)}, {height[a], height[b], height[c]}}, wet == 1, foot);
    }
  };
  for (const Cluster& cluster : clusters_) {
    const double over = up.dot(cluster.middle_m) - level_m;
    if (over >= cluster.radius_m) continue;
    if (over > -cluster.radius_m) {
      for (std::size_t k = cluster.first; k < cluster.last; ++k) add_one(k);
      continue;
    }
    sum.moments.volume_m3 += cluster.moments.volume_m3;
    sum.moments.first_m4 += cluster.moments.first_m4;
    if (with_second) sum.moments.second_m5 += cluster.moments.second_m5;
  }
  return sum.moments;
}

}  // namespace uwsim
