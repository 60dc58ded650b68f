#pragma once

// The only file that includes Embree: version 4 if the system has it, as Debian 13 does, else version 3. What differs
// between the two is here, under the names of version 4.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
using RTCRayQueryContext = RTCIntersectContext;
#endif

namespace uwsim::embree {

#if RTC_VERSION_MAJOR >= 4

inline RTCRayQueryContext new_context() {
  RTCRayQueryContext context;
  rtcInitRayQueryContext(&context);
  return context;
}

/// The arguments of a cast. Coherent rays have similar origins and directions.
template <typename Arguments>
Arguments with(void (*init)(Arguments*), RTCRayQueryContext& context, bool coherent) {
  Arguments arguments;
  init(&arguments);
  arguments.context = &context;
  if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  return arguments;
}

inline void intersect(RTCScene scene, RTCRayQueryContext& context, RTCRayHit& ray) {
  RTCIntersectArguments arguments = with(&rtcInitIntersectArguments, context, false);
  rtcIntersect1(scene, &ray, &arguments);
}

inline void intersect(const int* active, RTCScene scene, RTCRayQueryContext& context, bool coherent,
                      RTCRayHit16& packet) {
  RTCIntersectArguments arguments = with(&rtcInitIntersectArguments, context, coherent);
  rtcIntersect16(active, scene, &packet, &arguments);
}

inline void occluded(const int* active, RTCScene scene, RTCRayQueryContext& context, bool coherent, RTCRay16& packet) {
  RTCOccludedArguments arguments = with(&rtcInitOccludedArguments, context, coherent);
  rtcOccluded16(active, scene, &packet, &arguments);
}

#else

inline RTCRayQueryContext new_context() {
  RTCRayQueryContext context;
  rtcInitIntersectContext(&context);
  return context;
}

inline RTCRayQueryContext* with(RTCRayQueryContext& context, bool coherent) {
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return &context;
}

inline void intersect(RTCScene scene, RTCRayQueryContext& context, RTCRayHit& ray) {
  rtcIntersect1(scene, with(context, false), &ray);
}

inline void intersect(const int* active, RTCScene scene, RTCRayQueryContext& context, bool coherent,
                      RTCRayHit16& packet) {
  rtcIntersect16(active, scene, with(context, coherent), &packet);
}

inline void occluded(const int* active, RTCScene scene, RTCRayQueryContext& context, bool coherent, RTCRay16& packet) {
  rtcOccluded16(active, scene, with(context, coherent), &packet);
}

#endif

}  // namespace uwsim::embree
