#include <immintrin.h>

#include "uwsim/mapping/bricks/kernels/lanes_avx512.h"
// After the lanes:
#include "uwsim/mapping/bricks/kernels/slab_walk.h"

namespace uwsim::bricks {

const SlabKernels kAvx512SlabKernels{set_up_slabs, walk_slabs};

}  // namespace uwsim::bricks
