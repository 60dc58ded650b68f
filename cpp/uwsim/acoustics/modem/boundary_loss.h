#pragma once

namespace uwsim {

/// Loss of the specular component at a rough sea surface [dB]: with the rms height sigma, wave number k and grazing
/// angle g, the coherent amplitude is exp(-2 (k sigma sin g)^2), the mean of exp(2 i k z sin g) over a Gaussian height
/// z (Eckart 1953, J. Acoust. Soc. Am. 25:566; the Under Sea Modeling Library has the same, reflect_loss_eckart.h).
/// Valid for a surface whose features are long compared with the sound's wavelength. Returns 0 for a flat surface.
double surface_loss_db(double frequency_hz, double sound_speed_m_s, double rms_height_m, double grazing_rad);

/// A bottom as a fluid half-space, relative to the water above it.
struct FluidBottom {
  double density_ratio = 1.9;
  double speed_ratio = 1.1;
  double attenuation_db_wavelength = 0.8;
  bool operator==(const FluidBottom&) const = default;
};

/// Loss of a plane wave at a fluid bottom [dB]: the Rayleigh reflection coefficient with a complex speed of sound in
/// the bottom (Jensen, Kuperman, Porter and Schmidt 2011, "Computational Ocean Acoustics", ch. 1.6, not consulted). The
/// coefficient is that of arlpy 1.9.3 (reflection_coeff) to within 1e-14. At most 60 dB. Shear, layers and roughness
/// are not modelled.
double bottom_loss_db(const FluidBottom& bottom, double grazing_rad);

}  // namespace uwsim
