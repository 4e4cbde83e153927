#include "io/bags/messages.h"

#include "io/cursor.h"
#include "io/files/text.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// Reads the fields of a message in order. ROS 1 packs fields. CDR has a 4-byte header, aligns
// numbers to their size relative to the end of the header, and terminates strings with a zero.
class MessageFields {
 public:
  MessageFields(std::string_view bytes, Serialization serialization, const std::string& name)
      : cursor_(bytes, name), is_cdr_(serialization == Serialization::kCdr) {
    if (!is_cdr_) return;
    const auto representation = cursor_.Take<std::uint32_t>() & 0xFFFF;
    ThrowIf(representation != kLittleEndianCdr, name,
            " has an unsupported CDR representation, must be plain little endian");
    begin_ = cursor_.at();
  }

  template <typename T>
  T Number() {
    if (is_cdr_) cursor_.Bytes((sizeof(T) - (cursor_.at() - begin_) % sizeof(T)) % sizeof(T));
    return cursor_.Take<T>();
  }
  template <typename Array>
  void Numbers(Array* array) {
    for (double& number : *array) number = Number<double>();
  }
  // Reads an array with a leading count.
  std::vector<double> Numbers() {
    const auto count = Number<std::uint32_t>();
    std::vector<double> numbers;
    for (std::uint32_t i = 0; i < count; ++i) numbers.push_back(Number<double>());
    return numbers;
  }
  std::string_view Bytes() { return cursor_.Bytes(Number<std::uint32_t>()); }
  std::string Text() {
    std::string_view bytes = Bytes();
    if (is_cdr_ && !bytes.empty() && bytes.back() == '\0') bytes.remove_suffix(1);
    return std::string(bytes);
  }

  std::int64_t Stamp() {
    if (!is_cdr_) Number<std::uint32_t>();  // sequence number
    constexpr std::int64_t kPerSecond = 1000000000;
    const auto seconds = Number<std::uint32_t>();
    return seconds * kPerSecond + Number<std::uint32_t>();
  }
  MessageHeader Header() {
    const std::int64_t stamp_ns = Stamp();
    return {stamp_ns, Frame()};
  }
  std::string Frame() {
    std::string frame = Text();
    if (!frame.empty() && frame[0] == '/') frame.erase(0, 1);
    return frame;
  }

 private:
  static constexpr std::uint32_t kLittleEndianCdr = 0x0100;  // header bytes 0 and 1

  Cursor cursor_;
  bool is_cdr_;
  std::uint64_t begin_ = 0;
};

}  // namespace

std::int64_t StampOf(const MessageLocation& place, const Topic& topic, const std::string& name) {
  return MessageFields({place.head.data(), place.head.size()}, topic.serialization, name).Stamp();
}

ImageMessage ReadImageMessage(const std::string& bytes, const Topic& topic,
                              const std::string& name) {
  MessageFields fields(bytes, topic.serialization, name);
  ImageMessage image;
  image.header = fields.Header();
  image.is_compressed = topic.type == "sensor_msgs/CompressedImage";
  if (!image.is_compressed) {
    image.height = fields.Number<std::uint32_t>();
    image.width = fields.Number<std::uint32_t>();
  }
  image.encoding = fields.Text();
  if (!image.is_compressed) {
    image.is_big_endian = fields.Number<std::uint8_t>() != 0;
    image.step = fields.Number<std::uint32_t>();
  }
  image.data = fields.Bytes();
  return image;
}

CameraInfo ReadCameraInfo(const std::string& bytes, const Topic& topic, const std::string& name) {
  MessageFields fields(bytes, topic.serialization, name);
  CameraInfo info;
  info.header = fields.Header();
  info.height = fields.Number<std::uint32_t>();
  info.width = fields.Number<std::uint32_t>();
  info.distortion_model = fields.Text();
  info.distortion = fields.Numbers();
  fields.Numbers(&info.intrinsics);
  std::array<double, 9> rectification;
  fields.Numbers(&rectification);
  fields.Numbers(&info.projection);
  info.binning_x = fields.Number<std::uint32_t>();
  info.binning_y = fields.Number<std::uint32_t>();
  info.roi_x = fields.Number<std::uint32_t>();
  info.roi_y = fields.Number<std::uint32_t>();
  info.roi_height = fields.Number<std::uint32_t>();
  info.roi_width = fields.Number<std::uint32_t>();
  return info;
}

float ReadFloat(const std::string& bytes, const Topic& topic, const std::string& name) {
  return MessageFields(bytes, topic.serialization, name).Number<float>();
}

ImuMessage ReadImuMessage(const std::string& bytes, const Topic& topic, const std::string& name) {
  MessageFields fields(bytes, topic.serialization, name);
  ImuMessage message;
  message.header = fields.Header();
  std::array<double, 4 + 9> orientation;
  std::array<double, 9> covariance;
  std::array<double, 3> gyro, accel;
  fields.Numbers(&orientation);
  fields.Numbers(&gyro);
  fields.Numbers(&covariance);
  fields.Numbers(&accel);
  message.gyro_rad_per_s = Eigen::Vector3d::Map(gyro.data());
  message.accel_m_per_s2 = Eigen::Vector3d::Map(accel.data());
  ThrowIf(!message.gyro_rad_per_s.allFinite() || !message.accel_m_per_s2.allFinite(), name,
          " has a measurement that is not a number");
  return message;
}

std::vector<FrameTransform> ReadTransforms(const std::string& bytes, const Topic& topic,
                                           const std::string& name) {
  MessageFields fields(bytes, topic.serialization, name);
  const auto count = fields.Number<std::uint32_t>();
  std::vector<FrameTransform> transforms;
  for (std::uint32_t i = 0; i < count; ++i) {
    FrameTransform transform;
    transform.parent = fields.Header().frame;
    transform.child = fields.Frame();
    std::array<double, 7> numbers;
    fields.Numbers(&numbers);
    try {
      transform.parent_from_child = RigidFromNumbers(numbers.data());
    } catch (const InputError&) {
      continue;  // invalid transforms are common in robot bags, for example before initialisation
    }
    transforms.push_back(std::move(transform));
  }
  return transforms;
}

}  // namespace surfit
