#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "io/openni/openni_device.h"
#include "surfit/io/sequence.h"

namespace surfit {

// Camera connection that survives unplugging. After a pause, timestamps continue with the elapsed
// time added, and image numbers start again. Not thread-safe.
class CameraConnection {
 public:
  // Opens and starts the device `options.path`: a URI, or "any" for the first device. Throws
  // InputError with its name if it is not connected or cannot be configured.
  explicit CameraConnection(const SequenceOptions& options);
  ~CameraConnection();
  CameraConnection& operator=(CameraConnection&&) = delete;

  // Requires a connected device: after construction, or after Next() has returned an image. Valid
  // until the next call of Next().
  const OpenNiDevice& device() const { return *device_; }
  // Vendor and product.
  std::string name() const;

  // Next image; std::nullopt without an image within 0.1 s or while the camera is disconnected. A
  // camera without images for 5 s counts as disconnected. Throws InputError for an unreadable image
  // of a connected camera, and if OpenNI2 cannot list the devices.
  std::optional<DeviceImage> Next();
  // Duration of a disconnection before the last image of Next(), s; 0: none.
  double paused_before_s() const { return paused_before_s_; }

 private:
  using Clock = std::chrono::steady_clock;

  void Open(const std::string& uri);
  bool TryToReopen();
  std::string FindReconnected() const;  // URI of the reconnected device; empty: not found
  void LockExposureInTime(const DeviceImage& image);

  static void HandleDisconnected(const OniDeviceInfo* device, void* self);

  SequenceOptions options_;
  std::shared_ptr<const OpenNiLibrary> library_;
  OniCallbackHandle callbacks_ = nullptr;
  std::unique_ptr<OpenNiDevice> device_;  // null while the device is disconnected
  OniDeviceInfo info_ = {};
  std::mutex mutex_;  // protects uri_, which the callback thread of OpenNI2 reads
  std::string uri_;
  std::atomic<bool> is_gone_{false};
  Clock::time_point last_came_;     // arrival of the last image
  Clock::time_point silent_since_;  // arrival of the last image, or time of opening
  std::uint64_t last_us_ = 0;       // largest timestamp of the images so far
  std::int64_t later_us_ = 0;       // offset that is added to timestamps of the device
  bool comes_after_pause_ = false;  // the next image follows a disconnection
  double paused_before_s_ = 0;
  int images_until_lock_ = 0;
};

}  // namespace surfit
