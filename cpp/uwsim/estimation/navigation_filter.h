#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/inertial.h"

namespace uwsim {

/// The vehicle's initial state, and its accuracy as standard deviations.
struct FilterStart {
  std::uint64_t time_ns = 0;
  Pose world_from_body;
  Eigen::Vector3d velocity_world_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d position_std_m = Eigen::Vector3d::Zero();  ///< world axes
  double velocity_std_m_s = 0;
  Eigen::Vector3d attitude_std_rad = Eigen::Vector3d::Zero();  ///< body axes
};

/// An error-state Kalman filter that accepts readings in any order. It keeps the readings of the last kHorizon_s, and
/// its state at some of their times (checkpoints). When a reading arrives late, the filter returns to the last
/// checkpoint before the reading and replays the readings that followed. The result depends only on the readings and
/// their times, not on when they were added.
class NavigationFilter {
 public:
  static constexpr double kHorizon_s = 4;
  /// Version of the bytes that save() returns, which are stored together with it.
  static constexpr std::uint64_t kVersion = 9;

  /// `imu_body_m`: position of the IMU on the body.
  NavigationFilter(const ImuErrors& imu, const Eigen::Vector3d& imu_body_m, double gravity_m_s2);

  /// Adds an aid and returns its index. Must be called before start().
  int add_aid(std::unique_ptr<Aid> aid);
  void start(const FilterStart& start);

  /// Adds an IMU sample in body axes: angular velocity, then specific force. Samples must be added in order of time.
  void add_imu(std::uint64_t time_ns, const double* rate_and_force);
  /// Adds a reading of an aid, measured at `time_ns`, that arrived at `arrival_ns`. A reading from before the start, or
  /// one that arrived more than kHorizon_s late, is dropped and counted.
  void add_reading(int aid, std::uint64_t time_ns, std::uint64_t arrival_ns, const double* reading);
  /// Records that the IMU provided no samples until `time_ns`.
  void add_silence(std::uint64_t time_ns);
  /// Processes the readings that have been added. Readings newer than the IMU's last sample wait.
  void catch_up();

  /// The newest state; its motion is that of the IMU's centre.
  const FilterState& state() const { return present_; }
  Eigen::Vector3d position_body_origin_m() const;
  Eigen::Vector3d velocity_body_m_s() const;  ///< of the body's origin, body axes
  std::uint64_t too_late() const { return too_late_; }
  int aids() const { return static_cast<int>(aids_.size()); }
  /// The index of the first of an aid's biases among the errors.
  int first_bias(int aid) const { return aids_.at(static_cast<std::size_t>(aid))->first_bias; }
  int aid_width(int aid) const { return aids_.at(static_cast<std::size_t>(aid))->width(); }

  /// Returns the complete state. A filter with the same aids that restores these bytes continues identically.
  std::string save();
  /// The bytes must be of kVersion. Throws InvalidValue if they do not match the filter.
  void restore(std::string_view bytes);

 private:
  static constexpr int kImu = -1, kSilence = -2;
  struct Event {
    std::uint64_t time_ns;
    int source;  ///< an aid's index, kImu or kSilence
    double values[kMaxReading];
  };
  struct Checkpoint {
    FilterState state;
    std::size_t next;  ///< the first event after it
  };

  void insert(const Event& event);
  void rewind_to(std::size_t event);
  bool apply(std::size_t event);
  void correct(const Event& reading);
  bool biases_are_plausible() const;
  void restart();
  void set_biases();
  const Event* next_inertial(std::size_t from) const;
  void advance(const Event& inertial, std::uint64_t time_ns);
  void checkpoint();
  void forget();
  void forget_all_but(std::size_t checkpoints_from);
  std::size_t last_before_horizon() const;
  void exchange(StateArchive& archive);
  void exchange_parameters(StateArchive& archive);

  Inertial inertial_;
  Eigen::Vector3d imu_body_m_;
  std::vector<std::unique_ptr<Aid>> aids_;
  std::vector<BiasModel> aid_biases_;
  FilterState present_;
  std::vector<Event> events_;  ///< by time; simultaneous ones with the IMU first
  std::size_t next_ = 0;       ///< the first event that has not been applied to present_
  std::size_t changed_ = 0;    ///< the first new event
  std::vector<Checkpoint> checkpoints_;
  std::uint64_t too_late_ = 0;
};

}  // namespace uwsim
