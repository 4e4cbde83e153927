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

// A camera that may be unplugged and plugged in again. Its stamps ascend all the while: after a
// pause they go on by the time that has passed. For one thread.
class CameraLink {
 public:
  // Throws InputError naming the device if it is not there, or cannot be set up.
  explicit CameraLink(const SequenceOptions& options);
  ~CameraLink();
  CameraLink& operator=(CameraLink&&) = delete;

  const OpenNiDevice& device() const { return *device_; }
  std::string name() const;

  // The next image; nothing if none came within a tenth of a second, as while the camera is away.
  std::optional<DeviceImage> Next();
  // How long it was away before the image that Next() gave, 0 if it was not.
  double paused_before_s() const { return paused_before_s_; }

 private:
  using Clock = std::chrono::steady_clock;

  void Open(const std::string& uri);
  // Whether it is there again.
  bool TryToReopen();
  std::string FindAgain() const;
  void LockExposureInTime(const DeviceImage& image);

  static void HandleDisconnected(const OniDeviceInfo* device, void* self);

  SequenceOptions options_;
  std::shared_ptr<const OpenNiLibrary> library_;
  OniCallbackHandle callbacks_ = nullptr;
  std::unique_ptr<OpenNiDevice> device_;  // null while it is away
  OniDeviceInfo info_ = {};
  std::mutex mutex_;  // of uri_, which the device's thread reads
  std::string uri_;
  std::atomic<bool> is_gone_{false};
  Clock::time_point last_came_;     // the last image
  Clock::time_point silent_since_;  // then, or since it was opened
  std::uint64_t last_us_ = 0;       // stamp of the last image that was given
  std::int64_t later_us_ = 0;       // what is added to the device's stamps
  bool comes_after_pause_ = false;  // the next image does
  double paused_before_s_ = 0;
  int images_until_lock_ = 0;
};

}  // namespace surfit
