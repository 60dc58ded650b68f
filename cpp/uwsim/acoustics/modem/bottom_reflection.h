#pragma once

#include <complex>

#include "uwsim/acoustics/modem/boundary_loss.h"

namespace uwsim {

/// The Rayleigh reflection coefficient of a plane wave at a fluid bottom, for exp(-i w t). bottom_loss_db is the loss
/// due to its magnitude; the source and limits are stated there.
std::complex<double> bottom_reflection(const FluidBottom& bottom, double grazing_rad);

}  // namespace uwsim
