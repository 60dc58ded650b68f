#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "uwsim/acoustics/modem/arrival_cells.h"
#include "uwsim/acoustics/modem/packet_network.h"
#include "uwsim/core/pose.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/sim/position_exchange.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The parameters of the link between the station and the vehicles.
struct LinkSpec {
  ModemSpec modem;
  /// In the frame of the vehicle that carries the station, if one does.
  Eigen::Vector3d station_transducer_world_m = Eigen::Vector3d::Zero();
  NoiseSources noise;
  FluidBottom bottom;
  double acidity_ph = 8;
  std::vector<LinkFault> faults;

  /// Throws InvalidValue naming link.<field>.
  void check() const;
};

/// Position and velocity of a modem's transducer, world frame.
struct Transducer {
  Eigen::Vector3d position_world_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_world_m_s = Eigen::Vector3d::Zero();
};

/// The propagation of sound between transducers in a world: all arrivals (arrivals.h), through the sound-speed profile
/// and between a flat surface and a flat bottom, which is at the depth of the bed half-way between the transducers.
/// If significant arrivals have bounced off the bottom, Reception::bed_departure compares this depth with the bed at
/// the transducers and half-way to them. Beyond kUnevenBed, the times and levels of these arrivals are not those of the
/// true bed. Terrain in a ray's path blocks it (no diffraction); solids and hulls do not, because they are small. The
/// bed is compared with the ray at points whose spacing is the width of the first Fresnel zone (1.2 m over 100 m and
/// 8.5 m over 5 km at 26 kHz), or of a terrain cell if that is wider.
class LinkWater {
 public:
  LinkWater(const LinkSpec& spec, const Water& water);

  /// scene: without moving bodies.
  Reception receive(const RayScene& scene, const Transducer& from, const Transducer& to) const;
  /// Delay [s] and level [dB re 1 uPa] along the straight, unobstructed path.
  std::array<double, 2> interference(const Transducer& from, const Transducer& to) const;
  /// Mean slowness between two depths [s/m] along a straight path.
  double slowness_s_m(double from_depth_m, double to_depth_m) const;

 private:
  ModemSpec modem_;
  ModemWater water_;
  mutable ArrivalCells cells_;            // its results do not depend on which cells it holds
  mutable std::vector<HeardPath> paths_;  // these two are kept to reuse their memory
  mutable std::vector<double> bed_m_;
};

/// A simulation's link: its parameters, its packets, the water they travel through, and the instruments that use it.
struct Link {
  LinkSpec spec;
  PacketNetwork network;
  LinkWater water;
  std::vector<PositionExchange> exchanges;
};

}  // namespace uwsim
