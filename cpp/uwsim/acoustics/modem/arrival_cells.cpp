#include "uwsim/acoustics/modem/arrival_cells.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace uwsim {
namespace {

constexpr double kCellsAcross = 32;
constexpr double kLeast_m = 0.0625;
constexpr double kMostBent = 1.0 / 32;  // change of a ray's invariant, relative to the slowness of sound
constexpr ArrivalLimits kKept{.within_db = 30, .most = 24};

/// The greatest power of two that is at most 1/32 of a distance.
double cell_m(double distance_m) {
  return std::max(kLeast_m, std::exp2(std::floor(std::log2(distance_m / kCellsAcross))));
}

std::size_t mixed(std::uint64_t value) {  // the finalizer of MurmurHash3
  value = (value ^ value >> 33) * 0xff51afd7ed558ccdULL;
  value = (value ^ value >> 33) * 0xc4ceb9fe1a85ec53ULL;
  return static_cast<std::size_t>(value ^ value >> 33);
}

}  // namespace

ArrivalCells::ArrivalCells(std::size_t cells) : cells_(cells) {
  for (Cell& cell : cells_) cell.arrivals.reserve(kKept.most), cell.directions.reserve(kKept.most);
  moved_.reserve(kKept.most);
}

std::span<const Arrival> ArrivalCells::at(const SoundSpeedProfile& profile, const RayEnds& ends,
                                          const SoundLosses& losses) {
  const bool has_bottom = std::isfinite(ends.bottom_m);
  const double deeper = std::max(ends.from_depth_m, ends.to_depth_m);
  Key key;
  key.across_m = cell_m(std::hypot(ends.across_m, ends.to_depth_m - ends.from_depth_m));
  key.depth_m = std::min(key.across_m, cell_m(has_bottom ? ends.bottom_m : deeper));
  const auto number = [](double value, double size) { return static_cast<std::int64_t>(std::floor(value / size)); };
  key.cell = {number(ends.across_m, key.across_m), number(ends.from_depth_m, key.depth_m),
              number(ends.to_depth_m, key.depth_m), has_bottom ? number(ends.bottom_m, key.depth_m) : -1};
  std::uint64_t hash = static_cast<std::uint64_t>(std::ilogb(key.across_m) * 64 + std::ilogb(key.depth_m));
  for (const std::int64_t one : key.cell) hash = mixed(hash ^ static_cast<std::uint64_t>(one));
  Cell& cell = cells_[hash % cells_.size()];
  if (cell.key != key) {
    const auto middle = [](std::int64_t k, double size) { return (static_cast<double>(k) + 0.5) * size; };
    cell.key = key;
    cell.ends.bottom_m = has_bottom ? middle(key.cell[3], key.depth_m) : ends.bottom_m;
    cell.ends.across_m = middle(key.cell[0], key.across_m);
    cell.ends.from_depth_m = std::min(middle(key.cell[1], key.depth_m), cell.ends.bottom_m);
    cell.ends.to_depth_m = std::min(middle(key.cell[2], key.depth_m), cell.ends.bottom_m);
    fill(cell, profile, losses);
  }
  const double farther = ends.across_m - cell.ends.across_m, from_lower = ends.from_depth_m - cell.ends.from_depth_m;
  const double to_lower = ends.to_depth_m - cell.ends.to_depth_m;
  const double bed_lower = has_bottom ? ends.bottom_m - cell.ends.bottom_m : 0;
  moved_.assign(cell.arrivals.begin(), cell.arrivals.end());
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    Arrival& one = moved_[k];
    const Directions& d = cell.directions[k];
    const double found_s = one.time_s;
    one.time_s +=
        (d.arrival_cos * farther + d.arrival_sin * to_lower) / cell.to_m_s - d.launch_sin * from_lower / cell.from_m_s;
    double missed_m = farther - to_lower / d.arrival_tan + from_lower / d.launch_tan;
    if (one.bottom_bounces > 0) {
      const double lower = 2 * one.bottom_bounces * bed_lower;
      one.time_s += d.bottom_sin * lower / d.bottom_m_s;
      missed_m -= lower / d.bottom_tan;
      one.bottom_m = ends.bottom_m;
    }
    const double bent_s_m = missed_m / one.widening_m2_s;
    if (std::abs(bent_s_m) * cell.to_m_s <= kMostBent) one.time_s += 0.5 * missed_m * bent_s_m;
    one.level_db -= 20 * std::log10(one.time_s / found_s);
  }
  return moved_;
}

/// Finds the arrivals between the cell's ends, strongest first.
void ArrivalCells::fill(Cell& cell, const SoundSpeedProfile& profile, const SoundLosses& losses) {
  find_arrivals(profile, cell.ends, losses, kKept, cell.arrivals);
  const auto stronger = [](const Arrival& a, const Arrival& b) {  // not std::stable_sort, which allocates
    return std::tuple(-a.level_db, a.time_s, a.launch_dip_rad) < std::tuple(-b.level_db, b.time_s, b.launch_dip_rad);
  };
  std::sort(cell.arrivals.begin(), cell.arrivals.end(), stronger);
  cell.from_m_s = profile.at(cell.ends.from_depth_m), cell.to_m_s = profile.at(cell.ends.to_depth_m);
  cell.directions.clear();
  for (const Arrival& one : cell.arrivals) {
    cell.directions.push_back({std::cos(one.arrival_dip_rad), std::sin(one.arrival_dip_rad),
                               std::tan(one.arrival_dip_rad), std::sin(one.launch_dip_rad),
                               std::tan(one.launch_dip_rad), std::sin(one.bottom_grazing_rad),
                               std::tan(one.bottom_grazing_rad), profile.at(one.bottom_m)});
  }
}

}  // namespace uwsim
