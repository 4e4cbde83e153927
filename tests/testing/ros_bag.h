#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "testing/recordings.h"

namespace surfit::testing {

// Encoders of ROS 1 bags that are independent of the library.

inline std::string Counted(const std::string& bytes) {
  return LittleEndian(static_cast<std::uint32_t>(bytes.size())) + bytes;
}

inline std::string RosHeader(double stamp_s, const std::string& frame) {
  const auto ns = static_cast<std::int64_t>(stamp_s * 1e9 + 0.5);
  return LittleEndian(std::uint32_t{0}, static_cast<std::uint32_t>(ns / 1000000000),
                      static_cast<std::uint32_t>(ns % 1000000000)) +
         Counted(frame);
}

// sensor_msgs/Image; step 0: rows without padding.
struct RosImage {
  std::string encoding, data;
  std::uint32_t width = 32, height = 24, step = 0;
  std::uint8_t is_big_endian = 0;

  std::string Bytes(double stamp_s, const std::string& frame) const {
    const auto row = step != 0 ? step : static_cast<std::uint32_t>(data.size() / height);
    return RosHeader(stamp_s, frame) + LittleEndian(height, width) + Counted(encoding) +
           LittleEndian(is_big_endian, row) + Counted(data);
  }
};

inline std::string RosCompressedImage(double stamp_s, const std::string& frame,
                                      const std::string& format, const std::string& data) {
  return RosHeader(stamp_s, frame) + Counted(format) + Counted(data);
}

// sensor_msgs/CameraInfo of the small images. P and K differ.
struct RosCameraInfo {
  std::string model = "plumb_bob";
  std::vector<double> distortion = {0, 0, 0, 0, 0};
  std::array<double, 4> k = {31, 30, 15.5, 11.5}, p = {29, 28, 15, 11};  // fx fy cx cy
  std::uint32_t width = 32, height = 24;
  std::array<std::uint32_t, 2> binning = {0, 0};
  std::array<std::uint32_t, 4> roi = {0, 0, 0, 0};  // x, y, height, width

  std::string Bytes(double stamp_s, const std::string& frame) const {
    std::string d = LittleEndian(static_cast<std::uint32_t>(distortion.size()));
    for (const double number : distortion) d += LittleEndian(number);
    const double z = 0, i = 1;
    return RosHeader(stamp_s, frame) + LittleEndian(height, width) + Counted(model) + d +
           LittleEndian(k[0], z, k[2], z, k[1], k[3], z, z, i) +
           LittleEndian(i, z, z, z, i, z, z, z, i) +
           LittleEndian(p[0], z, p[2], z, z, p[1], p[3], z, z, z, i, z) +
           LittleEndian(binning[0], binning[1], roi[0], roi[1], roi[2], roi[3], std::uint8_t{0});
  }
};

// tf2_msgs/TFMessage with one transform.
inline std::string RosTransform(const std::string& parent, const std::string& child,
                                const Rigid3d& parent_from_child) {
  const auto& [q, t] = parent_from_child;
  return LittleEndian(std::uint32_t{1}) + RosHeader(1, parent) + Counted(child) +
         LittleEndian(t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

// Bag of format 2.0 with one message per chunk.
class RosBagEncoder {
 public:
  void Add(const std::string& topic, const std::string& type, double stamp_s,
           const std::string& message) {
    std::uint32_t connection = 0;
    while (connection < topics_.size() && topics_[connection] != topic) ++connection;
    std::string chunk;
    if (connection == topics_.size()) {
      topics_.push_back(topic);
      chunk += Record({"op=\x07", "conn=" + LittleEndian(connection), "topic=" + topic},
                      Counted("topic=" + topic) + Counted("type=" + type));
    }
    const auto s = static_cast<std::uint32_t>(stamp_s);
    const auto ns = static_cast<std::uint32_t>((stamp_s - s) * 1e9);
    chunk += Record({"op=\x02", "conn=" + LittleEndian(connection), "time=" + LittleEndian(s, ns)},
                    message);
    AddChunk("none", static_cast<std::uint32_t>(chunk.size()), chunk);
  }
  void AddChunk(const std::string& compression, std::uint32_t claimed, const std::string& bytes) {
    chunks_ +=
        Record({"op=\x05", "compression=" + compression, "size=" + LittleEndian(claimed)}, bytes);
  }
  std::string File(const std::string& encryptor = "") const {
    std::vector<std::string> fields = {"op=\x03"};
    if (!encryptor.empty()) fields.push_back("encryptor=" + encryptor);
    return "#ROSBAG V2.0\n" + Record(fields, "") + chunks_;
  }

 private:
  static std::string Record(const std::vector<std::string>& fields, const std::string& data) {
    std::string header;
    for (const std::string& field : fields) header += Counted(field);
    return Counted(header) + Counted(data);
  }

  std::vector<std::string> topics_;
  std::string chunks_;
};

}  // namespace surfit::testing
