#include "uwsim/world/current.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/random.h"
#include "uwsim/core/stream_name.h"
#include "uwsim/core/with_unit.h"
#include "uwsim/world/field_cell.h"
#include "uwsim/world/field_number.h"

namespace uwsim {
namespace {

constexpr double kSpeedMax_m_s = 10;

void check_velocities(const std::vector<Eigen::Vector3d>& velocities, const std::string& path) {
  for (const Eigen::Vector3d& v : velocities) {
    require(v.allFinite() && v.norm() <= kSpeedMax_m_s, path, with_unit(v.transpose(), "m/s"),
            "must be finite and at most 10 m/s");
  }
}

double largest_speed_m_s(const std::vector<Eigen::Vector3d>& velocities) {
  double largest_m_s = 0;
  for (const Eigen::Vector3d& v : velocities) largest_m_s = std::max(largest_m_s, v.norm());
  return largest_m_s;
}

void check_rising(const std::vector<double>& axis, const std::string& path, const char* unit = "m") {
  require(!axis.empty(), path, 0, "must have at least one value");
  for (std::size_t k = 0; k < axis.size(); ++k) {
    require(std::isfinite(axis[k]) && (k == 0 || axis[k] > axis[k - 1]), path, with_unit(axis[k], unit),
            "must be finite and rising");
  }
}

class LayeredCurrent : public Current {
 public:
  LayeredCurrent(std::vector<double> depths_m, std::vector<Eigen::Vector3d> velocity_m_s)
      : depths_m_(std::move(depths_m)), velocity_m_s_(std::move(velocity_m_s)) {}
  CurrentSample at(const Eigen::Vector3d& p, double) const override {
    const Interval b(depths_m_, -p.z());
    return {.velocity_m_s = velocity_m_s_[b.first] + b.fraction * (velocity_m_s_[b.second] - velocity_m_s_[b.first])};
  }
  double bound_m_s() const override { return largest_speed_m_s(velocity_m_s_); }

 private:
  std::vector<double> depths_m_;
  std::vector<Eigen::Vector3d> velocity_m_s_;
};

class TidalCurrent : public Current {
 public:
  TidalCurrent(const Eigen::Vector3d& amplitude_m_s, double period_s, double phase_rad)
      : amplitude_m_s_(amplitude_m_s), omega_rad_s_(2 * std::numbers::pi / period_s), phase_rad_(phase_rad) {}
  CurrentSample at(const Eigen::Vector3d&, double time_s) const override {
    const double phase = omega_rad_s_ * time_s + phase_rad_;
    return {std::sin(phase) * amplitude_m_s_, omega_rad_s_ * std::cos(phase) * amplitude_m_s_};
  }
  bool is_uniform() const override { return true; }
  double bound_m_s() const override { return amplitude_m_s_.norm(); }

 private:
  Eigen::Vector3d amplitude_m_s_;
  double omega_rad_s_, phase_rad_;
};

class HarmonicCurrent : public Current {
 public:
  explicit HarmonicCurrent(std::vector<Harmonic> harmonics) : sum_(std::move(harmonics)) {}
  CurrentSample at(const Eigen::Vector3d&, double time_s) const override {
    const HarmonicSum::Sample now = sum_.at(time_s);
    return {{now.value(0), now.value(1), 0}, {now.rate_1_s(0), now.rate_1_s(1), 0}};
  }
  bool is_uniform() const override { return true; }
  double bound_m_s() const override { return sum_.bound(); }

 private:
  HarmonicSum sum_;
};

class GustyCurrent : public Current {
 public:
  GustyCurrent(const Eigen::Vector3d& sigma_m_s, double correlation_time_s, std::uint64_t seed)
      : sigma_m_s_(sigma_m_s),
        block_s_(kBlock * correlation_time_s),
        draws_{RandomStream(seed, stream_name("water", "gusts", "x")),
               RandomStream(seed, stream_name("water", "gusts", "y")),
               RandomStream(seed, stream_name("water", "gusts", "z"))} {
    for (int level = 0; level < kLevels; ++level) {
      const double half = kBlock * std::pow(0.5, level + 1);  // half the interval, in correlation times
      mean_weight_[static_cast<std::size_t>(level)] = 0.5 / std::cosh(half);
      std_[static_cast<std::size_t>(level)] = std::sqrt(std::tanh(half));
    }
  }
  CurrentSample at(const Eigen::Vector3d&, double time_s) const override {
    const double blocks = std::floor(time_s / block_s_);
    const double fraction = std::clamp(time_s / block_s_ - blocks, 0.0, 1.0);
    const double knot = std::min(std::floor(fraction * kIntervals), kIntervals - 1);
    const auto index =
        static_cast<std::int64_t>(blocks) * static_cast<std::int64_t>(kIntervals) + static_cast<std::int64_t>(knot);
    const Ends ends = ends_of(index);
    const Eigen::Vector3d slope = (ends.right - ends.left) * kIntervals;  // of each block
    const Eigen::Vector3d value = ends.left + slope * (fraction - knot / kIntervals);
    return {.velocity_m_s = sigma_m_s_.cwiseProduct(value), .rate_m_s2 = sigma_m_s_.cwiseProduct(slope) / block_s_};
  }
  bool is_uniform() const override { return true; }
  bool is_smooth() const override { return false; }
  double bound_m_s() const override { return 3 * sigma_m_s_.norm(); }

