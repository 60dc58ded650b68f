#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
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

/// The part of a volume below the plane up . r = level, and the face that the plane cuts.
struct PlaneCut {
  Eigen::Vector3d up;
  double level_m;
  VolumeMoments below;
  double area_m2;                  ///< of the face
  Eigen::Vector3d area_first_m3;   ///< the integral of r over the face
  Eigen::Matrix3d area_second_m4;  ///< the integral of r r^T over the face

  /// Returns true if another plane, within `radius_m` of the origin, changes the volume by less than 1/64.
  bool is_near(const Eigen::Vector3d& other_up, double other_level_m, double radius_m) const;
  /// The moments below a plane that is near, to first order in what lies between the planes; of the second moment, the
  /// part of the third moments of the face about its centroid is left out.
  VolumeMoments moved_to(const Eigen::Vector3d& other_up, double other_level_m) const;
};

/// Computes moments of the part of a closed mesh below a plane.
///
/// The moments are summed over signed tetrahedra from the origin to the triangles, each cut at the plane, and to the
/// cut face, which is a fan of triangles from the foot of the origin on the plane to the edges of the cut. Planes are
/// sorted into cells of nearly equal tilt and level. For each cell, the sum over the triangles below all of its planes
/// and the list of triangles that some of its planes cut are computed once; only the listed triangles are summed for
/// each plane. Each thread caches the cells that it used most recently. Cached data depend only on the cell, so the
/// cache does not affect the result.
class CutVolume {
 public:
  CutVolume() = default;
  /// `mesh` must be closed; for accuracy, its middle should be near the origin. `pitch` is the size of the cells:
  /// larger cells suit planes that move faster, such as the surface of waves.
  explicit CutVolume(const TriangleMesh& mesh, double pitch = 1);

  /// The moments of the whole volume.
  const VolumeMoments& whole() const { return whole_; }
  /// The moments of the region up . r < level. `up` is a unit vector. The second moment is 0 unless `with_second`.
  VolumeMoments below(const Eigen::Vector3d& up, double level_m, bool with_second) const;
  /// The same with the second moment, and the face.
  PlaneCut cut(const Eigen::Vector3d& up, double level_m) const;

 private:
  /// Neighbouring triangles from `first` up to `last`, with a bounding sphere and a bounding box.
  struct Cluster {
    std::size_t first = 0, last = 0;
    Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d half_size_m = Eigen::Vector3d::Zero();
    double radius_m = 0;
    VolumeMoments moments;
  };
  struct PlaneCell;
  struct Near;
  struct Memory;

  PlaneCell cell_of(const Eigen::Vector3d& up, double level_m) const;
  const Near& near(const PlaneCell& cell) const;
  void find_near(const PlaneCell& cell, Near& near) const;
  void add_cluster(std::size_t first, std::size_t last);

  std::uint64_t number_ = 0;                                 // unique to this mesh; shared by copies
  std::vector<std::array<Eigen::Vector3d, 3>> triangles_m_;  // neighbours in space are also neighbours in the list
  std::vector<VolumeMoments> tetrahedra_;                    // from the origin to each of them
  std::vector<Cluster> clusters_;
  VolumeMoments whole_;
  double pitch_ = 1;
  double radius_m_ = 0;  // of a sphere about the origin that encloses the mesh
};

}  // namespace uwsim
