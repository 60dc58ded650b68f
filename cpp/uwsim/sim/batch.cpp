#include "uwsim/sim/batch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <string>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"

namespace uwsim {
namespace {

// Costs differ between members, since those near the bed have contacts to solve, and a thread may be interrupted. With
// few shares, the threads that finish first would wait a long time for the last share.
constexpr std::size_t kSharesPerThread = 32;
constexpr std::size_t kStepsWorthThreads = 256;  // over all members; fewer steps take less time than starting a thread
constexpr std::size_t kReadsWorthThreads = 64;   // members whose motion is read
constexpr std::size_t kAxes = 6;
constexpr std::array<const char*, kAxes> kAxisNames = {"surge", "sway", "heave", "roll", "pitch", "yaw"};

/// Row k of values by name.
Actuators::Named named(std::span<const std::string> names, std::span<const double> values, std::size_t k) {
  Actuators::Named row;
  for (std::size_t i = 0; i < names.size(); ++i) row.emplace_back(names[i], values[names.size() * k + i]);
  return row;
}

using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

}  // namespace

/// Calls work(member, k) for the k-th chosen member. When all have finished, rethrows the first failing member's error.
template <typename Work>
void Batch::each(std::span<const std::size_t> chosen, int threads, const Work& work) const {
  std::vector<std::exception_ptr> errors(chosen.size());
  const std::size_t shares = kSharesPerThread * static_cast<std::size_t>(threads);
  parallel_batches(chosen.size(), std::max<std::size_t>(1, chosen.size() / shares), threads,
                   [&](std::size_t first, std::size_t last, std::size_t) {
                     for (std::size_t k = first; k < last; ++k) {
                       try {
                         work(chosen[k], k);
                       } catch (const InvalidValue& error) {
                         const std::string name = "batch[" + std::to_string(chosen[k]) + "]: ";
                         errors[k] = std::make_exception_ptr(InvalidValue(name + error.what()));
                       } catch (...) {
                         errors[k] = std::current_exception();
                       }
                     }
                   });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

Batch::Batch(const World& world, std::shared_ptr<const RayScene> scene, std::vector<MemberSpec> members, int threads)
    : world_(world), scene_(std::move(scene)), threads_(threads), specs_(std::move(members)), members_(specs_.size()) {
  require(threads_ >= 1 && threads_ <= 1024, "threads", threads_, "must be in [1, 1024]");
  require(!specs_.empty(), "n", specs_.size(), "must be at least 1");
  require(scene_ != nullptr, "scene", "none", "must be a RayScene");
  scene_->prepare();
  for (std::size_t k = 0; k < specs_.size(); ++k) all_.push_back(k);
  each(all_, threads_, [&](std::size_t member, std::size_t) { members_[member] = made(specs_[member]); });
}

std::shared_ptr<Simulation> Batch::made(const MemberSpec& spec) const {
  World world = world_;
  world.water = spec.water;
  auto simulation = std::make_shared<Simulation>(world, scene_, spec.simulation);
  for (const auto& vehicle : spec.vehicles) {
    require(vehicle && vehicle->craft, "vehicles.craft", "none", "must be set");
    simulation->add_vehicle(*vehicle);
  }
  for (const auto& object : spec.objects) {
    require(object && object->body.craft, "objects.craft", "none", "must be set");
    simulation->add_object(*object);
  }
  for (const TetherSpec& tether : spec.tethers) simulation->add_tether(tether);
  if (spec.link) simulation->set_link(*spec.link);
  return simulation;
}

void Batch::restart(std::span<const std::size_t> chosen, std::vector<MemberSpec> specs) {
  require(specs.empty() || specs.size() == chosen.size(), "specs", specs.size(), "must be one for each");
  std::vector<std::shared_ptr<Simulation>> fresh(chosen.size());
  each(chosen, threads_,
       [&](std::size_t member, std::size_t k) { fresh[k] = made(specs.empty() ? specs_[member] : specs[k]); });
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    members_[chosen[k]] = std::move(fresh[k]);
    if (!specs.empty()) specs_[chosen[k]] = std::move(specs[k]);
  }
}

void Batch::release(std::size_t vehicle, std::span<const std::size_t> chosen) {
  each(chosen, 1, [&](std::size_t member, std::size_t) { members_[member]->release(vehicle); });
}

void Batch::set_states(std::size_t vehicle, std::span<const std::size_t> chosen, std::span<const BodyState> states) {
  require(states.size() == chosen.size(), "states", states.size(), "must be one for each");
  each(chosen, threads_, [&](std::size_t member, std::size_t k) { members_[member]->set_state(vehicle, states[k]); });
}

void Batch::set_efforts(std::size_t vehicle, std::span<const double> efforts) {
  require(efforts.size() == kAxes * size(), "efforts", efforts.size(), "must be six for each member");
  for (std::size_t k = 0; k < efforts.size(); ++k) {
    if (std::abs(efforts[k]) <= 1) continue;  // false for NaN
    const std::string path = "efforts[" + std::to_string(k / kAxes) + "]." + kAxisNames.at(k % kAxes);
    require(false, path, efforts[k], "must be in [-1, 1]");
  }
  each(all_, 1, [&](std::size_t k, std::size_t) {
    members_[k]->actuators(vehicle).set_effort(Eigen::Map<const Vector6d>(&efforts[kAxes * k]));
  });
}

void Batch::set_wrenches(std::size_t vehicle, std::span<const double> wrenches_body) {
  require(wrenches_body.size() == kAxes * size(), "wrenches_body", wrenches_body.size(), "must be six for each member");
  each(all_, 1, [&](std::size_t k, std::size_t) {
    members_[k]->actuators(vehicle).set_wrench(Eigen::Map<const Vector6d>(&wrenches_body[kAxes * k]));
  });
}

void Batch::set_thrusters(std::size_t vehicle, std::span<const std::string> names, std::span<const double> commands) {
  require(commands.size() == names.size() * size(), "commands", commands.size(), "must be a value for each name");
  each(all_, 1,
       [&](std::size_t k, std::size_t) { members_[k]->actuators(vehicle).set_thrusters(named(names, commands, k)); });
}

void Batch::set_fins(std::size_t vehicle, std::span<const std::string> names, std::span<const double> angles_rad) {
  require(angles_rad.size() == names.size() * size(), "angles_rad", angles_rad.size(), "must be a value for each name");
  each(all_, 1,
       [&](std::size_t k, std::size_t) { members_[k]->actuators(vehicle).set_fins(named(names, angles_rad, k)); });
}

void Batch::step(std::uint64_t count) {
  const int threads = count < kStepsWorthThreads && size() * count < kStepsWorthThreads ? 1 : threads_;
  each(all_, threads, [&](std::size_t k, std::size_t) { members_[k]->step(count); });
}

void Batch::step_each(std::span<const std::uint64_t> counts) {
  require(counts.size() == size(), "counts", counts.size(), "must be one for each member");
  std::vector<std::size_t> moving;
  std::uint64_t steps = 0;
  for (const std::size_t k : all_) {
    if (counts[k] == 0) continue;
    moving.push_back(k);
    steps += std::min<std::uint64_t>(counts[k], kStepsWorthThreads);
  }
  each(moving, steps < kStepsWorthThreads ? 1 : threads_,
       [&](std::size_t k, std::size_t) { members_[k]->step(counts[k]); });
}

void Batch::motion(std::size_t vehicle, const MotionRows& rows) const {
  each(all_, size() < kReadsWorthThreads ? 1 : threads_, [&](std::size_t k, std::size_t) {
    const Simulation& simulation = *members_[k];
    const BodyState& state = simulation.state(vehicle);
    rows.times_ns[k] = simulation.time_ns();
    Eigen::Vector3d::Map(rows.positions_world_m + 3 * k) = state.world_from_body.position_m;
    Eigen::Vector4d::Map(rows.orientations_xyzw + 4 * k) = state.world_from_body.orientation.coeffs();
    Vector6d::Map(rows.velocities_body + kAxes * k) = state.velocity_body;
    rows.collisions[k] = simulation.collisions(vehicle);
    rows.released[k] = simulation.released(vehicle) ? 1 : 0;
  });
}

std::size_t Batch::reading_width(std::size_t vehicle, std::size_t sensor) const {
  return members_.front()->vehicle(vehicle).sensors.at(sensor).kind().reading_width();
}

void Batch::read_sensor(std::size_t vehicle, std::size_t sensor, bool with_noise, const SampleRows& rows) {
  const std::size_t width = reading_width(vehicle, sensor);
  each(all_, threads_, [&](std::size_t k, std::size_t) {
    const Sample& sample = members_[k]->read_sensor(vehicle, sensor, with_noise);
    std::copy_n(sample.values.begin(), width, rows.values + width * k);
    rows.stamps_ns[k] = sample.stamp_ns;
    rows.valid[k] = sample.valid ? 1 : 0;
  });
}

/// Calls ping(simulation, k, beams) for each member, and writes the heads' poses.
template <typename Ping>
void Batch::ping_each(std::size_t vehicle, std::size_t sonar, double* world_from_sonar, const Ping& ping) const {
  const std::size_t beams = members_.front()->sonar(vehicle, sonar).multibeam().beams();
  each(all_, threads_, [&](std::size_t k, std::size_t) {
    const Simulation& simulation = *members_[k];
    const std::size_t own = simulation.sonar(vehicle, sonar).multibeam().beams();
    require(own == beams, "sonar.beams", own, "must be as many as those of the first member");
    ping(simulation, k, beams);
    Eigen::Map<RowMajor4>(world_from_sonar + 16 * k) = simulation.world_from_sonar(vehicle, sonar).matrix();
  });
}

void Batch::ping(std::size_t vehicle, std::size_t sonar, const PingRows& rows, double* world_from_sonar) const {
  ping_each(vehicle, sonar, world_from_sonar, [&](const Simulation& simulation, std::size_t k, std::size_t beams) {
    simulation.ping(vehicle, sonar, rows.row(k, beams));
  });
}

void Batch::acoustic_ping(std::size_t vehicle, std::size_t sonar, const AcousticRows& rows,
                          double* world_from_sonar) const {
  ping_each(vehicle, sonar, world_from_sonar, [&](const Simulation& simulation, std::size_t k, std::size_t beams) {
    const AcousticPing ping = simulation.acoustic_ping(vehicle, sonar);
    const PingRows echoes = rows.echoes.row(k, beams);
    std::ranges::copy(ping.ranges_m, echoes.ranges_m);
    std::ranges::copy(ping.points_sonar_m, echoes.points_sonar_m);
    std::ranges::copy(ping.incidence_rad, echoes.incidence_rad);
    std::ranges::copy(ping.intensity_db, echoes.intensity_db);
    std::ranges::copy(ping.labels, echoes.labels);
    std::ranges::copy(ping.valid, echoes.valid);
    std::ranges::copy(ping.snr_db, rows.snr_db + k * beams);
    std::ranges::copy(ping.travel_time_s, rows.travel_time_s + k * beams);
    std::ranges::copy(ping.deviation_m, rows.deviation_m + k * beams);
    std::ranges::copy(ping.vertical_deviation_m, rows.vertical_deviation_m + k * beams);
    std::ranges::copy(ping.horizontal_deviation_m, rows.horizontal_deviation_m + k * beams);
    std::ranges::copy(ping.detections, rows.detections + k * beams);
  });
}

}  // namespace uwsim
