#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace uwsim {

/// A part of a volume. Its second moment is the integral of d d^T, where d is the arm from its centroid.
struct VolumePart {
  double volume_m3 = 0;
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_moment_m5 = Eigen::Matrix3d::Zero();
};

/// A hull's volume, body frame: the whole, and 2, 4 and 8 slices of equal thickness along its longest side.
struct VolumeParts {
  std::array<std::vector<VolumePart>, 4> slices;
  double length_m = 0;  ///< of the longest side
  /// Inverse of the moment of inertia about the centroid, per unit density.
  Eigen::Matrix3d inverse_inertia_1_m5 = Eigen::Matrix3d::Zero();
  /// Three columns d such that six points at c + d and c - d, with equal weights, have the second moment of the whole.
  Eigen::Matrix3d spread_m = Eigen::Matrix3d::Zero();

  const VolumePart& whole() const { return slices[0].front(); }
};

/// A volume at a position, that of its centroid, and a rotation.
struct PlacedVolume {
  const VolumeParts& parts;
  const Eigen::Vector3d& centroid_world_m;
  const Eigen::Matrix3d& world_from_body;
};

}  // namespace uwsim
