#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include <fastcdr/Cdr.h>

#include "raw_type.h"

// A few of ROS's messages by Fast CDR, the codec of rmw_fastrtps: what it reads out of the bytes that it is sent.

inline std::string in_quotes(const std::string& text) {
  std::string quoted(1, '"');
  quoted.append(text).push_back('"');
  return quoted;
}

inline std::string header_json(eprosima::fastcdr::Cdr& cdr) {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame_id;
  cdr >> sec >> nanosec >> frame_id;
  return "\"stamp_ns\":" + std::to_string(sec * 1'000'000'000LL + nanosec) + ",\"frame_id\":" + in_quotes(frame_id);
}

/// Returns the fields of a message as JSON, of a type that is not known here nothing.
inline std::string decoded(const std::string& type, const Payload& payload) {
  eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(const_cast<std::uint8_t*>(payload.data())),
                                       payload.size());
  eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR);
  cdr.read_encapsulation();
  char text[256];
  if (type == "sensor_msgs::msg::dds_::LaserScan_") {
    std::string json = header_json(cdr);
    float settings[7];
    std::vector<float> ranges;
    for (float& setting : settings) cdr >> setting;
    cdr >> ranges;
    double sum = 0.0;
    for (float range : ranges) sum += range < 1e9F ? range : 0.0F;
    std::snprintf(text, sizeof text,
                  ",\"angle_min\":%.9g,\"angle_max\":%.9g,\"range_max\":%.9g,\"count\":%zu,\"sum\":%.17g", settings[0],
                  settings[1], settings[6], ranges.size(), sum);
    return json + text;
  }
  if (type == "sensor_msgs::msg::dds_::PointCloud2_") {
    std::string json = header_json(cdr);
    std::uint32_t height = 0, width = 0, fields = 0;
    cdr >> height >> width >> fields;
    std::string names;
    for (std::uint32_t k = 0; k < fields; ++k) {
      std::string name;
      std::uint32_t offset = 0, count = 0;
      std::uint8_t datatype = 0;
      cdr >> name >> offset >> datatype >> count;
      names += name;
    }
    bool is_bigendian = false;
    std::uint32_t point_step = 0, row_step = 0;
    std::vector<std::uint8_t> data;
    cdr >> is_bigendian >> point_step >> row_step >> data;
    std::snprintf(text, sizeof text, ",\"width\":%u,\"point_step\":%u,\"bytes\":%zu,\"fields\":", width, point_step,
                  data.size());
    return json + text + in_quotes(names);
  }
  if (type == "tf2_msgs::msg::dds_::TFMessage_") {
    std::uint32_t count = 0;
    cdr >> count;
    std::string json = "\"children\":[";
    for (std::uint32_t k = 0; k < count; ++k) {
      header_json(cdr);
      std::string child;
      double numbers[7];
      cdr >> child;
      for (double& number : numbers) cdr >> number;
      if (k) json.push_back(',');
      json.append(in_quotes(child));
    }
    return json + "]";
  }
  return "";
}

/// Returns a geometry_msgs/Twist that moves ahead at x [m/s].
inline Payload twist(double x) {
  Payload payload(4 + 6 * sizeof(double));
  eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload.data()), payload.size());
  eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  cdr << x << 0.0 << 0.0 << 0.0 << 0.0 << 0.0;
  return payload;
}
