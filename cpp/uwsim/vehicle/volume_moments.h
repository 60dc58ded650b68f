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

/// The moments of the part of a closed mesh below a plane.
///
/// They are the sum over signed tetrahedra from the origin to the triangles, each cut at the plane, and to the cut
/// face, a fan of triangles from the foot of the origin on the plane to the edges of the cut. The moments of whole
/// triangles and of whole clusters of neighbouring triangles are tabulated, so that only the triangles near the plane
/// are examined one by one.
class CutVolume {
 public:
  CutVolume() = default;
  /// `mesh` must be closed; for accuracy its middle should be near the origin.
  explicit CutVolume(const TriangleMesh& mesh);

  /// The moments of the whole volume.
  const VolumeMoments& whole() const { return whole_; }
  /// The moments of the points r with up . r < level. `up` is a unit vector. The second moment is 0 unless
  /// `with_second`.
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
    std::uint32_t wet_corners;  ///< one bit each; neither none nor all of them
  };
  struct Scratch;

  void add_cluster(std::uint32_t first, std::uint32_t last, const TriangleMesh& mesh);
  template <bool kWithSecond>
  VolumeMoments correction_for_cut(std::span<const CutTriangle> cut, const double* height_m, const Eigen::Vector3d& up,
                                   double level_m) const;

  std::vector<double> x_m_, y_m_, z_m_;  // vertices, by coordinate: heights over a plane are computed by vector code
  std::vector<Triangle> triangles_;
  std::vector<Facet> facets_;
  std::vector<Eigen::Matrix3d> facet_seconds_m5_;
  std::vector<Cluster> clusters_;
  VolumeMoments whole_;
};

}  // namespace uwsim
