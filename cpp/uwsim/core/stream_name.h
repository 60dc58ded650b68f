#pragma once

#include <string>
#include <string_view>

namespace uwsim {

/// The name of a random stream: its owner and what belongs to it, joined by "/". Every stream is named here, so that no
/// two share their draws:
///
///   <vehicle>/<sensor>              white noise of a sensor
///   <vehicle>/<sensor>/turn_on      its bias at the start; also /bias, /walk and /drop_out
///   <vehicle>/<sonar>               echoes, noise and false detections of a sonar
///   <vehicle>/<camera>/noise        noise of a camera's pixels; <camera>/noise for a camera of the station
///   water/waves, water/gusts/<axis>, optics/ripples
///   link/loss, link/wait            lost packets; waits of random access
///
/// The name keys the draws (RandomStream): renaming a stream changes its samples.
template <typename... Parts>
std::string stream_name(std::string_view owner, const Parts&... parts) {
  std::string name(owner);
  ((name += '/', name += parts), ...);
  return name;
}

}  // namespace uwsim
