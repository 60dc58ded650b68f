#pragma once

#include "uwsim/mapping/log_odds.h"

namespace uwsim {

/// The probabilities of OctoMap's sensor model, with its defaults. log_odds.h describes how they are used.
struct OccupancyModel {
  double hit = 0.7;              ///< probability that a voxel is occupied if it contains a point, in [0.5, 1)
  double miss = 0.4;             ///< probability that a voxel is occupied if a ray passes through it, in (0, 0.5]
  double clamping_min = 0.1192;  ///< limits of the probability that scans can produce
  double clamping_max = 0.971;

  OccupancyLogOdds in_log_odds() const;
  /// Throws InvalidValue naming the value.
  void check() const;
};

}  // namespace uwsim
