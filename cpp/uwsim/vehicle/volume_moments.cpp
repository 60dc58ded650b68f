#include "uwsim/vehicle/volume_moments.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>

#include "uwsim/vehicle/cut_kernels.h"

namespace uwsim {
namespace {

constexpr std::size_t kClusterSize = 8;
// Size of a cell of planes, for a pitch of 1: the spacing of each component of `up`, and that of the level as a
// fraction of the mesh's radius. Small cells list few triangles; large cells stay valid for more steps of a moving
// body.
constexpr double kTiltPitch = 1.0 / 256;
constexpr double kLevelPitch = 1.0 / 128;
constexpr double kRounding = 1e-9;  // relative; exceeds the error of heights
constexpr std::size_t kRemembered = 8;

constexpr double kNear = 1.0 / 64;  // see PlaneCut::is_near

using Corners = std::array<Eigen::Vector3d, 3>;

/// The moments of the tetrahedron (origin, a, b, c).
VolumeMoments tetrahedron(const Corners& corners_m) {
  const auto& [a, b, c] = corners_m;
  const double volume_m3 = a.dot(b.cross(c)) / 6;
  const Eigen::Vector3d sum = a + b + c;
  return {volume_m3, volume_m3 / 4 * sum,
          volume_m3 / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose())};
}

double total(const double (&lanes)[kCutLanes]) {
  return ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
}

Eigen::Vector3d vector_total(const double (&lanes)[3][kCutLanes]) {
  return {total(lanes[0]), total(lanes[1]), total(lanes[2])};
}

/// The order of `lanes`: xx, yy, zz, xy, yz, zx.
Eigen::Matrix3d symmetric_total(const double (&lanes)[6][kCutLanes]) {
  const double xx = total(lanes[0]), yy = total(lanes[1]), zz = total(lanes[2]);
  const double xy = total(lanes[3]), yz = total(lanes[4]), zx = total(lanes[5]);
  Eigen::Matrix3d sum;
  sum << xx, xy, zx, xy, yy, yz, zx, yz, zz;
  return sum;
}

/// Orders triangles so that neighbours in space are neighbours in the list, by recursive bisection along the longest
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

CutVolume::CutVolume(const TriangleMesh& mesh, double pitch) : pitch_(pitch) {
  static std::atomic<std::uint64_t> made{0};
  number_ = ++made;
  std::vector<Triangle> triangles = mesh.triangles;
  sort_spatially(triangles, mesh);
  for (const Triangle& t : triangles) {
    triangles_m_.push_back({mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]});
    tetrahedra_.push_back(tetrahedron(triangles_m_.back()));
  }
  for (const Eigen::Vector3d& v : mesh.vertices_m) radius_m_ = std::max(radius_m_, v.norm());
  for (std::size_t k = 0; k < triangles_m_.size(); k += kClusterSize) {
    add_cluster(k, std::min(k + kClusterSize, triangles_m_.size()));
    whole_ += clusters_.back().moments;
  }
}

