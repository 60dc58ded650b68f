#include "uwsim/estimation/navigation_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kHorizon_ns = static_cast<std::uint64_t>(NavigationFilter::kHorizon_s * 1e9);
constexpr std::uint64_t kCheckpoint_ns = 100'000'000;
// If the filter doubts its estimate again within this time, then more errors are wrong than those that the aid
// observes, for example after a collision. The filter then restarts from its present estimate, with the standard
// deviations below, which are assumed for an ROV that is thrown about.
constexpr std::uint64_t kDoubtAgain_ns = 5'000'000'000;
// For some time after the filter has doubted its estimate (kProbation_ns), it also restarts if the IMU's estimated
// biases become implausibly large, which indicates an attitude error. It does not restart again until kSettling_ns
// after a restart.
constexpr std::uint64_t kProbation_ns = 30'000'000'000, kSettling_ns = 3'000'000'000;
constexpr double kImplausible = 4;  // standard deviations
constexpr double kLostPosition_m = 2, kLostVelocity_m_s = 1, kLostAttitude_rad = 0.15;
constexpr std::size_t kForgetFrom = 2048;  // number of processed events from which old ones are erased, all at once

}  // namespace

NavigationFilter::NavigationFilter(const ImuErrors& imu, const Eigen::Vector3d& imu_body_m, double gravity_m_s2)
    : inertial_(imu, gravity_m_s2), imu_body_m_(imu_body_m), aid_biases_(inertial_.matrix_biases()) {
  require(imu.period_s > 0, "imu.period_s", imu.period_s, "must be positive");
  require(imu.averaging_s >= 0 && imu.averaging_s <= imu.period_s, "imu.averaging_s", imu.averaging_s,
          "must be from 0 to period_s");
  require(gravity_m_s2 > 0, "gravity_m_s2", gravity_m_s2, "must be positive");
}

int NavigationFilter::add_aid(std::unique_ptr<Aid> aid) {
  const std::vector<BiasModel> biases = aid->biases();
  require(aids_.size() < kMaxAids, "aids", aids_.size() + 1, "must be at most 8");
  require(kAidBias + aid_biases_.size() + biases.size() <= kMaxErrors, "errors",
          kAidBias + aid_biases_.size() + biases.size(), "must be at most 72");
  require(aid->width() <= kMaxReading, "reading", aid->width(), "must be of at most 8 values");
  aid->index = static_cast<int>(aids_.size());
  aid->first_bias = kAidBias + static_cast<int>(aid_biases_.size());
  aid_biases_.insert(aid_biases_.end(), biases.begin(), biases.end());
  aids_.push_back(std::move(aid));
  return static_cast<int>(aids_.size()) - 1;
}

void NavigationFilter::start(const FilterStart& start) {
  FilterState& state = present_ = {};
  state.time_ns = start.time_ns;
  state.position_m = start.world_from_body.point(imu_body_m_);
  state.velocity_m_s = start.velocity_world_m_s;
  state.orientation = start.world_from_body.orientation.normalized();
  const int n = kAidBias + static_cast<int>(aid_biases_.size());
  state.covariance = ErrorMatrix::Zero(n, n);
  state.covariance.diagonal().segment<3>(kPosition) = start.position_std_m.cwiseAbs2();
  state.covariance.diagonal().segment<3>(kVelocity).setConstant(start.velocity_std_m_s * start.velocity_std_m_s);
  state.covariance.diagonal().segment<3>(kAttitude) = start.attitude_std_rad.cwiseAbs2();
  for (const auto& aid : aids_) aid->begin(state);
  set_biases();
  events_.clear();
  checkpoints_.clear();
  next_ = changed_ = 0;
  too_late_ = 0;
  checkpoint();
}

/// Resets all biases to their prior values. The rest of the covariance is unchanged.
void NavigationFilter::set_biases() {
  const int n = present_.errors();
  present_.rate_bias_rad_s.setZero();
  present_.force_bias_m_s2.setZero();
  present_.aid_bias = ErrorVector::Zero(n - kAidBias);
  present_.covariance.diagonal().segment<3>(kRateBias).setConstant(inertial_.errors().rate_bias.variance());
  present_.covariance.diagonal().segment<3>(kForceBias).setConstant(inertial_.errors().force_bias.variance());
  for (int k = kAidBias; k < n; ++k) {
    present_.covariance(k, k) = aid_biases_[static_cast<std::size_t>(k - kAidBias)].variance();
  }
}

