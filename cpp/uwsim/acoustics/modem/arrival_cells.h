#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/acoustics/arrivals.h"

namespace uwsim {

/// A cache of the arrivals between points in the same water, for many packets between slowly moving ends. A cell is a
/// small interval of range, of the depth of each end and of the depth of the bottom. Arrivals are computed once for the
/// middle of a cell and then corrected for the true ends. With the slowness vectors of the ray at its ends and at its
/// reflections from the bottom, the travel time changes to first order by their components along the displacements. To
/// second order it changes by d^2 / (2 dx/dp), where d is the horizontal distance by which a ray with the same Snell
/// invariant p misses the true receiver (the time is the Legendre transform of the delay p x + T(p)); near a caustic,
/// where p would have to change by more than 1/32 of the slowness, this term is left out. Levels change as under
/// spherical spreading.
///
/// The width of a cell is 1/64 to 1/32 of the distance between the ends; its height is at most the same fraction of the
/// water's depth. Along a straight ray, the error of the travel time is of third order: at most 1/65536 of the travel
/// time. The content of a cell depends on the cell alone, so results depend neither on which cells are in the cache nor
/// on the order of calls.
class ArrivalCells {
 public:
  /// `cells`: the number of cells that the cache holds.
  explicit ArrivalCells(std::size_t cells);

  /// Returns the arrivals within 30 dB of the strongest, at most 24, strongest first. Valid until the next call, which
  /// must be for the same water and losses. Allocates memory only if there are more layers than in any earlier call.
  /// Not thread-safe.
  std::span<const Arrival> at(const SoundSpeedProfile& profile, const RayEnds& ends, const SoundLosses& losses);

 private:
  /// The size of a cell [m], and its index along range, depths of the ends and depth of the bottom.
  struct Key {
    double across_m = 0, depth_m = 0;
    std::array<std::int64_t, 4> cell{};
    bool operator==(const Key&) const = default;
  };
  /// The directions of an arrival at its ends and at the bottom, and the speed of sound there.
  struct Directions {
    double arrival_cos, arrival_sin, arrival_tan, launch_sin, launch_tan, bottom_sin, bottom_tan, bottom_m_s;
  };
  struct Cell {
    Key key;
    RayEnds ends{};
    double from_m_s = 0, to_m_s = 0;
    std::vector<Arrival> arrivals;
    std::vector<Directions> directions;  // of each arrival
  };
  static void fill(Cell& cell, const SoundSpeedProfile& profile, const SoundLosses& losses);

  std::vector<Cell> cells_;  // by hash; a new cell replaces an old one
  std::vector<Arrival> moved_;
};

}  // namespace uwsim
