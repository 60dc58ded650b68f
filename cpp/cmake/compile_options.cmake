set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# For the same bytes on every build: no fused multiply-add (it changes OctoMap's trees), no -ffast-math (it changes the whole
# process), no -march (it changes Eigen's layout under PCL).
add_compile_options(-ffp-contract=off -fvisibility=hidden -Wall -Wextra)
# Templates fill memory of which little is garbage: the compiler need not look for it in the first gigabyte.
add_compile_options($<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1000000>)
if(UWSIM_WERROR)
  add_compile_options(-Werror)
endif()

# Headers that are parsed once for all files: Eigen alone takes longer than most files of ours. Kernels, which have their
# own flags, do without. -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DCMAKE_UNITY_BUILD=OFF shows an include that a file has
# forgotten.
set(UWSIM_COMMON_HEADERS <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <cmath> <cstdint> <functional> <limits> <memory>
  <optional> <span> <sstream> <stdexcept> <string> <string_view> <utility> <vector>)

# tools/sanitize (GCC, which users' builds are made with) and tools/fuzz (clang); with the library's own checks of indices.
if(UWSIM_SANITIZE)
  set(sanitize -fsanitize=${UWSIM_SANITIZE} -fno-omit-frame-pointer)
  if(UWSIM_SANITIZE STREQUAL address)
    list(APPEND sanitize -fsanitize=undefined)
  endif()
  if(NOT UWSIM_SANITIZE STREQUAL thread)
    list(APPEND sanitize -fno-sanitize-recover=undefined)
  endif()
  if(UWSIM_FUZZERS)
    list(APPEND sanitize -fsanitize=fuzzer-no-link -fno-sanitize=function)
  endif()
  # Under AddressSanitizer Eigen would free with its own function what PCL's library has allocated by malloc.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
  add_compile_options(${sanitize} -O1 -g1 -D_GLIBCXX_ASSERTIONS)
  add_link_options(${sanitize})
endif()
