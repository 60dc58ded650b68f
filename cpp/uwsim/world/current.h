#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "uwsim/world/harmonics.h"
#include "uwsim/world/space_time_grid.h"

namespace uwsim {

/// Velocity of a current at a given position and time, and its local rate of change, world frame.
struct CurrentSample {
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_m_s2 = Eigen::Vector3d::Zero();
};

/// A current at six points about a middle, with equal weights: the means of velocity, of its rate, and of arm x
/// velocity; and the gradient of the velocity.
struct CurrentOver : CurrentSample {
  Eigen::Vector3d turning_m2_s = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient_1_s = Eigen::Matrix3d::Zero();
};

/// A current: a pure function of position and time. Several currents add up.
class Current {
 public:
  virtual ~Current() = default;
  virtual CurrentSample at(const Eigen::Vector3d& point_world_m, double time_s) const = 0;
  /// The six points are the middle plus and minus each column of `arms_m`, which are at right angles to each other.
  virtual CurrentOver over(const Eigen::Vector3d& middle_world_m, const Eigen::Matrix3d& arms_m, double time_s) const;
  /// Upper bound of the speed anywhere and at any time [m/s]. Gusts are unbounded, so three standard deviations are
  /// used for them.
  virtual double bound_m_s() const = 0;
  /// Whether the current is the same everywhere.
  virtual bool is_uniform() const { return false; }
  /// Returns true if the current may be taken for linear in time over a step.
  virtual bool is_smooth() const { return true; }
};

/// A steady current, linear in depth between levels, constant above the first and below the last. This and the
/// functions below throw InvalidValue naming water.current.
std::shared_ptr<const Current> layered_current(std::vector<double> depths_m, std::vector<Eigen::Vector3d> velocity_m_s);

/// A tidal current, amplitude sin(2 pi t / period + phase): rectilinear, as in a channel.
std::shared_ptr<const Current> tidal_current(const Eigen::Vector3d& amplitude_m_s, double period_s, double phase_rad);

/// The sum of two quantities' harmonics: the current to the east and to the north.
std::shared_ptr<const Current> harmonic_current(std::vector<Harmonic> harmonics);

/// Gauss-Markov gusts with zero mean: each world axis is an Ornstein-Uhlenbeck process with standard deviation sigma
/// and autocorrelation exp(-|dt| / correlation_time), drawn at knots 1/32 of that time apart and linear between them.
/// Knots are computed by bisection: knots 16 correlation times apart are drawn independently (their correlation is
/// e^-16), and each midpoint is drawn from its exact distribution given its two neighbours (a bridge). The value at any
/// time thus depends only on seed and time, not on earlier steps, and costs ten draws.
std::shared_ptr<const Current> gusty_current(const Eigen::Vector3d& sigma_m_s, double correlation_time_s,
                                             std::uint64_t seed);

/// A field on a grid of positions and times. Throws InvalidValue naming water.current.
using CurrentGrid = SpaceTimeGrid<Eigen::Vector3d>;
std::shared_ptr<const Current> gridded_current(CurrentGrid grid);

}  // namespace uwsim
