#pragma once

#include <Eigen/Core>
#include <array>

namespace uwsim {

/// A flat triangle that carries sources or dipoles, seen from points outside its rim.
class Panel {
 public:
  /// Three points whose mean is exact for quadratic functions; their barycentric coordinates are 2/3, 1/6, 1/6.
  static constexpr int kPoints = 3;

  /// Integrals over the panel, r being the distance from a point.
  struct Seen {
    double sources_m = 0;                                 ///< of 1 / r
    Eigen::Vector3d moment_m2 = Eigen::Vector3d::Zero();  ///< of (y - x) / r along the panel
    Eigen::Vector3d dipoles = Eigen::Vector3d::Zero();    ///< of d(1/r)/dn, weighted by the hat of each corner
  };

  explicit Panel(const std::array<Eigen::Vector3d, 3>& corners_m);

  const Eigen::Vector3d& corner_m(int k) const { return corners_m_[k]; }
  const Eigen::Vector3d& point_m(int k) const { return points_m_[k]; }
  const Eigen::Vector3d& normal() const { return normal_; }
  const Eigen::Vector3d& middle_m() const { return middle_m_; }
  double area_m2() const { return area_m2_; }
  double radius_m() const { return radius_m_; }
  /// The edge that faces a corner.
  Eigen::Vector3d facing_m(int k) const { return corners_m_[(k + 2) % 3] - corners_m_[(k + 1) % 3]; }

  /// The integrals in closed form: 1/r after Wilton et al. 1984 (IEEE Trans. Antennas Propag. 32(3)), the solid angle
  /// after van Oosterom and Strackee 1983. The gradient of 1/r along the panel becomes an integral of 1/r around the
  /// rim, so the hats need the same logarithms. in_plane: whether the point lies on the panel.
  Seen seen_from(const Eigen::Vector3d& point_m, bool in_plane) const;

 private:
  std::array<Eigen::Vector3d, 3> corners_m_, points_m_, along_, outward_;  // along and across the edges
  std::array<double, 3> edges_m_{};
  Eigen::Vector3d normal_, middle_m_;
  double area_m2_ = 0, radius_m_ = 0;
};

}  // namespace uwsim
