#include "uwsim/vehicle/volume_moments.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>

namespace uwsim {
namespace {

constexpr std::size_t kClusterSize = 8;

/// The integral of r r^T over the tetrahedron (origin, a, b, c).
Eigen::Matrix3d second_moment(double volume_m3, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const Eigen::Vector3d& c) {
  const Eigen::Vector3d sum = a + b + c;
  return volume_m3 / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
}

/// The corners of a cut triangle, rotated so that the one that is alone on its side of the plane comes first, and the
/// sign of its piece: + where it is wet. Indexed by the bits of the wet corners.
struct Rotated {
  std::uint32_t first, second, third;
  double sign;
};
constexpr std::array<Rotated, 8> kRotated = {
    {{}, {0, 1, 2, 1}, {1, 2, 0, 1}, {2, 0, 1, -1}, {2, 0, 1, 1}, {1, 2, 0, -1}, {0, 1, 2, -1}, {}}};

/// Orders triangles so that neighbours in space are neighbours in the list, by repeated halving across the longest
/// side.
void sort_spatially(std::span<Triangle> triangles, const TriangleMesh& mesh) {
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
  sort_spatially(triangles.first(half), mesh);
  sort_spatially(triangles.subspan(half), mesh);
}

}  // namespace

VolumeMoments& VolumeMoments::operator+=(const VolumeMoments& other) {
  volume_m3 += other.volume_m3;
  first_m4 += other.first_m4;
  second_m5 += other.second_m5;
  return *this;
}

CutVolume::CutVolume(const TriangleMesh& mesh) : triangles_(mesh.triangles) {
  sort_spatially(triangles_, mesh);
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    x_m_.push_back(v.x());
    y_m_.push_back(v.y());
    z_m_.push_back(v.z());
  }
  for (const Triangle& t : triangles_) {
    const Eigen::Vector3d &a = mesh.vertices_m[t[0]], &b = mesh.vertices_m[t[1]], &c = mesh.vertices_m[t[2]];
    const double volume_m3 = a.dot(b.cross(c)) / 6;
    facets_.push_back({volume_m3, volume_m3 / 4 * (a + b + c)});
    facet_seconds_m5_.push_back(second_moment(volume_m3, a, b, c));
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

/// Each thread keeps one, so that steps allocate nothing.
struct CutVolume::Scratch {
  std::vector<double> height_m;  // of the vertices over the plane
  std::vector<CutTriangle> cut;
};

VolumeMoments CutVolume::below(const Eigen::Vector3d& up, double level_m, bool with_second) const {
  static thread_local Scratch scratch;
  if (scratch.height_m.size() < x_m_.size()) scratch.height_m.resize(x_m_.size());
  if (scratch.cut.size() < triangles_.size()) scratch.cut.resize(triangles_.size());
  double* const height = scratch.height_m.data();
  CutTriangle* const cut = scratch.cut.data();
  const double ux = up.x(), uy = up.y(), uz = up.z();
  for (std::size_t k = 0; k < x_m_.size(); ++k) height[k] = ux * x_m_[k] + uy * y_m_[k] + uz * z_m_[k] - level_m;

  VolumeMoments sum;
  std::size_t cut_count = 0;
  const auto examine = [&](std::uint32_t k) {
    const auto [a, b, c] = triangles_[k];
    const std::uint32_t wet[] = {height[a] < 0, height[b] < 0, height[c] < 0};
    const std::uint32_t wet_corners = wet[0] + 2 * wet[1] + 4 * wet[2];
    cut[cut_count] = {k, wet_corners};
    cut_count += wet_corners != 0 && wet_corners != 7;
    // A triangle with two wet corners counts as wholly wet; correction_for_cut() takes the dry corner away. A factor,
    // not a branch that the CPU would mispredict.
    const double counts = wet[0] + wet[1] + wet[2] >= 2;
    sum.volume_m3 += counts * facets_[k].volume_m3;
    sum.first_m4 += counts * facets_[k].first_m4;
    if (with_second) sum.second_m5 += counts * facet_seconds_m5_[k];
  };
  for (const Cluster& cluster : clusters_) {
    const double middle_height_m = up.dot(cluster.middle_m) - level_m;
    const double half_height_m = std::min(cluster.radius_m, up.cwiseAbs().dot(cluster.half_size_m));
    if (middle_height_m >= half_height_m) continue;
    if (middle_height_m > -half_height_m) {
      for (std::uint32_t k = cluster.first; k < cluster.last; ++k) examine(k);
      continue;
    }
    sum.volume_m3 += cluster.moments.volume_m3;
    sum.first_m4 += cluster.moments.first_m4;
    if (with_second) sum.second_m5 += cluster.moments.second_m5;
  }
  const std::span<const CutTriangle> cuts(cut, cut_count);
  sum += with_second ? correction_for_cut<true>(cuts, height, up, level_m)
                     : correction_for_cut<false>(cuts, height, up, level_m);
  return sum;
}

/// The difference between cut triangles and what below() counts for them, a whole triangle where two corners are wet
/// and none where one is: the piece at the odd corner, added where it is wet and subtracted where it is dry, and its
/// share of the cut face. The piece is the triangle's tetrahedron with two edges shortened to where they pierce the
/// plane; both edges are computed side by side.
template <bool kWithSecond>
VolumeMoments CutVolume::correction_for_cut(std::span<const CutTriangle> cut, const double* height_m,
                                            const Eigen::Vector3d& up, double level_m) const {
  using Pair = Eigen::Array2d;
  const Eigen::Vector3d foot = level_m * up;
  VolumeMoments sum;
  for (const auto& [k, wet_corners] : cut) {
    const auto& [first, second, third, sign] = kRotated[wet_corners];
    const Triangle& t = triangles_[k];
    const std::uint32_t a = t[first], b = t[second], c = t[third];
    const Pair share = height_m[a] / (height_m[a] - Pair(height_m[b], height_m[c]));
    const Pair x = x_m_[a] + share * (Pair(x_m_[b], x_m_[c]) - x_m_[a]);
    const Pair y = y_m_[a] + share * (Pair(y_m_[b], y_m_[c]) - y_m_[a]);
    const Pair z = z_m_[a] + share * (Pair(z_m_[b], z_m_[c]) - z_m_[a]);
    const double piece = sign * share[0] * share[1] * facets_[k].volume_m3;
    // Volume of the tetrahedron (origin, foot, q, p): up . (q x p) times the foot's distance over 6.
    const double face = sign * level_m / 6 *
                        (up.x() * (z[0] * y[1] - y[0] * z[1]) + up.y() * (x[0] * z[1] - z[0] * x[1]) +
                         up.z() * (y[0] * x[1] - x[0] * y[1]));
    sum.volume_m3 += piece + face;
    const Eigen::Vector3d corner(x_m_[a], y_m_[a], z_m_[a]), pierced(x.sum(), y.sum(), z.sum());
    sum.first_m4 += 0.25 * (piece * (corner + pierced) + face * (foot + pierced));
    if constexpr (kWithSecond) {
      const Eigen::Vector3d p(x[0], y[0], z[0]), q(x[1], y[1], z[1]);
      sum.second_m5 += second_moment(piece, corner, p, q) + second_moment(face, foot, p, q);
    }
  }
  return sum;
}

}  // namespace uwsim
