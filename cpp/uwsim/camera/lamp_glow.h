#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/picture_request.h"
#include "uwsim/camera/render_cost.h"

namespace uwsim {

/// The light of lamps that the water scatters into the camera along rays that nothing ends early, computed for one
/// pixel of each block of 4 x 4. Most of a picture under water needs no more: in between, the light is interpolated.
class LampGlow {
 public:
  LampGlow(const camera::View& view, const camera::Kernels& kernels, const PictureRequest& request,
           std::vector<RenderCost>& costs);

  /// Pointers to the values, which are valid during the lifetime of this object.
  camera::LampGlow view() const { return {{bands_[0].data(), bands_[1].data(), bands_[2].data()}, is_smooth_.data()}; }

 private:
  void sample(const camera::View& view, const camera::Kernels& kernels, int row);
  void find_smooth(int row);

  int columns_, rows_;  // of blocks
  std::array<std::vector<float>, 3> bands_;
  std::vector<std::uint8_t> is_smooth_;
};

}  // namespace uwsim
