#pragma once

#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// Coloured noise a and its companion in quadrature b, both of the same stationary variance:
///
///   a' = w b,   b' = -w a - 2 d w b + white noise,   d = 0.5.
///
/// Their spectra lie in a band of about an octave to either side of w; that of b is zero at zero frequency, and a is
/// smooth: it has a derivative. This is the second-order wave-frequency model of dynamic positioning (Saelid, Jenssen
/// and Balchen 1983, IEEE Trans. Automatic Control 28:331; Fossen 2011, "Handbook of Marine Craft Hydrodynamics and
/// Motion Control", sec. 8.2.6). Advances a and b, which are the errors `first` and first + 1, over dt.
void swing(FilterState& state, int first, double frequency_rad_s, double variance, double dt_s);

}  // namespace uwsim