 private:
  static constexpr int kLevels = 9;
  static constexpr double kBlock = 16;  // length of a block, in correlation times

  static constexpr double kIntervals = 1 << kLevels;  // between the knots of a block

  /// Values of the unit-variance processes at both ends of an interval between two knots.
  struct Ends {
    std::int64_t index = std::numeric_limits<std::int64_t>::min();
    Eigen::Vector3d left = Eigen::Vector3d::Zero(), right = Eigen::Vector3d::Zero();
  };

  /// The last interval is cached, since many consecutive steps need it. If another thread is using the cache, the
  /// interval is recomputed.
  Ends ends_of(std::int64_t index) const {
    if (looking_.test_and_set(std::memory_order_acquire)) return drawn(index);
    if (kept_.index != index) kept_ = drawn(index);
    const Ends ends = kept_;
    looking_.clear(std::memory_order_release);
    return ends;
  }

  Ends drawn(std::int64_t index) const {
    Ends ends{.index = index};
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (sigma_m_s_(axis) == 0) continue;
      std::tie(ends.left(axis), ends.right(axis)) = knots(draws_[static_cast<std::size_t>(axis)], index);
    }
    return ends;
  }

  /// Unit-variance processes at the ends of an interval. A draw is keyed by the block and an index: 0 for the start of
  /// the block, and for a midpoint its number in a binary heap, which also identifies the interval that it halves.
  std::pair<double, double> knots(const RandomStream& draw, std::int64_t index) const {
    const auto block = static_cast<std::uint64_t>(index >> kLevels);
    double left = draw.normal(block, 0), right = draw.normal(block + 1, 0);
    std::uint32_t node = 1;
    for (int level = 0; level < kLevels; ++level) {
      const auto k = static_cast<std::size_t>(level);
      const double midpoint = mean_weight_[k] * (left + right) + std_[k] * draw.normal(block, node);
      const bool upper = ((index >> (kLevels - 1 - level)) & 1) != 0;
      (upper ? left : right) = midpoint;
      node = 2 * node + (upper ? 1 : 0);
    }
    return {left, right};
  }

  Eigen::Vector3d sigma_m_s_;
  double block_s_;
  std::array<RandomStream, 3> draws_;
  std::array<double, kLevels> mean_weight_, std_;
  mutable std::atomic_flag looking_;
  mutable Ends kept_;
};

class GriddedCurrent : public Current {
 public:
  explicit GriddedCurrent(CurrentGrid grid) : grid_(std::move(grid)) {}

  CurrentSample at(const Eigen::Vector3d& p, double time_s) const override {
    const FieldCell& cell = RememberedCells::of_this_thread().find(grid_, number_, p, time_s);
    const Eigen::Vector3d e = cell.offset(p);
    const double x = e.x(), y = e.y(), z = e.z();
    return sample(cell, time_s, {1, x, y, z, x * y, y * z, z * x, x * y * z});
  }

  /// In closed form, if all points are in one cell or on both sides of one level. Others are sampled one by one.
  CurrentOver over(const Eigen::Vector3d& middle, const Eigen::Matrix3d& arms_m, double time_s) const override {
    const FieldCell& cell = RememberedCells::of_this_thread().find(grid_, number_, middle, time_s);
    const Eigen::Vector3d reach = arms_m.cwiseAbs().rowwise().maxCoeff(), low = middle - reach, high = middle + reach;
    if ((low.array() < cell.low_m.array()).head<2>().any() || (high.array() >= cell.high_m.array()).head<2>().any()) {
      return Current::over(middle, arms_m, time_s);
    }
    const bool below = low.z() < cell.low_m.z(), above = high.z() >= cell.high_m.z();
    if (!below && !above) return in_cell(cell, middle, arms_m, time_s);
    if (below && above) return Current::over(middle, arms_m, time_s);
    const double level_m = below ? cell.low_m.z() : cell.high_m.z();
    const Slopes slopes(cell, time_s);
    const CurrentOver unbent = in_cell(cell, middle, arms_m, time_s);
    const Eigen::Vector3d beyond(middle.x(), middle.y(), below ? low.z() : high.z());
    const FieldCell& other = RememberedCells::of_this_thread().find(grid_, number_, beyond, time_s);  // moves `cell`
    if ((below ? other.high_m : other.low_m).z() != level_m) return Current::over(middle, arms_m, time_s);
    return bent(unbent, Slopes(other, time_s) - slopes, other, level_m, middle, arms_m, below);
  }
  double bound_m_s() const override { return largest_speed_m_s(grid_.values); }

