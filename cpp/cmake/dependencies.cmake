# The only place where libraries are found. System headers, so that our warnings stay ours.
find_package(Python REQUIRED COMPONENTS Interpreter Development.Module)
find_package(pybind11 CONFIG REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(embree CONFIG REQUIRED)  # 3 or 4: uwsim/rays/embree.h
if(embree_VERSION VERSION_LESS 3 OR embree_VERSION VERSION_GREATER_EQUAL 5)
  message(FATAL_ERROR "Embree ${embree_VERSION} was found; uwsim needs version 3 or 4")
endif()

find_package(PkgConfig REQUIRED)
pkg_check_modules(bullet REQUIRED IMPORTED_TARGET bullet-float64)

# From Debian's archives: octomap's templates must be Debian's own code (see mapping/octomap_engine.cpp).
find_package(octomap 1.9 CONFIG REQUIRED)
add_library(uwsim_octomap INTERFACE)
target_include_directories(uwsim_octomap SYSTEM INTERFACE ${OCTOMAP_INCLUDE_DIRS})
target_link_libraries(uwsim_octomap INTERFACE octomap-static octomath-static)
# dynamicEDT3D's own CMake target does not name its headers, and names OctoMap's shared library: a second OctoMap in the process,
# which would destroy the global variables of the first.
find_package(dynamicEDT3D 1.9 CONFIG REQUIRED)
set_target_properties(dynamicedt3d-static PROPERTIES INTERFACE_LINK_LIBRARIES uwsim_octomap)
add_library(uwsim_distance_transform INTERFACE)
target_include_directories(uwsim_distance_transform SYSTEM INTERFACE ${DYNAMICEDT3D_INCLUDE_DIRS})
target_link_libraries(uwsim_distance_transform INTERFACE dynamicedt3d-static)

# PCL 1.15 would compile our files with OpenMP, too, where threads would sum in any order.
set(CMAKE_DISABLE_FIND_PACKAGE_OpenMP TRUE)
find_package(PCL 1.13 QUIET REQUIRED COMPONENTS common filters)
add_library(uwsim_pcl INTERFACE)
target_include_directories(uwsim_pcl SYSTEM INTERFACE ${PCL_INCLUDE_DIRS})
target_link_libraries(uwsim_pcl INTERFACE pcl_common pcl_filters pcl_sample_consensus pcl_search)

if(UWSIM_TESTS)
  find_package(GTest REQUIRED)
endif()
