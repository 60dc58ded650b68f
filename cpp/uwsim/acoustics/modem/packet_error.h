#pragma once

namespace uwsim {

/// The modulation of a modem's bits.
enum class Modulation { kPsk, kFsk };

/// Bit error probability as a function of gamma, the linear ratio of energy per bit to noise spectral density (Proakis
/// 2001, "Digital Communications", ch. 5 and 14, not consulted). Tests derive the four forms from each other: FSK
/// without fading from a Rice and a Rayleigh amplitude, and fading as the mean over exponentially distributed gamma.
///   coherent BPSK or QPSK: erfc(sqrt(gamma)) / 2;        in Rayleigh fading (1 - sqrt(gamma / (1 + gamma))) / 2
///   non-coherent binary FSK: exp(-gamma / 2) / 2;        in Rayleigh fading 1 / (2 + gamma)
double bit_error(Modulation modulation, bool fading, double gamma);

/// Probability that at least one of `bits` bits is wrong if bit errors are independent: 1 - (1 - Pb)^bits.
double packet_error(double bit_error, double bits);

}  // namespace uwsim
