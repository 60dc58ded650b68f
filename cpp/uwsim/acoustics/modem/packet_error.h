#pragma once

namespace uwsim {

/// How a modem modulates its bits.
enum class Modulation { kPsk, kFsk };

/// Bit error probability for gamma, the ratio of a bit's energy to the noise's spectral density (not in dB). Proakis
/// 2001, "Digital Communications", ch. 5 and 14; cited from memory.
///   coherent BPSK or QPSK: erfc(sqrt(gamma)) / 2;        in Rayleigh fading (1 - sqrt(gamma / (1 + gamma))) / 2
///   non-coherent binary FSK: exp(-gamma / 2) / 2;        in Rayleigh fading 1 / (2 + gamma)
double bit_error(Modulation modulation, bool fading, double gamma);

/// Probability that at least one of `bits` is wrong, with independent errors: 1 - (1 - Pb)^bits.
double packet_error(double bit_error, double bits);

}  // namespace uwsim
