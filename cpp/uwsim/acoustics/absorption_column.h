#pragma once

#include <functional>
#include <vector>

namespace uwsim {

/// Absorption of one frequency down a column of water, integrated once, so that a path's mean costs two look-ups.
class AbsorptionColumn {
 public:
  /// absorption_db_km(depth_m): at a depth. Between `knots` depths, evenly from 0 to bottom_m, it is linear; below it
  /// is that of the bottom.
  AbsorptionColumn(const std::function<double(double)>& absorption_db_km, double bottom_m, int knots = 512);

  /// Mean along a straight path between two depths [dB/m].
  double mean_db_m(double from_depth_m, double to_depth_m) const;
  double at_db_m(double depth_m) const;
  /// The same from one depth to several, of which the integral down to the first is known.
  double mean_db_m(double from_depth_m, double down_to_from_db, double to_depth_m) const;

  /// Integral from the surface [dB].
  double down_to_db(double depth_m) const;

 private:
  double spacing_m_, per_spacing_1_m_;
  std::vector<double> at_db_m_;
  std::vector<double> down_db_;
};

}  // namespace uwsim
