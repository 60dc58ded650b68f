#pragma once

#include <string>
#include <string_view>

namespace uwsim {

/// The name of a random stream: its owner and what belongs to it, joined by "/". Every stream is named here, so that no
/// two share their draws:
///
///   <vehicle>/<sensor>              white noise of a sensor
///   <vehicle>/<sensor>/turn_on      its bias at the start; likewise /bias, /walk and /drop_out
///   <vehicle>/<sonar>               echoes, noise and false detections of a sonar
///   <vehicle>/<camera>/noise        noise of a camera's pixels; <camera>/noise for one of the station's
///   water/waves, water/gusts/<axis>, optics/ripples
///   link/loss, link/wait            packets that are lost; waits of the random access
///
/// A name keys its draws (RandomStream): a stream that is renamed gives other samples.
template <typename... Parts>
std::string stream_name(std::string_view owner, const Parts&... parts) {
  std::string name(owner);
  ((name += '/', name += parts), ...);
  return name;
}

}  // namespace uwsim
