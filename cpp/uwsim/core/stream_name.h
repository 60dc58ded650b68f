#pragma once

#include <string>
#include <string_view>

namespace uwsim {

/// The name of a random stream: its owner and its purpose, joined by "/". All streams are listed here, so that no two
/// share their draws:
///
///   <vehicle>/<sensor>              white noise of a sensor
///   <vehicle>/<sensor>/turn_on      its turn-on bias; also /bias, /walk and /drop_out
///   <vehicle>/<sonar>               echoes, noise and false detections of a sonar
///   <vehicle>/<camera>/noise        noise of a camera's pixels; <camera>/noise for a camera of the station
///   water/waves, water/gusts/<axis>, optics/ripples
///   link/loss, link/wait            lost packets; waits of random access
///
/// The name keys the draws (RandomStream), so renaming a stream changes its samples.
template <typename... Parts>
std::string stream_name(std::string_view owner, const Parts&... parts) {
  std::string name(owner);
  ((name += '/', name += parts), ...);
  return name;
}

}  // namespace uwsim