 private:
  static constexpr double kSixth = 1.0 / 6;

  /// Terms that are even in the arm add to the mean, odd ones turn.
  static CurrentOver in_cell(const FieldCell& cell, const Eigen::Vector3d& middle, const Eigen::Matrix3d& arms_m,
                             double time_s) {
    constexpr double kThird = 1.0 / 3;
    const Eigen::Matrix3d edges = cell.per_m.asDiagonal() * arms_m;
    const Eigen::Matrix3d third_arms = kThird * arms_m, spread = third_arms * edges.transpose();
    const Eigen::Vector3d skew = third_arms * edges.colwise().prod().transpose();
    const double xy = kThird * edges.row(0).dot(edges.row(1)), yz = kThird * edges.row(1).dot(edges.row(2)),
                 zx = kThird * edges.row(2).dot(edges.row(0));
    const Eigen::Vector3d e = cell.offset(middle);
    const double x = e.x(), y = e.y(), z = e.z();
    const std::array<double, 8> weights = {1,          x,          y,          z,
                                           x * y + xy, y * z + yz, z * x + zx, x * y * z + x * yz + y * zx + z * xy};
    const FieldCell::Terms c = cell.at(time_s);
    CurrentOver mean;
    mean.velocity_m_s = sum_of(c, weights).head<3>();
    if (cell.changes) mean.rate_m_s2 = sum_of(cell.rate, weights).head<3>();
    const Eigen::Vector4d dx = c[1] + y * c[4] + z * c[6] + y * z * c[7],
                          dy = c[2] + x * c[4] + z * c[5] + z * x * c[7],
                          dz = c[3] + y * c[5] + x * c[6] + x * y * c[7];
    mean.turning_m2_s = spread.col(0).cross(dx.head<3>()) + spread.col(1).cross(dy.head<3>()) +
                        spread.col(2).cross(dz.head<3>()) + skew.cross(c[7].head<3>());
    mean.gradient_1_s << cell.per_m.x() * dx.head<3>(), cell.per_m.y() * dy.head<3>(), cell.per_m.z() * dz.head<3>();
    return mean;
  }

  /// The upward gradient of a cell's field: its terms of 1, e_x, e_y and e_x e_y, and their rates.
  struct Slopes {
    std::array<Eigen::Vector4d, 4> now, rate;

    Slopes(const FieldCell& cell, double time_s) {
      constexpr std::array<std::size_t, 4> kOfHeight = {3, 6, 5, 7};
      const double since_s = cell.changes ? time_s - cell.begin_s : 0;
      for (std::size_t k = 0; k < 4; ++k) {
        rate[k] = cell.changes ? Eigen::Vector4d(cell.per_m.z() * cell.rate[kOfHeight[k]]) : Eigen::Vector4d::Zero();
        now[k] = cell.per_m.z() * cell.value[kOfHeight[k]] + since_s * rate[k];
      }
    }
    Slopes operator-(const Slopes& other) const {
      Slopes change = *this;
      for (std::size_t k = 0; k < 4; ++k) {
        change.now[k] -= other.now[k];
        change.rate[k] -= other.rate[k];
      }
      return change;
    }
  };

  /// The mean in a field that bends at a level: beyond it, its upward gradient changes.
  static CurrentOver bent(const CurrentOver& unbent, const Slopes& change, const FieldCell& beyond, double level_m,
                          const Eigen::Vector3d& middle, const Eigen::Matrix3d& arms_m, bool below) {
    CurrentOver mean = unbent;
    Eigen::Vector4d all = Eigen::Vector4d::Zero();
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3d arm = arms_m.col(k);
      for (int end = 0; end < 2; ++end, arm = -arm) {
        const double height_m = middle.z() + arm.z() - level_m;
        if ((height_m < 0) != below) continue;
        const Eigen::Vector3d e = beyond.offset(middle + arm);
        const Eigen::Vector4d weights(height_m, height_m * e.x(), height_m * e.y(), height_m * e.x() * e.y());
        const Eigen::Vector4d more = weights[0] * change.now[0] + weights[1] * change.now[1] +
                                     weights[2] * change.now[2] + weights[3] * change.now[3];
        mean.velocity_m_s += kSixth * more.head<3>();
        mean.turning_m2_s += kSixth * arm.cross(more.head<3>());
        mean.gradient_1_s += more.head<3>() * (0.5 / arm.squaredNorm() * arm.transpose());
        all += kSixth * weights;
      }
    }
    for (std::size_t k = 0; k < 4; ++k) mean.rate_m_s2 += all[static_cast<int>(k)] * change.rate[k].head<3>();
    return mean;
  }

