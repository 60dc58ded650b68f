#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "uwsim/sonar/acoustic_transmission.h"

// Ghosts: echoes of sound that reaches a surface, or returns from it, by more than one bounce.
//
// The axis of each beam is followed through at most two specular bounces, off the water's surface and off whatever else
// it meets (the bed, a hull, a wall), each of which counts as flat around the point where the ray meets it. Where the
// ray meets a surface after one or two bounces, after a path of length L, that surface scatters sound back to the head
// in two ways:
//   out and back along the same path: at range L, rho^2 sigma / L^2;
//   out along the straight path of length D, if it is free, and back along the bounces, or the reverse: at range
//   (L + D) / 2, 2 rho sigma / (L D).
// Both are times Omega 10^(-2 alpha range / 10) / cos i, as for the direct echo, sigma / D^2. By image sources,
// spreading over a path with flat bounces is that over a straight path of the same length. rho is the product of the
// bounces' reflection coefficients for power: Rayleigh's for a fluid bottom, 1 for the water's surface. The footprint,
// Omega L D, is that of the transmitter along one path and of the receiver along the other. sigma for two different
// angles is the geometric mean of their backscatter, which is exact for Lambert's law. On the straight path, the
// transmitter's pattern counts on the way out, and the beam's own on the way back, both Gaussian; the transmitter
// insonifies the fan's plane evenly, over the field of view. The reverse path counts only where it is received by the
// same beam.
//
// The second echo of a level bed and the mirror images of a target near the surface are special cases. Not modelled:
// waves and relief, which spread the reflected sound (levels are upper bounds over rough boundaries), refraction, and
// two bounces before as well as after the scattering.
namespace uwsim {
namespace {

constexpr int kBouncesMax = 2;
constexpr double kFaintest = 1e-4;  // of the patterns along the straight path, below which it does not count
constexpr float kClear_m = 2e-3f;   // a reflected ray starts this far from the surface, and 1e-5 of its path

struct Path {
  Eigen::Vector3f place_m;  // relative to the head
  Eigen::Vector3f direction;
  float length_m = 0;
  float reflected = 1;  // power
  bool going = true;
};

/// A place where a surface scatters sound that has bounced.
struct Scattering {
  std::size_t lane;
  Eigen::Vector3f place_m, normal;
  float length_m, cosine, reflected;
  Label label;
  double both_ways = 0;  // the patterns along the straight path, out and back
};

void load(RayPacket& packet, std::size_t lane, const Eigen::Vector3f& origin_m, const Eigen::Vector3f& direction) {
  packet.origin_x[lane] = origin_m.x();
  packet.origin_y[lane] = origin_m.y();
  packet.origin_z[lane] = origin_m.z();
  packet.direction_x[lane] = direction.x();
  packet.direction_y[lane] = direction.y();
  packet.direction_z[lane] = direction.z();
  packet.active[lane] = -1;
}

/// Returns for each place, in packets, if the straight path to it is free.
std::vector<bool> seen(const RayScene& scene, const Eigen::Vector3d& head, std::span<const Scattering> places) {
  std::vector<bool> free;
  for (std::size_t first = 0; first < places.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, places.size() - first);
    RayPacket packet{};
    for (std::size_t lane = 0; lane < count; ++lane) {
      if (places[first + lane].both_ways < kFaintest) continue;
      const Eigen::Vector3f& place_m = places[first + lane].place_m;
      load(packet, lane, Eigen::Vector3f::Zero(), place_m.normalized());
      packet.far_m[lane] = 0.999f * place_m.norm() - 0.01f;
    }
    Blocked blocked{};
    scene.occluded(head, packet, blocked);
    for (std::size_t lane = 0; lane < count; ++lane) free.push_back(blocked[lane] == 0);
  }
  return free;
}

}  // namespace

double AcousticMultibeam::lost(const Transmission& sent, double depth_m, double path_m) const {
  return std::pow(10, -0.1 * absorption_.mean_db_m(sent.depth_m, sent.absorbed_db, depth_m) * path_m);
}

double AcousticMultibeam::transmitted(double within_rad, double aside_rad) const {
  if (std::abs(within_rad) > 0.5 * (fan_.field_of_view_rad + spec_.parameters.beam_width_across_rad)) return 0;
  const double widths = aside_rad / spec_.parameters.beam_width_along_rad;
  return std::exp(-4 * std::numbers::ln2 * widths * widths);
}

double AcousticMultibeam::received(std::size_t beam, double within_rad) const {
  const double off_rad = std::remainder(within_rad - fan_.angles().at(static_cast<int>(beam)), 2 * std::numbers::pi);
  const double widths = off_rad / (spec_.parameters.beam_width_across_rad * footprint_.widening(beam));
  return std::exp(-4 * std::numbers::ln2 * widths * widths);
}

std::vector<float> AcousticMultibeam::mirror(const FluidBottom& fluid) {
  std::vector<float> powers;
  for (int k = 0; k <= kMirrorSteps; ++k) {
    const double grazing_rad = std::asin(static_cast<double>(k) / kMirrorSteps);
    powers.push_back(static_cast<float>(std::pow(10, -0.1 * bottom_loss_db(fluid, grazing_rad))));
  }
  return powers;
}

