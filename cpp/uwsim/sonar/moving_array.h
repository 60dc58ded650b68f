#pragma once

namespace uwsim {

/// Speckle as seen by a moving array: scatterers that are fixed in the world return different phases as the array
/// moves. By the van Cittert-Zernike theorem (Goodman 2015, "Statistical Optics", ch. 5, not consulted), applied to the
/// two-way path, the correlation of amplitudes is the autocorrelation of the aperture at twice the displacement, that
/// is, the Fourier transform of the beam pattern. For a line array, whose pattern is a squared sinc, it falls linearly
/// to 0 at half the array's length. Speckle fields use this length [m] as the unit in which simplex_nodes places the
/// head.
///
/// `wave_lengths`: length of the array. The speed of sound is nominal, 1500 m/s, so that a field does not change with
/// the water.
inline double half_array_m(double wave_lengths, double frequency_hz) {
  return 0.5 * wave_lengths * 1500 / frequency_hz;
}

}  // namespace uwsim
