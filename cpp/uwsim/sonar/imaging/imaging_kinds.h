#pragma once

#include "uwsim/sonar/imaging/imaging_sonar.h"

namespace uwsim {

/// The built-in kinds of imaging sonar, each defined in its own file in this folder.
std::span<const ImagingKind* const> imaging_kinds();

/// Returns the kind with this name. Throws InvalidValue listing the known names.
const ImagingKind& imaging_kind(std::string_view name);

/// Returns the parameters common to all kinds (ImagingAcoustics), followed by those of the kind.
std::vector<Parameter> imaging_parameters(const ImagingKind& kind);

/// Creates a sonar from its parameters. `strengths_db`, `materials`: see ImagingAcoustics. Throws InvalidValue naming
/// sonar.<parameter> if a parameter is unknown, missing or out of range.
std::unique_ptr<ImagingSonar> imaging_sonar(std::string_view kind, ParameterValues parameters,
                                            const std::vector<double>& strengths_db = {},
                                            const std::vector<BottomMaterial>& materials = {});

}  // namespace uwsim
