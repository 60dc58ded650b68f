#include "uwsim/core/check.h"
#include "uwsim/sim/simulation.h"

namespace uwsim {
namespace {

/// Transducers where they are when a packet begins to be sent, asked for one by one: most steps send nothing.
template <typename Place>
class Medium final : public LinkMedium {
 public:
  Medium(const LinkWater& water, const RayScene& scene, const Place& place)
      : water_(water), scene_(scene), place_(place) {}

  Reception hear(std::size_t from, std::size_t to) const override {
    return water_.hear(scene_, place_(from), place_(to));
  }
  std::array<double, 2> overhear(std::size_t from, std::size_t to) const override {
    return water_.overhear(place_(from), place_(to));
  }

 private:
  const LinkWater& water_;
  const RayScene& scene_;
  const Place& place_;
};

}  // namespace

void Simulation::set_link(const LinkSpec& spec) {
  spec.check();
  require(!link_, "link", "set", "can be set once");
  link_.emplace(Link{spec, PacketNetwork(spec.modem, 1 + vehicles_.size(), spec.faults, spec_.seed, step_ns_),
                     LinkWater(spec, world_.water)});
}

PacketNetwork& Simulation::link() {
  require(link_.has_value(), "link", "none", "the scenario must have one");
  return link_->network;
}

/// Of a vehicle it is at the body's origin.
Transducer Simulation::transducer(std::size_t node) const {
  if (node == 0) return {link_->spec.station_transducer_world_m, Eigen::Vector3d::Zero()};
  const BodyState& body = state(node - 1);
  return {body.world_from_body.position_m, body.world_from_body.orientation * body.linear_body_m_s()};
}

void Simulation::transmit() {
  const auto place = [this](std::size_t node) { return transducer(node); };
  link_->network.transmit(time_ns(), Medium(link_->water, *scene_, place));
}

Reception Simulation::link_reception(std::size_t from, std::size_t to) const {
  require(link_.has_value(), "link", "none", "the scenario must have one");
  return link_->water.hear(*scene_, transducer(from), transducer(to));
}

}  // namespace uwsim