bool NavigationFilter::biases_are_plausible() const {
  const auto are = [](const Eigen::Vector3d& bias, const BiasModel& model) {
    return bias.cwiseAbs().maxCoeff() <= kImplausible * std::sqrt(model.variance());
  };
  return are(present_.rate_bias_rad_s, inertial_.errors().rate_bias) &&
         are(present_.force_bias_m_s2, inertial_.errors().force_bias);
}

/// Corrects the present state, and restarts if the filter turns out to have diverged.
void NavigationFilter::correct(const Event& reading) {
  const auto aid = static_cast<std::size_t>(reading.source);
  AidCounts& counts = present_.counts[aid];
  if (!aids_[aid]->is_credible(present_, reading.values)) {
    counts.rejected += 3;  // the errors that it sees, one by one
    return;
  }
  const std::uint64_t doubts = present_.doubts, accepted = counts.accepted, rejected = counts.rejected;
  aids_[aid]->correct(present_, reading.values);
  const std::uint64_t outliers = counts.rejected - rejected, good = counts.accepted - accepted;
  const bool doubted = present_.doubts != doubts;
  const std::uint64_t now_ns = present_.time_ns;
  if (outliers + good > 0) counts.in_a_row = 2 * outliers >= good && !doubted ? counts.in_a_row + 1 : 0;
  if (present_.doubts == 0) return;
  const bool again = doubted && doubts > 0 && now_ns < present_.doubted_ns + kDoubtAgain_ns;
  if (doubted) {
    present_.doubted_ns = now_ns;
    for (const auto& each : aids_) {
      if (each != aids_[aid]) each->contradict(present_, present_.doubted_up_m);
    }
  }
  const bool on_probation =
      now_ns < present_.doubted_ns + kProbation_ns && now_ns >= present_.restarted_ns + kSettling_ns;
  if (again || (on_probation && !biases_are_plausible())) restart();
}

/// Restarts the filter in place: discards everything it has estimated except the means of position, velocity and
/// attitude, and what it knows of the water, which no collision changes.
void NavigationFilter::restart() {
  present_.restarted_ns = present_.time_ns;
  const Eigen::Vector3d position = present_.covariance.diagonal().segment<3>(kPosition);
  const ErrorVector biases = present_.aid_bias, variances = present_.covariance.diagonal();
  present_.covariance.setZero();
  present_.covariance.diagonal().segment<3>(kPosition) = position.array() + kLostPosition_m * kLostPosition_m;
  present_.covariance.diagonal().segment<3>(kVelocity).setConstant(kLostVelocity_m_s * kLostVelocity_m_s);
  present_.covariance.diagonal().segment<3>(kAttitude).setConstant(kLostAttitude_rad * kLostAttitude_rad);
  set_biases();
  for (int k = kAidBias; k < present_.errors(); ++k) {
    if (!aid_biases_[static_cast<std::size_t>(k - kAidBias)].of_water) continue;
    present_.aid_bias[k - kAidBias] = biases[k - kAidBias];
    present_.covariance(k, k) = variances[k];
  }
}

void NavigationFilter::add_imu(std::uint64_t time_ns, const double* rate_and_force) {
  Event event{time_ns, kImu, {}};
  std::copy_n(rate_and_force, 6, event.values);
  require(!checkpoints_.empty(), "filter", "not started", "start() comes first");
  FilterState& first = checkpoints_.front().state;
  if (time_ns == first.time_ns && time_ns == present_.time_ns) {  // where the first interval begins
    const double* v = event.values;
    first.sample.rate_rad_s = present_.sample.rate_rad_s = {v[0], v[1], v[2]};
    first.sample.force_m_s2 = present_.sample.force_m_s2 = {v[3], v[4], v[5]};
    first.sample.time_ns = present_.sample.time_ns = time_ns;
    return;
  }
  insert(event);
}

void NavigationFilter::add_silence(std::uint64_t time_ns) { insert({time_ns, kSilence, {}}); }

