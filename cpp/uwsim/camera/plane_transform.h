#pragma once

#include <complex>
#include <vector>

namespace uwsim {

/// Replaces values [row][column] by their discrete Fourier transform along both axes, or by the inverse, which divides
/// by their number. Fast for numbers of columns and rows that are products of small primes.
void transform_plane(std::vector<std::complex<float>>& values, int columns, int rows, bool inverse);

}  // namespace uwsim
