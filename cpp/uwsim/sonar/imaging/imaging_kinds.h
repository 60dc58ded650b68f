#pragma once

#include "uwsim/sonar/imaging/imaging_sonar.h"

namespace uwsim {

/// The kinds that are built in, one file each in this folder.
std::span<const ImagingKind* const> imaging_kinds();

/// Throws InvalidValue with the known names.
const ImagingKind& imaging_kind(std::string_view name);

/// The parameters that all kinds share (ImagingAcoustics), then the kind's own.
std::vector<Parameter> imaging_parameters(const ImagingKind& kind);

/// Makes a sonar from its figures. `strengths_db`: see ImagingAcoustics. Throws InvalidValue that names sonar.<figure>
/// for an unknown or missing figure, or one out of range.
std::unique_ptr<ImagingSonar> imaging_sonar(std::string_view kind, ParameterValues figures,
                                            const std::vector<double>& strengths_db = {});

}  // namespace uwsim
