#include "uwsim/camera/plane_transform.h"

#include <cstddef>
#include <unsupported/Eigen/FFT>

namespace uwsim {

void transform_plane(std::vector<std::complex<float>>& values, int columns, int rows, bool inverse) {
  Eigen::FFT<float> fft;
  std::vector<std::complex<float>> line, changed;
  const auto along_axis = [&](int length, int lines, int step, int between) {
    line.resize(static_cast<std::size_t>(length)), changed.resize(line.size());
    for (int k = 0; k < lines; ++k) {
      std::complex<float>* const first = values.data() + static_cast<std::ptrdiff_t>(k) * between;
      for (int j = 0; j < length; ++j) line[static_cast<std::size_t>(j)] = first[static_cast<std::ptrdiff_t>(j) * step];
      inverse ? fft.inv(changed, line) : fft.fwd(changed, line);
      for (int j = 0; j < length; ++j) {
        first[static_cast<std::ptrdiff_t>(j) * step] = changed[static_cast<std::size_t>(j)];
      }
    }
  };
  along_axis(columns, rows, 1, columns);
  along_axis(rows, columns, columns, 1);
}

}  // namespace uwsim
