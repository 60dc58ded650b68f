#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "uwsim/core/water_field.h"

namespace uwsim {

/// The flow at many points along a line. Waves, whose evaluation is costly, are evaluated at some of the points, and
/// interpolated between these by cubic polynomials of the length along the line.
///
/// A wave number k reaches a depth d with exp(-k d) of its motion. With points up to h apart, the polynomial's error is
/// 3/128 (k h)^4 exp(-k d) of the wave's motion at the surface, which is greatest for k = 4 / d: 0.7 % if h = d / 2,
/// the greatest distance here. Where the line bends too sharply for that, which the polynomial of the points' own
/// positions shows, and within the greatest wave height of the surface, the waves are evaluated at each point; so they
/// are if a current varies from point to point.
class FlowAlong {
 public:
  void resize(std::size_t most);
  /// Finds the flow at points, and their lengths from the first, strictly increasing [m].
  void find(std::span<const Eigen::Vector3d> points_m, std::span<const double> along_m, const WaterField& water,
            double time_s);
  const WaterFlow& at(std::size_t point) const { return flows_[point]; }
  /// The points at which the waves were evaluated in the last search.
  std::size_t evaluated() const { return evaluated_; }

 private:
  void choose(std::span<const Eigen::Vector3d> points_m, std::span<const double> along_m, double wave_bound_m);
  void interpolate(std::size_t interval, std::span<const Eigen::Vector3d> points_m, std::span<const double> along_m,
                   const WaterField& water, double time_s);
  void evaluate(std::size_t point, const Eigen::Vector3d& at_m, const WaterField& water, double time_s);

  std::vector<WaterFlow> flows_;
  std::vector<std::size_t> chosen_;
  std::size_t evaluated_ = 0;
};

}  // namespace uwsim
