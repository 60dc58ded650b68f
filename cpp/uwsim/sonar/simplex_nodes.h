#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "uwsim/sonar/hashed_noise.h"

namespace uwsim {

/// The corners of the simplex that contains a point, as keys for hashing, with weights whose squares add up to 1. The
/// weighted sum of independent noise at the corners is noise that varies with the point.
template <std::size_t N>
struct SimplexNodes {
  std::array<float, N + 1> weights;
  std::array<std::uint32_t, N + 1> keys;
};

/// A lattice of simplices, skewed so that it has no preferred direction (Perlin 2001, "Noise hardware", not consulted;
/// the skew is that of opensimplex 0.4.5 in 2, 3 and 4 dimensions): N + 1 nodes instead of the 2^N of a cube. The
/// squared correlation of the noise at two points is 0.30 at a distance
/// of half a unit, at most 0.02 at one unit and 0 beyond 1.5 units (averages over positions; N = 3 and 5).
template <std::size_t N>
SimplexNodes<N> simplex_nodes(const std::array<double, N>& point, std::uint32_t key) {
  double sum = 0;
  for (const double x : point) sum += x;
  const double skew = (std::sqrt(N + 1.0) - 1) / N * sum;
  std::array<std::int64_t, N> cell;
  std::array<double, N> off;
  std::array<std::size_t, N> order;
  for (std::size_t k = 0; k < N; ++k) {
    const double skewed = point[k] + skew, down = std::floor(skewed);
    cell[k] = static_cast<std::int64_t>(down);
    off[k] = skewed - down;
    order[k] = k;
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return off[a] > off[b]; });
  SimplexNodes<N> nodes;
  double last = 1, squares = 0;
  for (std::size_t k = 0; k <= N; ++k) {  // from one corner to the opposite one, along the longest offsets first
    std::uint64_t hash = key;
    for (const std::int64_t index : cell) hash = mixed(hash + static_cast<std::uint64_t>(index));
    nodes.keys[k] = static_cast<std::uint32_t>(hash);
    const double next = k < N ? off[order[k]] : 0;
    nodes.weights[k] = static_cast<float>(last - next);
    squares += (last - next) * (last - next);
    last = next;
    if (k < N) ++cell[order[k]];
  }
  const auto scale = static_cast<float>(1 / std::sqrt(squares));
  for (float& weight : nodes.weights) weight *= scale;
  return nodes;
}

}  // namespace uwsim