void CutVolume::add_cluster(std::size_t first, std::size_t last) {
  Cluster cluster;
  cluster.first = first;
  cluster.last = last;
  Eigen::Vector3d low = triangles_m_[first][0], high = low;
  for (std::size_t k = first; k < last; ++k) {
    cluster.moments += tetrahedra_[k];
    for (const Eigen::Vector3d& corner : triangles_m_[k]) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  cluster.middle_m = 0.5 * (low + high);
  cluster.half_size_m = 0.5 * (high - low);
  for (std::size_t k = first; k < last; ++k) {
    for (const Eigen::Vector3d& corner : triangles_m_[k])
      cluster.radius_m = std::max(cluster.radius_m, (corner - cluster.middle_m).norm());
  }
  clusters_.push_back(cluster);
}

/// All planes whose `up` and level round to the same values.
struct CutVolume::PlaneCell {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  double level_m = 0;
  std::uint64_t mesh = 0;

  bool operator==(const PlaneCell& other) const {
    return mesh == other.mesh && level_m == other.level_m && up == other.up;
  }
};

/// The triangles that matter to a cell of planes: the sum over those below all of the cell's planes, and a list of
/// those that some of its planes may cut. In large cells, triangles are grouped by their height, because blocks whose
/// triangles are all on the same side of a plane take little time.
struct CutVolume::Near {
  struct Group {
    std::vector<CutBlock> blocks;
    std::size_t count = 0;
  };
  PlaneCell cell;
  VolumeMoments below;
  std::array<Group, 5> groups;

  void clear() {
    below = {};
    for (Group& group : groups) {
      group.blocks.clear();
      group.count = 0;
    }
  }
  /// The group of a triangle whose corners are at these heights over the cell's central plane.
  static std::size_t group_of(double low_m, double high_m, double margin_m) {
    if (low_m > 0) return low_m > 0.5 * margin_m ? 4 : 3;
    if (high_m < 0) return high_m < -0.5 * margin_m ? 2 : 1;
    return 0;
  }
  void add(const Corners& corners_m, double volume_m3, std::size_t to) {
    auto& [blocks, count] = groups[to];
    const std::size_t lane = count++ % kCutLanes;
    if (lane == 0) blocks.emplace_back(CutBlock{});
    CutBlock& block = blocks.back();
    for (std::size_t k = 0; k < 9; ++k) block.corner_m[k][lane] = corners_m[k / 3].data()[k % 3];
    block.volume_m3[lane] = volume_m3;
  }
};

/// The cells that a thread used most recently.
struct CutVolume::Memory {
  std::array<Near, kRemembered> cells;
  std::size_t last = 0, oldest = 0, reserved = 0;

  /// Allocates for the largest mesh so far, so that steps do not allocate.
  void reserve(std::size_t triangles) {
    if (triangles <= reserved) return;
    reserved = triangles;
    for (Near& cell : cells) {
      for (Near::Group& group : cell.groups) group.blocks.reserve((triangles + kCutLanes - 1) / kCutLanes);
    }
  }
};

CutVolume::PlaneCell CutVolume::cell_of(const Eigen::Vector3d& up, double level_m) const {
  const auto rounded = [](double value, double pitch) { return std::nearbyint(value / pitch) * pitch; };
  const double tilt = pitch_ * kTiltPitch;
  return {{rounded(up.x(), tilt), rounded(up.y(), tilt), rounded(up.z(), tilt)},
          rounded(level_m, pitch_ * kLevelPitch * radius_m_),
          number_};
}

const CutVolume::Near& CutVolume::near(const PlaneCell& cell) const {
  static thread_local Memory memory;
  if (memory.cells[memory.last].cell == cell) return memory.cells[memory.last];
  for (std::size_t k = 0; k < kRemembered; ++k) {
    if (memory.cells[k].cell == cell) return memory.cells[memory.last = k];
  }
  memory.reserve(triangles_m_.size());
  memory.last = memory.oldest;
  memory.oldest = (memory.oldest + 1) % kRemembered;
  find_near(cell, memory.cells[memory.last]);
  return memory.cells[memory.last];
}

void CutVolume::find_near(const PlaneCell& cell, Near& near) const {
  near.clear();
  near.cell = cell;
  // The largest amount by which a point's height over any of the cell's planes differs from its height over the central
  // plane.
  const double margin_m =
      0.5 * pitch_ * (std::sqrt(3.0) * kTiltPitch + kLevelPitch) * radius_m_ * (1 + kRounding) + kRounding * radius_m_;
  for (const Cluster& cluster : clusters_) {
    const double middle_m = cell.up.dot(cluster.middle_m) - cell.level_m;
    const double half_m =
        std::min((1 + pitch_ * kTiltPitch) * cluster.radius_m, cell.up.cwiseAbs().dot(cluster.half_size_m));
    if (middle_m - half_m > margin_m) continue;
    if (middle_m + half_m < -margin_m) {
      near.below += cluster.moments;
      continue;
    }
    for (std::size_t k = cluster.first; k < cluster.last; ++k) {
      const auto& [a, b, c] = triangles_m_[k];
      const double heights_m[] = {cell.up.dot(a), cell.up.dot(b), cell.up.dot(c)};
      const auto [low_m, high_m] = std::minmax({heights_m[0], heights_m[1], heights_m[2]});
      if (low_m - cell.level_m > margin_m) continue;
      if (high_m - cell.level_m < -margin_m) {
        near.below += tetrahedra_[k];
      } else {
        const std::size_t group =
            pitch_ == 1 ? 0 : Near::group_of(low_m - cell.level_m, high_m - cell.level_m, margin_m);
        near.add(triangles_m_[k], tetrahedra_[k].volume_m3, group);
      }
    }
  }
}

VolumeMoments CutVolume::below(const Eigen::Vector3d& up, double level_m, bool with_second) const {
  const Near& near = this->near(cell_of(up, level_m));
  CutSums sums{};
  const CutKernels::Add add = with_second ? cut_kernels().add_with_second : cut_kernels().add;
  for (const Near::Group& group : near.groups)
    add(group.blocks.data(), group.blocks.size(), up.data(), level_m, sums, nullptr);
  VolumeMoments sum = near.below;
  sum.volume_m3 += total(sums.volume_m3);
  sum.first_m4 += vector_total(sums.first_m4);
  if (with_second) {
    sum.second_m5 += symmetric_total(sums.second_m5);
  } else {
    sum.second_m5.setZero();
  }
  return sum;
}

PlaneCut CutVolume::cut(const Eigen::Vector3d& up, double level_m) const {
  const Near& near = this->near(cell_of(up, level_m));
  CutSums sums{};
  FaceSums face{};
  for (const Near::Group& group : near.groups)
    cut_kernels().add_with_face(group.blocks.data(), group.blocks.size(), up.data(), level_m, sums, &face);
  PlaneCut cut{up, level_m, near.below, 0.5 * total(face.zeroth_m2), {}, {}};
  cut.below += {total(sums.volume_m3), vector_total(sums.first_m4), symmetric_total(sums.second_m5)};
  const Eigen::Vector3d foot_m = level_m * up, edges_m3 = vector_total(face.first_m3);
  cut.area_first_m3 = (2 * cut.area_m2 * foot_m + edges_m3) / 6;
  cut.area_second_m4 = (4 * cut.area_m2 * foot_m * foot_m.transpose() + foot_m * edges_m3.transpose() +
                        edges_m3 * foot_m.transpose() + symmetric_total(face.second_m4)) /
                       24;
  return cut;
}

bool PlaneCut::is_near(const Eigen::Vector3d& other_up, double other_level_m, double radius_m) const {
  const double shift_m = std::abs(other_level_m - level_m) + radius_m * (other_up - up).norm();
  return area_m2 * shift_m <= kNear * below.volume_m3;
}

VolumeMoments PlaneCut::moved_to(const Eigen::Vector3d& other_up, double other_level_m) const {
  if (area_m2 <= 0) return below;
  // A point r of the face is other_level - other_up . r below the other plane. About the face's centroid, the second
  // moment changes by that of the mean.
  const Eigen::Vector3d centre_m = area_first_m3 / area_m2;
  const double volume_m3 = other_level_m * area_m2 - other_up.dot(area_first_m3);
  const Eigen::Vector3d first_m4 = other_level_m * area_first_m3 - area_second_m4 * other_up;
  const Eigen::Matrix3d second_m4 = area_second_m4 - area_first_m3 * centre_m.transpose();
  const Eigen::Vector3d about_centre_m4 = first_m4 - volume_m3 * centre_m;
  VolumeMoments moved = below;
  moved += {volume_m3, first_m4,
            volume_m3 / area_m2 * second_m4 + centre_m * first_m4.transpose() + about_centre_m4 * centre_m.transpose()};
  return moved;
}

}  // namespace uwsim
