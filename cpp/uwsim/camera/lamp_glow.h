#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/camera/kernels/kernels.h"

namespace uwsim {

/// The light of lamps that the water scatters into the camera along rays that nothing ends early, computed for one
/// pixel of each block of 4 x 4. In between, the light is interpolated.
class LampGlow {
 public:
  LampGlow(const camera::View& view, const camera::Kernels& kernels, int threads);

  /// Sets pointers to the values, which are valid during the lifetime of this object.
  void show_in(camera::View& view) const;
  /// Marks the blocks of a row, from column `first` to before `last`, where interpolating is accurate; never at the
  /// picture's edge, where a neighbour is missing. Must precede their rendering.
  void find_smooth(int row, int first, int last);

 private:
  void sample(const camera::View& view, const camera::Kernels& kernels, int row);

  int columns_, rows_;  // of blocks
  std::array<std::vector<float>, 3> bands_;
  std::vector<std::uint8_t> is_smooth_;
};

}  // namespace uwsim
