#include "uwsim/dynamics/hull_waves.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <sstream>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kMostPhase_rad = 1;  // rad in a step, with room to the limit of stability, 2.8
constexpr double kStageTimes[] = {0, 0.5, 0.5, 1};

double heading_of(const BodyState& state) {
  const Eigen::Matrix3d rotation = state.world_from_body.rotation();
  return std::atan2(rotation(1, 0), rotation(0, 0));
}

/// Throws InvalidValue unless the table covers the sea.
void require_covered(const std::string& body, const Radiation& table, const std::vector<WaveComponent>& sea) {
  double all = 0, beyond = 0;
  for (const WaveComponent& wave : sea) {
    const double energy = wave.amplitude_m * wave.amplitude_m;
    all += energy;
    if (wave.angular_frequency_rad_s < table.least_rad_s || wave.angular_frequency_rad_s > table.most_rad_s)
      beyond += energy;
  }
  if (all == 0 || beyond <= HullWaves::kLeftOut * all) return;
  std::ostringstream value, rule;
  value << table.least_rad_s << " to " << table.most_rad_s << " rad/s";
  rule << "the table's frequencies leave out " << std::round(100 * beyond / all)
       << " % of the energy of the sea's waves, must be at most " << 100 * HullWaves::kLeftOut << " %";
  require(false, "vehicle '" + body + "' radiation", value.str(), rule.str());
}

}  // namespace

HullWaves::HullWaves(const std::string& body, std::shared_ptr<const Craft> craft, const Water& water, double step_s)
    : craft_(std::move(craft)) {
  const Radiation& table = *craft_->parameters().radiation;
  if (water.waves) {
    const std::vector<WaveComponent> sea = water.waves->components();
    require_covered(body, table, sea);
    division_ = craft_->hull().division_afloat(water);
    for (const WaveComponent& wave : sea) {
      const double number = wave_number_rad_m(wave.angular_frequency_rad_s, water.waves->depth_m(), water.gravity_m_s2);
      const Eigen::Vector2d number_rad_m(number * std::cos(wave.heading_rad), number * std::sin(wave.heading_rad));
      components_.push_back({wave, number_rad_m});
    }
  }
  for (const Radiation::Section& section : table.sections) {
    const double fastest = section.omega_rad_s * std::max(1.0, 2 * section.damping_ratio);
    require(fastest * step_s <= kMostPhase_rad, "vehicle '" + body + "' radiation", fastest,
            "rad/s, must be at most 1 / step_s: the step is too long for the waves of so small a hull");
  }
  for (Resonators* each : {&now_, &start_, &next_, &stage_, &rate_}) each->resize(table.sections.size());
  forces_.first_order.resize(components_.size(), Radiation::Force::Zero());
  if (!table.drift.empty()) forces_.drift.resize(components_.size(), Radiation::Drift::Zero());
}

void HullWaves::remember(const HullWaves& other) {
  if (other.now_.size() == now_.size()) now_ = other.now_;
}

void HullWaves::forget() { std::ranges::fill(now_, Resonator()); }

void HullWaves::face(double heading_rad, Forces& forces) const {
  const Radiation& table = *craft_->parameters().radiation;
  for (std::size_t k = 0; k < components_.size(); ++k) {
    const WaveComponent& wave = components_[k].wave;
    const double omega = wave.angular_frequency_rad_s, toward = wave.heading_rad - heading_rad;
    forces.first_order[k] = table.diffraction_at(division_, omega, toward);
    if (!forces.drift.empty()) forces.drift[k] = table.drift_at(division_, omega, toward);
  }
}

/// The wrench of the sea beyond the pressure of the undisturbed waves, in the level axes that the hull heads along.
Vector6d HullWaves::deflected(const Forces& forces, const Eigen::Vector3d& position_m, double time_s) const {
  Vector6d level = Vector6d::Zero();
  std::complex<double> sum = 0;                        // a exp(i phase)
  Eigen::Vector3cd drifts = Eigen::Vector3cd::Zero();  // a D exp(i phase)
  for (std::size_t k = 0; k < components_.size(); ++k) {
    const Component& wave = components_[k];
    const double phase = wave.number_rad_m.x() * position_m.x() + wave.number_rad_m.y() * position_m.y() -
                         wave.wave.angular_frequency_rad_s * time_s + wave.wave.phase_rad;
    const double cosine = std::cos(phase), sine = std::sin(phase);
    const Radiation::Force& force = forces.first_order[k];
    level += wave.wave.amplitude_m * (cosine * force.col(0) - sine * force.col(1));
    if (forces.drift.empty()) continue;
    const std::complex<double> of_wave = wave.wave.amplitude_m * std::complex<double>(cosine, sine);
    sum += of_wave;
    drifts += of_wave * forces.drift[k];
  }
  if (forces.drift.empty()) return level;
  const Radiation::Drift slow = (std::conj(sum) * drifts).real();
  level.head<2>() += slow.head<2>();
  level(5) += slow(2);
  return level;
}

