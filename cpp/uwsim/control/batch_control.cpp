#include "uwsim/control/batch_control.h"

#include "uwsim/core/parallel.h"

namespace uwsim {
namespace {

constexpr std::size_t kWorthAThread = 64;  // a control period takes a few microseconds, and starting a thread tens

}  // namespace

MotionEstimate EstimateRows::row(std::size_t k) const {
  const double* const q = orientations_xyzw + 4 * k;
  return {Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix(),
          Eigen::Vector3d::Map(positions_world_m + 3 * k), Vector6d::Map(velocities_body + 6 * k)};
}

BatchMotionController::BatchMotionController(const ControlModel& model, const ControlGains& gains, double period_s,
                                             std::size_t n, int threads)
    : fresh_(model, gains, period_s), each_(n, fresh_), threads_(threads) {}

void BatchMotionController::reach(const EstimateRows& estimates, const std::vector<MotionTarget>& targets,
                                  EffortRows efforts) {
  parallel_ranges(
      size(), threads_,
      [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
          Vector6d::Map(efforts + 6 * k) = each_[k].reach(estimates.row(k), targets[k]);
        }
      },
      kWorthAThread);
}

void BatchMotionController::hold_velocity(const EstimateRows& estimates, const double* velocities_body,
                                          EffortRows efforts) {
  parallel_ranges(
      size(), threads_,
      [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
          Vector6d::Map(efforts + 6 * k) =
              each_[k].hold_velocity(estimates.row(k), Vector6d::Map(velocities_body + 6 * k));
        }
      },
      kWorthAThread);
}

}  // namespace uwsim
