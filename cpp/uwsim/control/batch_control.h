#pragma once

#include <cstddef>
#include <vector>

#include "uwsim/control/motion_controller.h"

/// Controllers for many vehicles of one kind, called together. The results for vehicle k are bitwise identical to those
/// of a separate controller, regardless of the number of threads.
namespace uwsim {

/// The estimated motion of n vehicles, one row per vehicle.
struct EstimateRows {
  const double* positions_world_m;  ///< (n, 3)
  const double* orientations_xyzw;  ///< (n, 4), of length 1
  const double* velocities_body;    ///< (n, 6) [m/s, rad/s]

  MotionEstimate row(std::size_t k) const;
};

/// Efforts of n vehicles, (n, 6), surge to yaw.
using EffortRows = double*;

/// n instances of MotionController.
class BatchMotionController {
 public:
  /// Throws InvalidValue for invalid gains.
  BatchMotionController(const ControlModel& model, const ControlGains& gains, double period_s, std::size_t n,
                        int threads);

  std::size_t size() const { return each_.size(); }
  const MotionController& operator[](std::size_t k) const { return each_[k]; }
  void reach(const EstimateRows& estimates, const std::vector<MotionTarget>& targets, EffortRows efforts);
  /// `velocities_body`: (n, 6).
  void hold_velocity(const EstimateRows& estimates, const double* velocities_body, EffortRows efforts);
  /// Returns a controller to its initial state. Throws std::out_of_range.
  void restart(std::size_t k) { each_.at(k) = fresh_; }

 private:
  MotionController fresh_;
  std::vector<MotionController> each_;
  int threads_;
};

}  // namespace uwsim
