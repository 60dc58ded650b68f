#include <algorithm>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/sim/simulation.h"

namespace uwsim {
namespace {

constexpr const char* kRanging = "ranging/";  // prefix of the topics of instruments that share the modem

/// The acoustics between transducers at the start of a step. The poses of transducers are computed on demand, because
/// no packet is sent in most steps.
template <typename Place>
class Medium final : public LinkMedium {
 public:
  Medium(const LinkWater& water, const RayScene& scene, const Place& place)
      : water_(water), scene_(scene), place_(place) {}

  Reception receive(std::size_t from, std::size_t to) const override {
    return water_.receive(scene_, place_(from), place_(to));
  }
  std::array<double, 2> interference(std::size_t from, std::size_t to) const override {
    return water_.interference(place_(from), place_(to));
  }

 private:
  const LinkWater& water_;
  const RayScene& scene_;
  const Place& place_;
};

/// Returns true if a tether is broken that leads to the body: its own, or one of what its own is fastened to.
bool is_torn_off(const RigidBodyWorld& bodies, std::uint64_t body) {
  for (std::size_t hop = 0; hop < bodies.tethers(); ++hop) {
    std::size_t k = 0;
    while (k < bodies.tethers() && bodies.tether(k).spec().second.body != body) ++k;
    if (k == bodies.tethers()) return false;
    if (bodies.tether(k).broken()) return true;
    body = bodies.tether(k).spec().first.body;
  }
  return false;
}

}  // namespace

void Simulation::set_link(const LinkSpec& spec) {
  spec.check();
  require(!link_, "link", "set", "can be set once");
  link_.emplace(Link{spec,
                     PacketNetwork(spec.modem, 1 + vehicles_.size(), spec.faults, spec_.seed, step_ns_),
                     LinkWater(spec, world_.water),
                     {}});
  for (Vehicle& vehicle : vehicles_) vehicle.sensors.use_link(spec.modem.kind == LinkKind::kModem);
  join_instruments();
}

/// Creates an exchange for each instrument that shares the modem; existing exchanges continue.
void Simulation::join_instruments() {
  std::vector<PositionExchange> before = std::move(link_->exchanges);
  link_->exchanges.clear();
  for (std::size_t index = 0; index < vehicles_.size(); ++index) {
    const SensorRack& sensors = vehicles_[index].sensors;
    for (std::size_t k = 0; k < sensors.size(); ++k) {
      if (!sensors.at(k).uses_link()) continue;
      const auto known = std::find_if(before.begin(), before.end(), [&](const PositionExchange& other) {
        return other.node() == 1 + index && other.sensor() == k;
      });
      link_->exchanges.push_back(
          known != before.end()
              ? *known
              : PositionExchange(1 + index, k, link_->network.topic(kRanging + sensors.at(k).spec().name)));
    }
  }
}

PacketNetwork& Simulation::link() {
  require(link_.has_value(), "link", "none", "the scenario must have one");
  return link_->network;
}

/// A vehicle's transducer is at its body's origin.
Transducer Simulation::transducer(std::size_t node) const {
  if (node == 0 && spec_.carried_station) {
    const BodyState& carrier = state(spec_.carried_station->vehicle);
    const Eigen::Vector3d& at = link_->spec.station_transducer_world_m;  // in the carrier's frame
    return {carrier.world_from_body.point(at),
            carrier.world_from_body.orientation * (carrier.linear_body_m_s() + carrier.angular_body_rad_s().cross(at))};
  }
  if (node == 0) return {link_->spec.station_transducer_world_m, Eigen::Vector3d::Zero()};
  const BodyState& body = state(node - 1);
  return {body.world_from_body.position_m, body.world_from_body.orientation * body.linear_body_m_s()};
}

void Simulation::transmit() {
  PacketNetwork& network = link_->network;
  for (std::size_t k = 0; k < vehicles_.size() && link_->spec.modem.kind == LinkKind::kCable; ++k) {
    if (is_torn_off(bodies_, k)) network.cut_off(1 + k, true, time_ns());
  }
  for (PositionExchange& one : link_->exchanges) {
    one.request(vehicles_[one.node() - 1].sensors.at(one.sensor()), network, time_ns());
  }
  const auto place = [this](std::size_t node) { return transducer(node); };
  network.transmit(time_ns(), Medium(link_->water, *scene_, place));
  for (PositionExchange& one : link_->exchanges) {
    const Vehicle& vehicle = vehicles_[one.node() - 1];
    if (one.has_left(network)) one.left(snapshot(vehicle), vehicle.sensors.at(one.sensor()), network, time_ns());
  }
}

void Simulation::receive() {
  PacketNetwork& network = link_->network;
  const auto& deliveries = network.deliveries();
  std::size_t arrived = network.receive(time_ns());
  arrived = std::min(arrived, deliveries.size());  // the network has discarded older deliveries
  for (PositionExchange& one : link_->exchanges) {
    SensorRack& sensors = vehicles_[one.node() - 1].sensors;
    const NoisySensor& sensor = sensors.at(one.sensor());
    for (std::size_t k = deliveries.size() - arrived; k < deliveries.size(); ++k) {
      one.receive(deliveries[k], sensor, network);
    }
    if (!one.is_settled(time_ns())) continue;
    sensors.answer(one.sensor(), one.asked(), one.given_up(), tick_);
    one.settle();
  }
}

Reception Simulation::link_reception(std::size_t from, std::size_t to) const {
  require(link_.has_value(), "link", "none", "the scenario must have one");
  return link_->water.receive(*scene_, transducer(from), transducer(to));
}

}  // namespace uwsim
