#pragma once

namespace uwsim {

/// Speckle as seen by a moving array: scatterers that are fixed in the world return different phases as the array
/// moves. By van Cittert and Zernike's theorem (Goodman 2015, "Statistical Optics", ch. 5; from memory), applied to the
/// path out and back, the correlation of amplitudes is the autocorrelation of the aperture at twice the displacement:
/// that of a line array falls linearly to 0 at half its length. Speckle fields vary with the head's place through
/// simplex_nodes, in units of this length [m].
///
/// `wave_lengths`: length of the array. The speed of sound is nominal, 1500 m/s, so that a field does not change with
/// the water.
inline double half_array_m(double wave_lengths, double frequency_hz) {
  return 0.5 * wave_lengths * 1500 / frequency_hz;
}

}  // namespace uwsim
