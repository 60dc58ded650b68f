#include "uwsim/sonar/imaging/imaging_kinds.h"

#include <array>

namespace uwsim {

/// To add an imaging sonar, add a file and list its kind in both places below.
extern const ImagingKind kForwardLooking, kSideScan, kSingleBeam;

namespace {

constexpr std::array kKinds = {&kForwardLooking, &kSideScan, &kSingleBeam};

}  // namespace

std::span<const ImagingKind* const> imaging_kinds() { return kKinds; }

const ImagingKind& imaging_kind(std::string_view name) { return find_kind(kKinds, name, "sonar.kind"); }

std::vector<Parameter> imaging_parameters(const ImagingKind& kind) {
  const std::span<const Parameter> shared = imaging_acoustics_parameters();
  std::vector<Parameter> all(shared.begin(), shared.end());
  all.insert(all.end(), kind.parameters.begin(), kind.parameters.end());
  return all;
}

std::unique_ptr<ImagingSonar> imaging_sonar(std::string_view kind, ParameterValues parameters,
                                            const std::vector<double>& strengths_db,
                                            const std::vector<BottomMaterial>& materials) {
  const ImagingKind& of = imaging_kind(kind);
  complete_parameters(parameters, imaging_parameters(of), "sonar");
  return of.make(imaging_acoustics(parameters, strengths_db, materials), parameters);
}

}  // namespace uwsim
