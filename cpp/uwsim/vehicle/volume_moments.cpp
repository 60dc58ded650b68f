#include "uwsim/vehicle/volume_moments.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>

namespace uwsim {
namespace {

constexpr std::size_t kClusterSize = 8;

/// The integral of r r^T over the tetrahedron of the origin, a, b, c.
Eigen::Matrix3d spread(double volume_m3, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d sum = a + b + c;
  return volume_m3 / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
}

/// The corners of a cut triangle, turned so that the one alone on its side of the plane comes first, and the sign of
/// its piece: + where that is wet. By the bits of the wet corners.
struct Turned {
  std::uint32_t first, second, third;
  double sign;
};
constexpr std::array<Turned, 8> kTurned = {
    {{}, {0, 1, 2, 1}, {1, 2, 0, 1}, {2, 0, 1, -1}, {2, 0, 1, 1}, {1, 2, 0, -1}, {0, 1, 2, -1}, {}}};

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
    const Eigen::Vector3d &a = mesh.vertices_m[t[0]], &b = mesh.vertices_m[t[1]], &c = mesh.vertices_m[t[2]];
    const double volume_m3 = a.dot(b.cross(c)) / 6;
    facets_.push_back({volume_m3, volume_m3 / 4 * (a + b + c)});
    facet_seconds_m5_.push_back(spread(volume_m3, a, b, c));
  }
  for (std::size_t k = 0; k < triangles_.size(); k += kClusterSize) {
    add_cluster(static_cast<std::uint32_t>(k),
                static_cast<std::uint32_t>(std::min(k + kClusterSize, triangles_.size())), mesh);
    whole_ += clusters_.back().moments;
  }
}

void CutVolume::add_cluster(std::uint32_t first, std::uint32_t last, const TriangleMesh& mesh) {
  Cluster cluster;
  cluster.first = first;
  cluster.last = last;
  Eigen::Vector3d low = mesh.vertices_m[triangles_[first][0]], high = low;
  for (std::uint32_t k = first; k < last; ++k) {
    cluster.moments += {facets_[k].volume_m3, facets_[k].first_m4, facet_seconds_m5_[k]};
    for (const std::uint32_t v : triangles_[k]) {
      low = low.cwiseMin(mesh.vertices_m[v]);
      high = high.cwiseMax(mesh.vertices_m[v]);
    }
  }
  cluster.middle_m = 0.5 * (low + high);
  cluster.half_size_m = 0.5 * (high - low);
  for (std::uint32_t k = first; k < last; ++k) {
    for (const std::uint32_t v : triangles_[k]) {
      cluster.radius_m = std::max(cluster.radius_m, (mesh.vertices_m[v] - cluster.middle_m).norm());
    }
  }
  clusters_.push_back(cluster);
}

/// Kept by each thread to spare allocation.
struct CutVolume::Scratch {
  std::vector<double> height_m;        // over the plane, of the vertices
  std::vector<std::uint8_t> is_below;  // 1: lower
  std::vector<CutTriangle> cut;
};

