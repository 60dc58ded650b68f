#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "uwsim/core/parameter.h"
#include "uwsim/core/pose.h"
#include "uwsim/core/random.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/sonar/imaging/imaging_acoustics.h"

namespace uwsim {

/// Everything that a ping depends on apart from the sonar's parameters.
struct ImagingRequest {
  const RayScene& scene;
  const Water& water;
  /// Poses of the head: x ahead, y to port, z up. By default, there is one ping from each
  std::span<const Pose> world_from_sonar;
  std::span<const double> angles_rad;  ///< angles of a steered beam, about the sonar's +z; empty for other kinds
  const RandomStream& random;
  std::uint64_t first_ping = 0;  ///< number of the first ping; ping k draws its noise as first_ping + k
  int threads = 1;
  /// whether to identify the surface that each cell's echo comes from; see EchoesByLabel
  bool with_labels = false;
};

/// A named array of results, row-major.
struct ImagingArray {
  std::string_view name;
  std::vector<std::size_t> shape;
  std::vector<float> values;
};

/// An imaging sonar with its parameters. Each kind has its own file in this folder and an entry in imaging_kinds.cpp.
class ImagingSonar {
 public:
  explicit ImagingSonar(const ImagingAcoustics& acoustics) : acoustics_(acoustics) {}
  virtual ~ImagingSonar() = default;

  const ImagingAcoustics& acoustics() const { return acoustics_; }
  /// Returns the same arrays for the same request, regardless of the number of threads. Throws InvalidValue.
  virtual std::vector<ImagingArray> ping(const ImagingRequest& request) const = 0;

 private:
  ImagingAcoustics acoustics_;
};

/// A kind of imaging sonar: its name in YAML, and its parameters in addition to those of ImagingAcoustics.
struct ImagingKind {
  std::string_view name;
  std::string_view meaning;
  std::span<const Parameter> parameters;
  std::unique_ptr<ImagingSonar> (*make)(const ImagingAcoustics& acoustics, const ParameterValues& parameters);
};

template <typename Sonar>
std::unique_ptr<ImagingSonar> make_imaging_sonar(const ImagingAcoustics& acoustics, const ParameterValues& parameters) {
  return std::make_unique<Sonar>(acoustics, parameters);
}

}  // namespace uwsim