void AcousticMultibeam::add_ghosts(const Transmission& sent, std::size_t first, std::size_t last,
                                   OtherEchoes& others) const {
  const Eigen::Vector3d& head = sent.world_from_sonar.position_m;
  const auto farthest = static_cast<float>(fan_.range_max_m), head_z = static_cast<float>(head.z());
  std::vector<Scattering> places;
  for (std::size_t beam = first; beam < last; beam += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, last - beam);
    std::array<Path, kPacketRays> paths;
    for (std::size_t lane = 0; lane < count; ++lane) {
      paths[lane].place_m = Eigen::Vector3f::Zero();
      paths[lane].direction = sent.rotation * footprint_.axes().col(static_cast<Eigen::Index>(beam + lane));
    }
    places.clear();
    for (int bounce = 0; bounce <= kBouncesMax; ++bounce) {
      RayPacket packet{};
      HitPacket hits;
      for (std::size_t lane = 0; lane < count; ++lane) {
        const Path& path = paths[lane];
        if (!path.going) continue;
        load(packet, lane, path.place_m, path.direction);
        packet.near_m[lane] = bounce == 0 ? 0 : std::max(kClear_m, 1e-5f * path.length_m);
        packet.far_m[lane] = 2 * farthest - path.length_m;
      }
      sent.scene.cast(head, packet, hits, bounce == 0 ? RayOrder::kCoherent : RayOrder::kIncoherent);
      for (std::size_t lane = 0; lane < count; ++lane) {
        Path& path = paths[lane];
        if (!path.going) continue;
        const float to_surface_m = path.direction.z() > 0 ? -(head_z + path.place_m.z()) / path.direction.z()
                                                          : std::numeric_limits<float>::infinity();
        const bool surfaces = to_surface_m < std::min(hits.distance_m[lane], packet.far_m[lane]);
        const float step_m = surfaces ? to_surface_m : hits.distance_m[lane];
        path.going = step_m < packet.far_m[lane];
        if (!path.going) continue;
        path.place_m += step_m * path.direction;
        path.length_m += step_m;
        Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
        if (!surfaces) {
          normal = Eigen::Vector3f(hits.normal_x[lane], hits.normal_y[lane], hits.normal_z[lane]).normalized();
          const auto label = static_cast<Label>(hits.label[lane]);
          const float cosine = std::clamp(std::abs(normal.dot(path.direction)), 1e-3f, 1.0f);
          if (bounce > 0) {
            places.push_back({lane, path.place_m, normal, path.length_m, cosine, path.reflected, label});
          }
          const std::vector<float>& mirror = mirrors_[std::min<std::size_t>(label, mirrors_.size() - 1)];
          path.reflected *= mirror[static_cast<std::size_t>(cosine * kMirrorSteps + 0.5f)];
        }
        path.direction -= 2 * normal.dot(path.direction) * normal;
      }
    }
    for (Scattering& at : places) {
      const Eigen::Vector3f direct = sent.rotation.transpose() * at.place_m.normalized();
      const double within_rad = std::atan2(direct.y(), direct.x());
      const double aside_rad = std::asin(std::clamp(double{direct.z()}, -1.0, 1.0));
      at.both_ways = transmitted(within_rad, aside_rad) + received(beam + at.lane, within_rad);
    }
    const std::vector<bool> free = seen(sent.scene, head, places);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Scattering& at = places[k];
      const std::size_t index = beam + at.lane;
      const ScatterCurve& curve = curves_[std::min<std::size_t>(at.label, curves_.size() - 1)];
      const double depth_m = -(head.z() + double{at.place_m.z()});
      const double solid_angle_sr = spec_.parameters.beam_solid_angle_sr() * footprint_.widening(index);
      const double slope = std::sqrt(1 - at.cosine * at.cosine) / at.cosine;
      const double patch_rad = spec_.parameters.beam_width_across_rad * footprint_.widening(index);
      const auto add = [&](double path_m, double spread_m2, double scattered, double cosine) {
        RayEcho echo;
        echo.range_m = static_cast<float>(0.5 * path_m);
        if (!(echo.range_m < farthest)) return;
        echo.energy = static_cast<float>(solid_angle_sr * scattered / cosine * lost(sent, depth_m, path_m) / spread_m2);
        echo.width_m = static_cast<float>(std::hypot(sent.cell_m, patch_rad * double{at.length_m} * slope));
        echo.point_m2 = sent.cell_m * sent.cell_m;
        echo.cosine = at.cosine;
        if (echo.energy > 0) others[index].push_back(echo);
      };
      const double length_m = at.length_m, reflected = at.reflected;
      add(2 * length_m, length_m * length_m, reflected * reflected * curve(at.cosine), at.cosine);
      const double direct_m = at.place_m.norm();
      const Eigen::Vector3f direct = at.place_m / static_cast<float>(direct_m);
      const float cosine = std::clamp(std::abs(at.normal.dot(direct)), 1e-3f, 1.0f);
      if (at.both_ways < kFaintest || !free[k] || !(direct_m > kClear_m)) continue;
      add(length_m + direct_m, length_m * direct_m,
          at.both_ways * reflected * std::sqrt(double{curve(at.cosine)} * double{curve(cosine)}),
          std::sqrt(double{at.cosine} * double{cosine}));
    }
  }
}

}  // namespace uwsim
