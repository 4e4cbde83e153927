#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "io/openni/openni_library.h"
#include "surfit/core/image.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/sequence.h"

namespace surfit {

// An image of a device: of depth or of colour, the other is empty.
struct DeviceImage {
  std::uint64_t stamp_us = 0;  // of the device's clock
  int number = 0;              // of its stream's images, in steps of 1
  Image<std::uint16_t> depth;
  Image<Rgb8> color;

  bool is_depth() const { return !depth.empty(); }
};

// A stamp as the number that it is in a list of text, to the last bit.
double SecondsOf(std::uint64_t stamp_us);

// A camera, or a recording of one, that OpenNI2 has opened: its streams of depth and, if it has
// any, of colour. Images are those of the camera itself: devices mirror them if nothing else is
// said, which is undone. All calls throw InputError naming the device.
class OpenNiDevice {
 public:
  OpenNiDevice(std::shared_ptr<const OpenNiLibrary> library, const std::string& uri);
  ~OpenNiDevice();
  OpenNiDevice& operator=(OpenNiDevice&&) = delete;

  // Of a camera, before Start(): size, rate and registration.
  void SetUp(const SequenceOptions& options);
  // Of a recording, before Start(): its images come when they are asked for, over and over.
  void PlayOnRequest(const SequenceOptions& options);
  void Start();

  const OniDeviceInfo& info() const { return info_; }
  bool has_color() const { return color_.stream != nullptr; }
  bool is_registered() const { return is_registered_; }
  int depth_count() const { return CountOf(depth_); }  // of a recording
  int color_count() const { return CountOf(color_); }

  // The next image, or nothing if none came in time.
  std::optional<DeviceImage> Next(int wait_ms);

  // The camera by the fields of view. Where colour is not registered, color_from_depth is the
  // options', for no device tells it.
  RgbdCamera Camera(const SequenceOptions& options) const;

  // Ends automatic exposure and white balance: they stay as they are. False if the device cannot.
  bool LockExposure();

 private:
  struct Stream {
    OniStreamHandle stream = nullptr;
    OniVideoMode mode = {};
    bool is_mirrored = false;
  };

  Stream Create(OniSensorType sensor) const;
  void SetMode(const SequenceOptions& options, OniSensorType sensor, Stream* stream) const;
  int CountOf(const Stream& stream) const;
  PinholeCamera PinholeOf(const Stream& stream) const;
  DeviceImage Take(const OniFrame& frame, const Stream& stream) const;

  template <typename T>
  std::optional<T> Get(const Stream& stream, int property) const {
    T value{};
    int size = sizeof(value);
    const bool has =
        stream.stream != nullptr &&
        library_->oniStreamGetProperty(stream.stream, property, &value, &size) == ONI_STATUS_OK;
    return has ? std::optional<T>(value) : std::nullopt;
  }
  template <typename T>
  bool Set(const Stream& stream, int property, T value) const {
    return library_->oniStreamSetProperty(stream.stream, property, &value, sizeof(value)) ==
           ONI_STATUS_OK;
  }

  std::shared_ptr<const OpenNiLibrary> library_;
  std::string name_;
  OniDeviceHandle device_ = nullptr;
  OniDeviceInfo info_ = {};
  Stream depth_, color_;
  bool is_registered_ = true;
  bool is_played_ = false;  // a recording
};

}  // namespace surfit