VolumeMoments CutVolume::below(const Eigen::Vector3d& up, double level_m, bool with_second) const {
  static thread_local Scratch scratch;
  if (scratch.height_m.size() < x_m_.size()) {
    scratch.height_m.resize(x_m_.size());
    scratch.is_below.resize(x_m_.size());
  }
  if (scratch.cut.size() < triangles_.size()) scratch.cut.resize(triangles_.size());
  double* const height = scratch.height_m.data();
  std::uint8_t* const is_below = scratch.is_below.data();
  CutTriangle* const cut = scratch.cut.data();
  const double ux = up.x(), uy = up.y(), uz = up.z();
  for (std::size_t k = 0; k < x_m_.size(); ++k) height[k] = ux * x_m_[k] + uy * y_m_[k] + uz * z_m_[k] - level_m;
  for (std::size_t k = 0; k < x_m_.size(); ++k) is_below[k] = height[k] < 0;

  VolumeMoments sum;
  std::size_t cut_count = 0;
  const auto look_at = [&](std::uint32_t k) {
    const auto [a, b, c] = triangles_[k];
    const std::uint32_t wet_corners = is_below[a] + 2u * is_below[b] + 4u * is_below[c];
    cut[cut_count] = {k, wet_corners};
    cut_count += wet_corners != 0 && wet_corners != 7;
    // As if all of it were wet, where most is: of two wet corners the cut takes the third away.
    if (is_below[a] + is_below[b] + is_below[c] < 2) return;
    sum.volume_m3 += facets_[k].volume_m3;
    sum.first_m4 += facets_[k].first_m4;
    if (with_second) sum.second_m5 += facet_seconds_m5_[k];
  };
  for (const Cluster& cluster : clusters_) {
    const double over = up.dot(cluster.middle_m) - level_m;
    const double reach_m = std::min(cluster.radius_m, up.cwiseAbs().dot(cluster.half_size_m));
    if (over >= reach_m) continue;
    if (over > -reach_m) {
      for (std::uint32_t k = cluster.first; k < cluster.last; ++k) look_at(k);
      continue;
    }
    sum.volume_m3 += cluster.moments.volume_m3;
    sum.first_m4 += cluster.moments.first_m4;
    if (with_second) sum.second_m5 += cluster.moments.second_m5;
  }
  const std::span<const CutTriangle> cuts(cut, cut_count);
  sum += with_second ? change_by_cut<true>(cuts, height, up, level_m) : change_by_cut<false>(cuts, height, up, level_m);
  return sum;
}

/// What the cut changes of whole triangles with two wet corners or more: the odd corner's piece, added where it is wet
/// and taken away where it is dry, with the cut face's share, seen from its foot. The piece is the triangle's
/// tetrahedron with two of its edges shortened to where they pierce the plane. Both edges are worked out side by side.
template <bool kWithSecond>
VolumeMoments CutVolume::change_by_cut(std::span<const CutTriangle> cut, const double* height_m,
                                       const Eigen::Vector3d& up, double level_m) const {
  using Pair = Eigen::Array2d;
  const Eigen::Vector3d foot = level_m * up;
  VolumeMoments sum;
  for (const auto& [k, wet_corners] : cut) {
    const auto& [first, second, third, sign] = kTurned[wet_corners];
    const Triangle& t = triangles_[k];
    const std::uint32_t a = t[first], b = t[second], c = t[third];
    const Pair share = height_m[a] / (height_m[a] - Pair(height_m[b], height_m[c]));
    const Pair x = x_m_[a] + share * (Pair(x_m_[b], x_m_[c]) - x_m_[a]);
    const Pair y = y_m_[a] + share * (Pair(y_m_[b], y_m_[c]) - y_m_[a]);
    const Pair z = z_m_[a] + share * (Pair(z_m_[b], z_m_[c]) - z_m_[a]);
    const double piece = sign * share[0] * share[1] * facets_[k].volume_m3;
    // Of the tetrahedron origin, foot, q, p: up . (q x p) times the foot's distance.
    const double face = sign * level_m / 6 *
                        (up.x() * (z[0] * y[1] - y[0] * z[1]) + up.y() * (x[0] * z[1] - z[0] * x[1]) +
                         up.z() * (y[0] * x[1] - x[0] * y[1]));
    sum.volume_m3 += piece + face;
    const Eigen::Vector3d corner(x_m_[a], y_m_[a], z_m_[a]), pierced(x.sum(), y.sum(), z.sum());
    sum.first_m4 += 0.25 * (piece * (corner + pierced) + face * (foot + pierced));
    if constexpr (kWithSecond) {
      const Eigen::Vector3d p(x[0], y[0], z[0]), q(x[1], y[1], z[1]);
      sum.second_m5 += spread(piece, corner, p, q) + spread(face, foot, p, q);
    }
  }
  return sum;
}

}  // namespace uwsim
