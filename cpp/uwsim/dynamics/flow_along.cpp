#include "uwsim/dynamics/flow_along.h"

#include <algorithm>
#include <array>

#include "uwsim/world/water.h"

namespace uwsim {
namespace {

constexpr double kOfDepth = 0.5;      // the greatest distance between chosen points, relative to their depth
constexpr double kOffOfDepth = 0.01;  // how far the polynomial may pass beside a point, relative to its depth
constexpr double kLeastChosen = 5;    // along the whole line

}  // namespace

void FlowAlong::resize(std::size_t most) {
  flows_.resize(most);
  chosen_.reserve(most);
}

void FlowAlong::find(std::span<const Eigen::Vector3d> points_m, std::span<const double> along_m,
                     const WaterField& water, double time_s) {
  evaluated_ = 0;
  const auto* const known = dynamic_cast<const Water*>(&water);
  const bool is_smooth = known != nullptr && known->waves != nullptr && known->currents.empty();
  if (is_smooth) choose(points_m, along_m, water.wave_bound_m());
  if (!is_smooth || chosen_.size() < 4) {
    for (std::size_t i = 0; i < points_m.size(); ++i) evaluate(i, points_m[i], water, time_s);
    return;
  }
  for (const std::size_t i : chosen_) evaluate(i, points_m[i], water, time_s);
  for (std::size_t k = 0; k + 1 < chosen_.size(); ++k) interpolate(k, points_m, along_m, water, time_s);
}

/// From each chosen point, the next is as far as the shallowest of those between allows.
void FlowAlong::choose(std::span<const Eigen::Vector3d> points_m, std::span<const double> along_m,
                       double wave_bound_m) {
  chosen_.clear();
  const double most_m = (along_m.back() - along_m.front()) / (kLeastChosen - 1);
  for (std::size_t i = 0; i + 1 < points_m.size();) {
    chosen_.push_back(i);
    double depth_m = -points_m[i].z();
    std::size_t next = i + 1;
    while (next + 1 < points_m.size()) {
      depth_m = std::min({depth_m, -points_m[next].z(), -points_m[next + 1].z()});
      if (depth_m <= wave_bound_m || along_m[next + 1] - along_m[i] > std::min(most_m, kOfDepth * depth_m)) break;
      ++next;
    }
    i = next;
  }
  chosen_.push_back(points_m.size() - 1);
}

void FlowAlong::interpolate(std::size_t interval, std::span<const Eigen::Vector3d> points_m,
                            std::span<const double> along_m, const WaterField& water, double time_s) {
  const std::size_t begin = chosen_[interval], end = chosen_[interval + 1];
  if (end == begin + 1) return;
  const std::size_t first = std::min(interval == 0 ? 0 : interval - 1, chosen_.size() - 4);
  const std::array<std::size_t, 4> known = {chosen_[first], chosen_[first + 1], chosen_[first + 2], chosen_[first + 3]};
  for (std::size_t i = begin + 1; i < end; ++i) {
    WaterFlow flow;
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (const std::size_t a : known) {
      double weight = 1;
      for (const std::size_t b : known) {
        if (a != b) weight *= (along_m[i] - along_m[b]) / (along_m[a] - along_m[b]);
      }
      place += weight * points_m[a];
      flow.velocity_m_s += weight * flows_[a].velocity_m_s;
      flow.wave_acceleration_m_s2 += weight * flows_[a].wave_acceleration_m_s2;
    }
    if ((place - points_m[i]).norm() < kOffOfDepth * -points_m[i].z()) {
      flows_[i] = flow;
    } else {
      evaluate(i, points_m[i], water, time_s);
    }
  }
}

void FlowAlong::evaluate(std::size_t point, const Eigen::Vector3d& at_m, const WaterField& water, double time_s) {
  flows_[point] = water.flow_at(at_m, time_s);
  ++evaluated_;
}

}  // namespace uwsim
