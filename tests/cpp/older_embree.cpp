#include <dlfcn.h>
#include <embree3/rtcore.h>

/// Stands before Embree's own in a test's executable: Embree as it runs on CPUs that know SSE2 and no more.
extern "C" RTCDevice rtcNewDevice(const char*) {
  using NewDevice = RTCDevice (*)(const char*);
  static const auto embrees = reinterpret_cast<NewDevice>(dlsym(RTLD_NEXT, "rtcNewDevice"));
  return embrees("verbose=0,isa=sse2");
}
