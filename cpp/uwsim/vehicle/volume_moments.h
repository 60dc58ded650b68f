#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// The integrals of 1, r and r r^T over a volume.
struct VolumeMoments {
  double volume_m3 = 0;
  Eigen::Vector3d first_m4 = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_m5 = Eigen::Matrix3d::Zero();

  VolumeMoments& operator+=(const VolumeMoments& other);
};

/// The moments of what lies of a closed mesh on the lower side of a plane.
///
/// Sum of signed tetrahedra from the origin over the triangles, each cut at the plane, and over the cut face, which is
/// a fan of triangles from the origin's foot on the plane to the edges of the cut. What whole triangles add is tabled,
/// and what whole clusters of neighbouring triangles add, so that only those near the plane are looked at one by one.
class CutVolume {
 public:
  CutVolume() = default;
  /// `mesh` is closed; its middle should be near the origin, for accuracy.
  explicit CutVolume(const TriangleMesh& mesh);

  const VolumeMoments& whole() const { return whole_; }
  /// Of the points r with up . r < level. `up` is a unit vector. The second moment only if asked for.
  VolumeMoments below(const Eigen::Vector3d& up, double level_m, bool with_second) const;

 private:
  struct Facet {
    double volume_m3;
    Eigen::Vector3d first_m4;
  };
  /// Neighbouring triangles from `first` up to `last`, inside a sphere and a box.
  struct Cluster {
    std::uint32_t first = 0, last = 0;
    Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d half_size_m = Eigen::Vector3d::Zero();
    double radius_m = 0;
    VolumeMoments moments;
  };
  struct CutTriangle {
    std::uint32_t triangle;
    std::uint32_t wet_corners;  ///< bits; neither none nor all
  };
  struct Scratch;

  void add_cluster(std::uint32_t first, std::uint32_t last, const TriangleMesh& mesh);
  template <bool kWithSecond>
  VolumeMoments change_by_cut(std::span<const CutTriangle> cut, const double* height_m, const Eigen::Vector3d& up,
                              double level_m) const;

  std::vector<double> x_m_, y_m_, z_m_;  // of the vertices, so that heights are vector code
  std::vector<Triangle> triangles_;
  std::vector<Facet> facets_;
  std::vector<Eigen::Matrix3d> facet_seconds_m5_;
  std::vector<Cluster> clusters_;
  VolumeMoments whole_;
};

}  // namespace uwsim
