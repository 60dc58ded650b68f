#pragma once

#include "uwsim/sonar/imaging/imaging_sonar.h"

namespace uwsim {

/// The built-in kinds, one file each in this folder.
std::span<const ImagingKind* const> imaging_kinds();

/// Throws InvalidValue that lists the known names.
const ImagingKind& imaging_kind(std::string_view name);

/// The parameters common to all kinds (ImagingAcoustics), then the kind's own.
std::vector<Parameter> imaging_parameters(const ImagingKind& kind);

/// Makes a sonar from its parameters. `strengths_db`: see ImagingAcoustics. Throws InvalidValue that names
/// sonar.<parameter> if one is unknown, missing or out of range.
std::unique_ptr<ImagingSonar> imaging_sonar(std::string_view kind, ParameterValues figures,
                                            const std::vector<double>& strengths_db = {});

}  // namespace uwsim
