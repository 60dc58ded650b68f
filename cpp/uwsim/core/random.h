#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace uwsim {

/// Counter-based random numbers: a draw is a pure function of (seed, stream, tick, index), so that adding a sensor does
/// not disturb another's noise and a reading repeated at one time is the same sample.
/// Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3").
class RandomStream {
 public:
  /// `name` keys the stream, such as "rov/depth".
  RandomStream(std::uint64_t seed, std::string_view name);

  /// Uniform in the open interval (0, 1).
  double uniform(std::uint64_t tick, std::uint32_t index = 0) const;
  /// Standard normal (Box-Muller).
  double normal(std::uint64_t tick, std::uint32_t index = 0) const;
  /// Two independent standard normals, of which the first is `normal`'s: one draw's cost.
  std::array<double, 2> normals(std::uint64_t tick, std::uint32_t index = 0) const;

  /// What, with tick and index, makes the counter: for code that draws sixteen at once.
  std::uint64_t key() const { return key_; }
  std::uint32_t stream() const { return stream_; }

 private:
  std::uint64_t key_;
  std::uint32_t stream_;
};

}  // namespace uwsim
