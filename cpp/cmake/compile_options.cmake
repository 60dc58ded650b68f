set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# The same bytes on every build: no fused multiply-add (it changes OctoMap's trees), no -ffast-math (it changes the whole
# process), no -march (it changes Eigen's layout under PCL).
add_compile_options(-ffp-contract=off -fvisibility=hidden -Wall -Wextra)
if(UWSIM_WERROR)
  add_compile_options(-Werror)
endif()
