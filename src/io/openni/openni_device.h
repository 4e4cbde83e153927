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

// Depth image or colour image of a device; the other image is empty.
struct DeviceImage {
  std::uint64_t stamp_us = 0;  // timestamp of the device clock
  int number = 0;              // number within the stream; starts again in each loop of a recording
  Image<std::uint16_t> depth;  // counts of the device, 1 or 0.1 mm; 0: missing
  Image<Rgb8> color;

  bool is_depth() const { return !depth.empty(); }
};

// Timestamp in s, bitwise identical to the same timestamp in a text file.
double SecondsOf(std::uint64_t stamp_us);

// Camera or recording opened with OpenNI2, with a depth stream and an optional colour stream.
// Mirroring of images is undone. Failures throw InputError with the name of the device, unless
// stated otherwise. Mirroring, registration and colour synchronisation are skipped if the device
// lacks them. Not thread-safe. Call SetUp() or PlayOnRequest() first, then Start(), then Next() and
// Camera().
class OpenNiDevice {
 public:
  OpenNiDevice(std::shared_ptr<const OpenNiLibrary> library, const std::string& uri);
  ~OpenNiDevice();
  OpenNiDevice& operator=(OpenNiDevice&&) = delete;

  // Configures image size, frame rate and registration of a camera. Call before Start().
  void SetUp(const SequenceOptions& options);
  // Configures a recording: images are played on request, in an endless loop. Call before Start().
  void PlayOnRequest(const SequenceOptions& options);
  // Call once.
  void Start();

  const OniDeviceInfo& info() const { return info_; }
  bool has_color() const { return color_.stream != nullptr; }
  // The device registers depth to colour. For a recording: SequenceOptions::device_registration.
  bool is_registered() const { return is_registered_; }
  // Number of images of a recording. 0 for a camera.
  int depth_count() const { return CountOf(depth_); }
  int color_count() const { return CountOf(color_); }

  // Waits for the next image. Returns std::nullopt after `wait_ms`, or at once if OpenNI2 cannot
  // wait, for example without a device. Throws InputError for a cropped or unreadable image.
  std::optional<DeviceImage> Next(int wait_ms);

  // Camera with intrinsics from the fields of view, unless the options set them, and noise and
  // readout of the preset xtion. Call after Start(). Values of the options are not applied. Throws
  // InputError without a field of view. Devices do not report color_from_depth: if colour is not
  // registered, the options must set it, or it throws InputError.
  RgbdCamera Camera(const SequenceOptions& options) const;

  // Disables automatic exposure and white balance; the current values stay. Returns false if the
  // device does not support it.
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
  bool is_played_ = false;  // true for a recording
};

}  // namespace surfit