void NavigationFilter::add_reading(int aid, std::uint64_t time_ns, std::uint64_t arrival_ns, const double* reading) {
  require(aid >= 0 && aid < aids(), "aid", aid, "must be that of an aid");
  if (arrival_ns > time_ns + kHorizon_ns) {
    ++too_late_;
    return;
  }
  Event event{time_ns, aid, {}};
  std::copy_n(reading, aids_[static_cast<std::size_t>(aid)]->width(), event.values);
  insert(event);
}

void NavigationFilter::insert(const Event& event) {
  require(!checkpoints_.empty(), "filter", "not started", "start() comes first");
  if (event.time_ns <= checkpoints_.front().state.time_ns) {
    too_late_ += event.source >= 0;
    return;
  }
  // Simultaneous events are sorted by source, the IMU first, so that the order in which they are added does not matter.
  const auto later = [](const Event& a, const Event& b) {
    return a.time_ns != b.time_ns ? a.time_ns < b.time_ns : a.source < b.source;
  };
  const auto place = std::upper_bound(events_.begin(), events_.end(), event, later);
  const auto index = static_cast<std::size_t>(place - events_.begin());
  changed_ = std::min(changed_, index);
  events_.insert(place, event);
}

void NavigationFilter::catch_up() {
  if (changed_ < next_) rewind_to(changed_);
  while (next_ < events_.size() && apply(next_)) {
    ++next_;
    if (present_.time_ns >= checkpoints_.back().state.time_ns + kCheckpoint_ns) checkpoint();
  }
  changed_ = events_.size();
  forget();
}

void NavigationFilter::rewind_to(std::size_t event) {
  while (checkpoints_.size() > 1 && checkpoints_.back().next > event) checkpoints_.pop_back();
  present_ = checkpoints_.back().state;
  next_ = checkpoints_.back().next;
}

const NavigationFilter::Event* NavigationFilter::next_inertial(std::size_t from) const {
  const auto found = std::find_if(events_.begin() + static_cast<std::ptrdiff_t>(from), events_.end(),
                                  [](const Event& e) { return e.source < 0; });
  return found == events_.end() ? nullptr : &*found;
}

/// Returns whether the event could be processed; a reading newer than the IMU's last sample must wait.
bool NavigationFilter::apply(std::size_t index) {
  const Event& event = events_[index];
  if (event.time_ns > present_.time_ns) {
    const Event* inertial = next_inertial(index);
    if (inertial == nullptr) return false;
    advance(*inertial, event.time_ns);
  }
  if (event.source >= 0) correct(event);
  return true;
}

void NavigationFilter::advance(const Event& inertial, std::uint64_t time_ns) {
  const double dt_s = 1e-9 * static_cast<double>(time_ns - present_.time_ns);
  if (inertial.source == kSilence) {
    inertial_.coast(present_, time_ns, aid_biases_);
  } else {
    const double* v = inertial.values;
    inertial_.advance(present_, time_ns, {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, inertial.time_ns}, aid_biases_);
  }
  for (const auto& aid : aids_) aid->age(present_, dt_s);
}

void NavigationFilter::checkpoint() { checkpoints_.push_back({present_, next_}); }

/// The index of the last checkpoint that is early enough for the latest reading that may still arrive.
std::size_t NavigationFilter::last_before_horizon() const {
  const auto after = std::find_if(checkpoints_.begin(), checkpoints_.end(), [&](const Checkpoint& c) {
    return c.state.time_ns + kHorizon_ns > present_.time_ns;
  });
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - checkpoints_.begin() - 1, 0));
}

void NavigationFilter::forget() {
  if (next_ >= kForgetFrom) forget_all_but(last_before_horizon());
}

void NavigationFilter::forget_all_but(std::size_t from) {
  checkpoints_.erase(checkpoints_.begin(), checkpoints_.begin() + static_cast<std::ptrdiff_t>(from));
  const std::size_t gone = checkpoints_.front().next;
  events_.erase(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(gone));
  for (Checkpoint& c : checkpoints_) c.next -= gone;
  next_ -= gone;
  changed_ -= gone;
}

Eigen::Vector3d NavigationFilter::position_body_origin_m() const {
  return present_.position_m - present_.orientation * imu_body_m_;
}

Eigen::Vector3d NavigationFilter::velocity_body_m_s() const {
  return present_.orientation.conjugate() * present_.velocity_m_s - present_.rate_rad_s().cross(imu_body_m_);
}

}  // namespace uwsim
