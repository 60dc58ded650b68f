#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

namespace uwsim {

/// Two quantities that oscillate at one speed: cosine cos(speed t) + sine sin(speed t).
struct Harmonic {
  double speed_rad_s = 0;
  Eigen::Array2d cosine = Eigen::Array2d::Zero(), sine = Eigen::Array2d::Zero();

  bool is_finite() const { return std::isfinite(speed_rad_s) && cosine.allFinite() && sine.allFinite(); }
  /// Largest length of the two quantities as a vector.
  double largest() const;
};

/// A sum of harmonics. It is evaluated as a power series about the middle of a window of time, which is exact to
/// rounding; each thread keeps the series that it used last. The value depends on the time alone.
class HarmonicSum {
 public:
  struct Sample {
    Eigen::Array2d value, rate_1_s;
  };

  explicit HarmonicSum(std::vector<Harmonic> harmonics);
  Sample at(double time_s) const;
  /// Upper bound of the length of the value.
  double bound() const { return bound_; }

 private:
  struct Series;
  Series series(double time_s) const;  ///< of the window that contains the time

  std::vector<Harmonic> harmonics_;
  double window_s_ = 0, bound_ = 0;
  std::uint64_t number_;
};

}  // namespace uwsim
