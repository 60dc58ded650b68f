#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "uwsim/core/water_field.h"

namespace uwsim {

/// The flow at many points along a line. Waves, whose evaluation is costly, are evaluated at some of the points, and
/// interpolated between these by cubic polynomials of the length along the line.
///
/// A wave number k reaches a depth d with exp(-k d) of its motion. With points up to h apart, the polynomial's error is
/// 3/128 (k h)^4 exp(-k d) of the wave's motion at the surface, which is greatest for k = 4 / d: 0.7 % if h = d / 2,
/// the greatest distance here. Waves of which less than 0.1 % remains are left out. Where the line bends too sharply
/// for that, which the polynomial of the points' own positions shows, and within the greatest wave height of the
/// surface, the waves are evaluated at each point; so they are if a current varies from point to point.
///
/// A point stands for a part of the line with a height. Where all of that is above the surface, there is no flow.
class FlowAlong {
 public:
  /// Points, their lengths from the first, strictly increasing [m], and half of their heights; if none is given, they
  /// are all taken to be wet.
  struct Line {
    std::span<const Eigen::Vector3d> points_m;
    std::span<const double> along_m, half_heights_m = {};
  };

  void resize(std::size_t most);
  void find(const Line& line, const WaterField& water, double time_s);
  const WaterFlow& at(std::size_t point) const { return flows_[point]; }
  /// The share of a point's height that is under water.
  double wet(std::size_t point) const { return wet_[point]; }
  /// The points at which the waves were evaluated in the last search.
  std::size_t evaluated() const { return evaluated_; }

 private:
  struct Search;
  void choose(const Search& search);
  void interpolate(const Search& search, std::size_t interval);
  void evaluate(const Search& search, std::size_t point);
  bool is_near(const Search& search, std::size_t point) const;

  std::vector<WaterFlow> flows_;
  std::vector<double> wet_;
  std::vector<std::size_t> chosen_;
  std::size_t evaluated_ = 0;
};

}  // namespace uwsim