  static Eigen::Vector4d sum_of(const FieldCell::Terms& terms, const std::array<double, 8>& weights) {
    Eigen::Vector4d sum = weights[0] * terms[0];
    for (std::size_t k = 1; k < 8; ++k) sum += weights[k] * terms[k];
    return sum;
  }
  static CurrentSample sample(const FieldCell& cell, double time_s, const std::array<double, 8>& weights) {
    const Eigen::Vector4d begun = sum_of(cell.value, weights);
    if (!cell.changes) return {.velocity_m_s = begun.head<3>()};
    const Eigen::Vector4d rate = sum_of(cell.rate, weights);
    return {.velocity_m_s = (begun + (time_s - cell.begin_s) * rate).head<3>(), .rate_m_s2 = rate.head<3>()};
  }

  CurrentGrid grid_;
  std::uint64_t number_ = next_field_number();
};

}  // namespace

CurrentOver Current::over(const Eigen::Vector3d& middle_world_m, const Eigen::Matrix3d& arms_m, double time_s) const {
  if (is_uniform()) return {at(middle_world_m, time_s)};
  CurrentOver mean;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d arm = arms_m.col(k);
    const CurrentSample ahead = at(middle_world_m + arm, time_s), behind = at(middle_world_m - arm, time_s);
    const Eigen::Vector3d change = ahead.velocity_m_s - behind.velocity_m_s;
    mean.velocity_m_s += (ahead.velocity_m_s + behind.velocity_m_s) / 6;
    mean.rate_m_s2 += (ahead.rate_m_s2 + behind.rate_m_s2) / 6;
    mean.turning_m2_s += arm.cross(change) / 6;
    if (const double square_m2 = arm.squaredNorm(); square_m2 > 0)
      mean.gradient_1_s += change * (0.5 / square_m2 * arm.transpose());
  }
  return mean;
}

std::shared_ptr<const Current> layered_current(std::vector<double> depths_m,
                                               std::vector<Eigen::Vector3d> velocity_m_s) {
  check_rising(depths_m, "water.current.depth_m");
  check_velocities(velocity_m_s, "water.current.velocity_m_s");
  require(depths_m.size() == velocity_m_s.size(), "water.current.velocity_m_s", velocity_m_s.size(),
          "must have one velocity for each depth");
  return std::make_shared<LayeredCurrent>(std::move(depths_m), std::move(velocity_m_s));
}

std::shared_ptr<const Current> tidal_current(const Eigen::Vector3d& amplitude_m_s, double period_s, double phase_rad) {
  check_velocities({amplitude_m_s}, "water.current.amplitude_m_s");
  require(period_s >= 60 && period_s <= 1e7, "water.current.period_s", period_s, "must be in [60, 1e7] s");
  require(std::isfinite(phase_rad), "water.current.phase_rad", phase_rad, "must be finite");
  return std::make_shared<TidalCurrent>(amplitude_m_s, period_s, phase_rad);
}

std::shared_ptr<const Current> harmonic_current(std::vector<Harmonic> harmonics) {
  for (const Harmonic& each : harmonics) {
    require(each.is_finite() && each.largest() <= kSpeedMax_m_s, "water.current.major_m_s", each.largest(),
            "must be finite and at most 10 m/s");
  }
  return std::make_shared<HarmonicCurrent>(std::move(harmonics));
}

std::shared_ptr<const Current> gusty_current(const Eigen::Vector3d& sigma_m_s, double correlation_time_s,
                                             std::uint64_t seed) {
  check_velocities({sigma_m_s}, "water.current.sigma_m_s");
  require(sigma_m_s.minCoeff() >= 0, "water.current.sigma_m_s", with_unit(sigma_m_s.transpose(), "m/s"),
          "must not be negative");
  require(correlation_time_s >= 0.1 && correlation_time_s <= 1e6, "water.current.correlation_time_s",
          correlation_time_s, "must be in [0.1, 1e6] s");
  return std::make_shared<GustyCurrent>(sigma_m_s, correlation_time_s, seed);
}

std::shared_ptr<const Current> gridded_current(CurrentGrid grid) {
  check_rising(grid.x_m, "water.current.x_m");
  check_rising(grid.y_m, "water.current.y_m");
  check_rising(grid.z_m, "water.current.z_m");
  check_rising(grid.t_s, "water.current.t_s", "s");
  check_velocities(grid.values, "water.current.velocity_m_s");
  require(grid.values.size() == grid.size(), "water.current.velocity_m_s", grid.values.size(),
          "must have one velocity for each grid point");
  return std::make_shared<GriddedCurrent>(std::move(grid));
}

}  // namespace uwsim
