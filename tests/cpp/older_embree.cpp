#include <dlfcn.h>

#include "uwsim/rays/embree.h"

/// Replaces Embree's own function in a test's executable, so that Embree runs as on a CPU that supports only SSE2.
extern "C" RTCDevice rtcNewDevice(const char*) {
  using NewDevice = RTCDevice (*)(const char*);
  static const auto original = reinterpret_cast<NewDevice>(dlsym(RTLD_NEXT, "rtcNewDevice"));
  return original("verbose=0,isa=sse2");
}
