#pragma once

/// The log-odds of a voxel: how scans change them and where they are clamped. This is OctoMap's rule (A. Hornung, K. M.
/// Wurm, M. Bennewitz, C. Stachniss, W. Burgard, "OctoMap: an efficient probabilistic 3D mapping framework based on
/// octrees", Autonomous Robots 34(3), 2013):
///
///   L = log(p / (1 - p)),  p = 1 / (1 + exp(-L))                       L: log-odds, p: probability of being occupied
///   L <- max(clamping_min, min(clamping_max, L + hit or miss))         an unknown voxel starts from L = 0
///
/// If a voxel is already at or beyond a limit and a hit or a miss would only push it further, it keeps its value (as in
/// OctoMap's updateNode).
///
/// The functions are `static` because the vector kernels include this header: code compiled for one instruction set
/// must not be linked into other files. The kernels have their own versions of clamped_sum(), called add_misses(), in
/// bricks/kernels/scan_kernels_avx2.cpp and scan_kernels_avx512.cpp.
namespace uwsim {

/// An OccupancyModel (occupancy_model.h) in log-odds.
struct OccupancyLogOdds {
  float hit;   ///< added to a voxel that contains a point; at least 0
  float miss;  ///< added to a voxel that a ray passes through; at most 0
  float clamping_min;
  float clamping_max;
};

static inline float log_odds_of(double probability) {
  return static_cast<float>(__builtin_log(probability / (1 - probability)));
}

/// A voxel is occupied if its probability is at least 0.5.
static inline bool is_occupied(float log_odds) { return log_odds >= 0; }

static inline float clamped(float log_odds, const OccupancyLogOdds& model) {
  return log_odds < model.clamping_min   ? model.clamping_min
         : log_odds > model.clamping_max ? model.clamping_max
                                         : log_odds;
}

/// The log-odds of a voxel after adding `change`, such as model.hit.
static inline float clamped_sum(float log_odds, float change, const OccupancyLogOdds& model) {
  return clamped(log_odds + change, model);
}

/// Whether a hit leaves a known voxel unchanged.
static inline bool hit_changes_nothing(float log_odds, const OccupancyLogOdds& model) {
  return log_odds >= model.clamping_max || (model.hit == 0 && log_odds <= model.clamping_min);
}

}  // namespace uwsim