HullWaveWrenches HullWaves::wrenches(const Resonators& resonators, const Forces& forces, const BodyState& state,
                                     double share, double time_s) const {
  HullWaveWrenches all;
  if (share == 0) return all;
  const double root = std::sqrt(share);
  const std::vector<Radiation::Section>& sections = craft_->parameters().radiation->sections;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    all.radiation -= root * (sections[k].by_speed * resonators[k].speed);
    all.radiation -= root * (sections[k].by_place * resonators[k].place);
  }
  if (components_.empty()) return all;
  const Vector6d level = deflected(forces, state.world_from_body.position_m, time_s);
  Vector6d world;
  const Eigen::AngleAxisd turn(heading_of(state), Eigen::Vector3d::UnitZ());
  world << turn * Eigen::Vector3d(level.head<3>()), turn * Eigen::Vector3d(level.tail<3>());
  all.diffraction = share * in_body_axes(world, state.world_from_body.orientation);
  return all;
}

void HullWaves::rates(const Resonators& resonators, const Vector6d& drive_body, Resonators& out) const {
  const std::vector<Radiation::Section>& sections = craft_->parameters().radiation->sections;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    const double omega = sections[k].omega_rad_s, damping = sections[k].damping_ratio;
    const auto& [place, speed] = resonators[k];
    out[k] = {speed, drive_body - 2 * damping * omega * speed - omega * omega * place};
  }
}

/// Adds the share of a stage, whose rates are in rate_, to next_, and moves stage_ to the following one.
void HullWaves::runge_kutta_stage(std::size_t stage, double step_s) {
  const double share_s = kStageShares[stage] * step_s, ahead_s = stage < 3 ? kStageTimes[stage + 1] * step_s : 0;
  for (std::size_t k = 0; k < rate_.size(); ++k) {
    next_[k].place += share_s * rate_[k].place;
    next_[k].speed += share_s * rate_[k].speed;
    stage_[k] = {start_[k].place + ahead_s * rate_[k].place, start_[k].speed + ahead_s * rate_[k].speed};
  }
}

BodyState HullWaves::advance(const BodyState& state, const Loads& loads, const WaterField& water, double time_s,
                             double step_s) {
  face(heading_of(state), forces_);
  next_ = stage_ = start_;
  BodyState at = state;
  Rate sum{Eigen::Vector3d::Zero(), Eigen::Vector4d::Zero(), Vector6d::Zero()};
  for (std::size_t k = 0; k < wrenches_.size(); ++k) {
    const double now_s = time_s + kStageTimes[k] * step_s;
    Craft::Load load = craft_->load(at, loads.at(at.world_from_body.orientation), water, now_s);
    wrenches_[k] = wrenches(stage_, forces_, at, load.floating, now_s);
    load.wrench_body += wrenches_[k].radiation + wrenches_[k].diffraction;
    const Rate rate = rate_at(at, craft_->accelerated(load));
    sum.position += kStageShares[k] * rate.position;
    sum.quaternion += kStageShares[k] * rate.quaternion;
    sum.velocity += kStageShares[k] * rate.velocity;
    rates(stage_, std::sqrt(load.floating) * at.velocity_body, rate_);
    runge_kutta_stage(k, step_s);
    if (k < 3) at = moved_at(state, rate, kStageTimes[k + 1] * step_s);
  }
  return moved_at(state, sum, step_s);
}

void HullWaves::run_out(double step_s) {
  next_ = stage_ = start_;
  for (std::size_t k = 0; k < wrenches_.size(); ++k) {
    rates(stage_, Vector6d::Zero(), rate_);
    runge_kutta_stage(k, step_s);
  }
}

HullWaveWrenches HullWaves::wrenches_at(const BodyState& state, const WaterField& water, double time_s) const {
  Forces forces = forces_;
  face(heading_of(state), forces);
  return wrenches(now_, forces, state, craft_->load(state, Vector6d::Zero(), water, time_s).floating, time_s);
}

void HullWaves::exchange_state(StateArchive& archive) {
  archive.same("resonators", now_.size());
  for (Resonator& each : now_) {
    archive(each.place);
    archive(each.speed);
  }
  next_ = now_;
}

}  // namespace uwsim
