#include "uwsim/dynamics/flow_along.h"

#include <algorithm>
#include <array>

#include "uwsim/world/water.h"

namespace uwsim {
namespace {

constexpr double kOfDepth = 0.5;      // the greatest distance between chosen points, relative to their depth
constexpr double kOffOfDepth = 0.01;  // how far the polynomial may pass beside a point, relative to its depth
constexpr double kLeastChosen = 5;    // along the whole line
constexpr double kAlways = std::numeric_limits<double>::infinity();

}  // namespace

struct FlowAlong::Search {
  Line line;
  const WaterField& water;
  const Water* known;  // null: another kind of water
  double time_s, wave_bound_m;
};

void FlowAlong::resize(std::size_t most) {
  flows_.resize(most);
  wet_.resize(most);
  chosen_.reserve(most);
}

void FlowAlong::find(const Line& line, const WaterField& water, double time_s) {
  evaluated_ = 0;
  const Search search{line, water, dynamic_cast<const Water*>(&water), time_s, water.wave_bound_m()};
  const std::size_t count = line.points_m.size();
  const bool is_smooth = search.known != nullptr && search.known->waves != nullptr && search.known->currents.empty();
  if (is_smooth) choose(search);
  if (!is_smooth || chosen_.size() < 4) {
    for (std::size_t i = 0; i < count; ++i) evaluate(search, i);
    return;
  }
  for (const std::size_t i : chosen_) evaluate(search, i);
  for (std::size_t k = 0; k + 1 < chosen_.size(); ++k) interpolate(search, k);
}

/// From each chosen point, the next is as far as the shallowest of those between allows.
void FlowAlong::choose(const Search& search) {
  const auto& [points_m, along_m, half_heights_m] = search.line;
  chosen_.clear();
  const double most_m = (along_m.back() - along_m.front()) / (kLeastChosen - 1);
  for (std::size_t i = 0; i + 1 < points_m.size();) {
    chosen_.push_back(i);
    double depth_m = -points_m[i].z();
    std::size_t next = i + 1;
    while (next + 1 < points_m.size()) {
      depth_m = std::min({depth_m, -points_m[next].z(), -points_m[next + 1].z()});
      if (depth_m <= search.wave_bound_m || along_m[next + 1] - along_m[i] > std::min(most_m, kOfDepth * depth_m))
        break;
      ++next;
    }
    i = next;
  }
  chosen_.push_back(points_m.size() - 1);
}

void FlowAlong::interpolate(const Search& search, std::size_t interval) {
  const auto& [points_m, along_m, half_heights_m] = search.line;
  const std::size_t begin = chosen_[interval], end = chosen_[interval + 1];
  if (end == begin + 1) return;
  const std::size_t first = std::min(interval == 0 ? 0 : interval - 1, chosen_.size() - 4);
  const std::array<std::size_t, 4> known = {chosen_[first], chosen_[first + 1], chosen_[first + 2], chosen_[first + 3]};
  for (const std::size_t a : known) {
    if (wet_[a] == 0) flows_[a] = search.known->main_flow_at(points_m[a], search.time_s, kAlways, nullptr);
  }
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
    if ((place - points_m[i]).norm() < kOffOfDepth * -points_m[i].z() && !is_near(search, i)) {
      flows_[i] = flow;
      wet_[i] = 1;
    } else {
      evaluate(search, i);
    }
  }
}

/// Returns true if the surface may cross what the point stands for.
bool FlowAlong::is_near(const Search& search, std::size_t i) const {
  return !search.line.half_heights_m.empty() &&
         std::abs(search.line.points_m[i].z()) < search.line.half_heights_m[i] + search.wave_bound_m;
}

void FlowAlong::evaluate(const Search& search, std::size_t i) {
  const Eigen::Vector3d& at_m = search.line.points_m[i];
  const bool near = is_near(search, i), is_dry = !near && !search.line.half_heights_m.empty() && at_m.z() > 0;
  wet_[i] = is_dry ? 0 : 1;
  if (is_dry) return;
  const double half_m = near ? search.line.half_heights_m[i] : kAlways;
  double surface_m = 0;
  if (search.known != nullptr) {
    flows_[i] = search.known->main_flow_at(at_m, search.time_s, half_m, near ? &surface_m : nullptr);
  } else {
    flows_[i] = search.water.flow_at(at_m, search.time_s);
    if (near) surface_m = search.water.surface_height_at(at_m.x(), at_m.y(), search.time_s);
  }
  if (near) wet_[i] = std::clamp(0.5 + (surface_m - at_m.z()) / (2 * half_m), 0.0, 1.0);
  ++evaluated_;
}

}  // namespace uwsim
