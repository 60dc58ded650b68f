#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace uwsim {

/// A wave about a centre: the real part of (real + i imaginary) exp(i k_x x + i k_y y + k_z z).
struct WaveTerm {
  double real, imaginary;
  double number_x_rad_m, number_y_rad_m, decay_rad_m;
};

/// The sum of many waves over a patch that is small compared with their lengths, as its Taylor polynomial of total
/// degree `kOrder`: one polynomial for each point instead of a sine and an exponential for each wave and point. At
/// distance r from the centre the remainder is at most sum a (k r)^(order + 1) / (order + 1)!, a the largest amplitude
/// that each wave has in the patch.
template <int kOrder>
class WavePolynomial {
 public:
  explicit WavePolynomial(std::span<const WaveTerm> terms) {
    for (const WaveTerm& term : terms) add(term);
  }

  double at(double x, double y, double z) const {
    double sum = 0;
    for (int c = kOrder; c >= 0; --c) sum = sum * z + coefficient_of_z(x, y, c);
    return sum;
  }
  /// at(x, y, 0).
  double flat_at(double x, double y) const { return coefficient_of_z(x, y, 0); }

 private:
  using Powers = std::array<double, kOrder + 1>;

  /// The coefficient of z^c at (x, y).
  double coefficient_of_z(double x, double y, int c) const {
    double sum = 0;
    for (int b = kOrder - c; b >= 0; --b) {
      double row = 0;
      for (int a = kOrder - c - b; a >= 0; --a) row = row * x + coefficient_[c][b][a];
      sum = sum * y + row;
    }
    return sum;
  }

  /// k^n / n!
  static Powers powers(double k) {
    Powers p;
    p[0] = 1;
    for (std::size_t n = 1; n <= kOrder; ++n) p[n] = p[n - 1] * k / static_cast<double>(n);
    return p;
  }

  void add(const WaveTerm& term) {
    const Powers x = powers(term.number_x_rad_m), y = powers(term.number_y_rad_m), z = powers(term.decay_rad_m);
    // The real part of (real + i imaginary) i^n, for n = 0 .. 3.
    const std::array<double, 4> real_parts = {term.real, -term.imaginary, -term.real, term.imaginary};
    for (std::size_t c = 0; c <= kOrder; ++c) {
      for (std::size_t b = 0; b + c <= kOrder; ++b) {
        const double share = z[c] * y[b];
        for (std::size_t a = 0; a + b + c <= kOrder; ++a)
          coefficient_[c][b][a] += real_parts[(a + b) % 4] * share * x[a];
      }
    }
  }

  std::array<std::array<Powers, kOrder + 1>, kOrder + 1> coefficient_{};
};

}  // namespace uwsim
