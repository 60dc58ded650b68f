#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace uwsim {

/// Counter-based random numbers: a draw is a pure function of (seed, stream, tick, index). Adding a sensor therefore
/// does not change the noise of the others, and reading a sensor twice at the same time returns the same sample.
/// Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3").
class RandomStream {
 public:
  /// `name` keys the stream; see stream_name().
  RandomStream(std::uint64_t seed, std::string_view name);

  /// Uniform on the open interval (0, 1).
  double uniform(std::uint64_t tick, std::uint32_t index = 0) const;
  /// Standard normal (Box-Muller).
  double normal(std::uint64_t tick, std::uint32_t index = 0) const;
  /// Two independent standard normal draws for the cost of one; the first is the same as normal() returns.
  std::array<double, 2> normals(std::uint64_t tick, std::uint32_t index = 0) const;

  /// The stream's Philox key and counter word, for kernels that draw sixteen numbers at once.
  std::uint64_t key() const { return key_; }
  std::uint32_t stream() const { return stream_; }

 private:
  std::uint64_t key_;
  std::uint32_t stream_;
};

}  // namespace uwsim
