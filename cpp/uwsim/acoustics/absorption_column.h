#pragma once

#include <functional>
#include <vector>

namespace uwsim {

/// Absorption at one frequency in a column of water, integrated over depth in advance: the mean along a path then costs
/// only two look-ups.
class AbsorptionColumn {
 public:
  /// Samples absorption_db_km(depth_m) at `knots` evenly spaced depths from 0 to bottom_m [m], and at the same number
  /// of depths from there to 12 km, the deepest ocean bed. The absorption is linear between these depths and constant
  /// above and below them. Throws InvalidValue.
  AbsorptionColumn(const std::function<double(double)>& absorption_db_km, double bottom_m, int knots = 512);

  double at_db_m(double depth_m) const;
  /// The mean along a straight path between two depths [dB/m].
  double mean_db_m(double from_depth_m, double to_depth_m) const;
  /// As above, for a caller that already has down_to_db(from_depth_m). This saves a look-up when several paths start at
  /// the same depth.
  double mean_db_m(double from_depth_m, double down_to_from_db, double to_depth_m) const;

  /// The integral from the surface down to a depth [dB].
  double down_to_db(double depth_m) const;

 private:
  /// Evenly spaced knots from `top_m` down.
  struct Part {
    double top_m, spacing_m, per_spacing_1_m;
    std::vector<double> at_db_m, down_db;

    Part(const std::function<double(double)>& absorption_db_km, double top_m, double bottom_m, int knots,
         double down_to_top_db);
    double at(double depth_m) const;
    double down_to(double depth_m) const;
  };
  const Part& part_of(double depth_m) const { return depth_m < below_.top_m ? above_ : below_; }

  Part above_, below_;
};

}  // namespace uwsim
