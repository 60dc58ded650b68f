#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/acoustics/arrivals.h"

namespace uwsim {

/// The arrivals between points in the same water, for many packets between slowly moving ends. They are computed once
/// for each cell of range, depths of both ends and depth of the bottom, at the middle of the cell, and moved to the
/// true ends: travel times to first order, by the slowness of the ray at its ends and its reflections from the bottom.
///
/// A cell is 1/128 to 1/64 as wide as the ends are apart, and at most that part of the water's depth high. The levels
/// are those of ends that are at most 1/128 of the distance away: 0.07 dB under spherical spreading, more near a
/// caustic. The error of a travel time is of second order: at most 1/8192 of it along a straight ray, 1e-5 on average.
/// The content of a cell depends on the cell alone, so results do not depend on which cells are remembered, nor on the
/// order of calls.
class ArrivalCells {
 public:
  /// `cells`: how many of them are remembered.
  explicit ArrivalCells(std::size_t cells);

  /// Returns the arrivals within 30 dB of the strongest, at most 24, strongest first. Valid until the next call, which
  /// must be for the same water and losses. Allocates nothing once the search has seen as many layers. Not thread-safe.
  std::span<const Arrival> at(const SoundSpeedProfile& profile, const RayEnds& ends, const SoundLosses& losses);

 private:
  /// A size [m], and numbers of cells: range, depths of the ends, depth of the bottom.
  struct Key {
    double across_m = 0, depth_m = 0;
    std::array<std::int64_t, 4> cell{};
    bool operator==(const Key&) const = default;
  };
  struct Cell {
    Key key;
    RayEnds ends{};
    std::vector<Arrival> arrivals;
  };

  std::vector<Cell> cells_;  // by hash; a new cell replaces an old one
  std::vector<Arrival> moved_;
};

}  // namespace uwsim
