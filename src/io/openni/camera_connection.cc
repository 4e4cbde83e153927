#include "io/openni/camera_connection.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstring>
#include <thread>
#include <vector>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr int kWait_ms = 100;
// Time without images after which the camera is considered disconnected.
constexpr std::chrono::seconds kSilence(5);
// Number of colour images for automatic exposure and white balance before both are locked.
constexpr int kImagesUntilLock = 60;

// Connected devices, without recordings.
std::vector<OniDeviceInfo> Devices(const OpenNiLibrary& library) {
  OniDeviceInfo* devices = nullptr;
  int count = 0;
  library.Require(library.oniGetDeviceList(&devices, &count), "OpenNI2 cannot list devices");
  std::vector<OniDeviceInfo> list(devices, devices + count);
  library.oniReleaseDeviceList(devices);
  return list;
}

// URI of the device that `path` names: a URI, or "any" for the first device.
std::string UriOf(const OpenNiLibrary& library, const std::string& path) {
  const std::vector<OniDeviceInfo> devices = Devices(library);
  std::string all;
  for (const OniDeviceInfo& device : devices) {
    if (path == "any" || path == device.uri) return device.uri;
    all += Concat(all.empty() ? "" : ", ", device.uri, " (", device.vendor, " ", device.name, ")");
  }
  throw InputError("no camera '", path, "': OpenNI2 finds ", all.empty() ? "none" : all);
}

}  // namespace

CameraConnection::CameraConnection(const SequenceOptions& options)
    : options_(options), library_(std::make_shared<const OpenNiLibrary>(options.openni2_library)) {
  Open(UriOf(*library_, options.path));
  OniDeviceCallbacks calls = {};
  calls.deviceDisconnected = HandleDisconnected;
  library_->oniRegisterDeviceCallbacks(&calls, this, &callbacks_);
}

CameraConnection::~CameraConnection() {
  library_->oniUnregisterDeviceCallbacks(callbacks_);
  device_.reset();
}

std::string CameraConnection::name() const { return Concat(info_.vendor, " ", info_.name); }

void CameraConnection::Open(const std::string& uri) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    uri_ = uri;
    is_gone_ = false;
  }
  device_ = std::make_unique<OpenNiDevice>(library_, uri);
  device_->SetUp(options_);
  info_ = device_->info();
  device_->Start();
  silent_since_ = Clock::now();
  images_until_lock_ = options_.device_lock_exposure ? kImagesUntilLock : 0;
}

void CameraConnection::HandleDisconnected(const OniDeviceInfo* device, void* self) {
  CameraConnection& link = *static_cast<CameraConnection*>(self);
  const std::lock_guard<std::mutex> lock(link.mutex_);
  if (link.uri_ == device->uri) link.is_gone_ = true;
}

std::optional<DeviceImage> CameraConnection::Next() {
  if (!device_ && !TryToReopen()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(kWait_ms));
    return std::nullopt;
  }
  std::optional<DeviceImage> image;
  try {
    if (!is_gone_) image = device_->Next(kWait_ms);
  } catch (const InputError&) {
    if (!is_gone_) throw;  // an unplugged device is not an error
  }
  const Clock::time_point now = Clock::now();
  if (!image) {
    if (!is_gone_ && now - silent_since_ < kSilence) return std::nullopt;
    LOG(WARNING) << name() << (is_gone_ ? " is unplugged" : " sends no images")
                 << ": the run pauses until the camera is connected again";
    device_.reset();
    return std::nullopt;
  }
  paused_before_s_ = 0;
  if (comes_after_pause_) {
    comes_after_pause_ = false;
    const auto away = std::chrono::duration_cast<std::chrono::microseconds>(now - last_came_);
    later_us_ = static_cast<std::int64_t>(last_us_) + away.count() -
                static_cast<std::int64_t>(image->stamp_us);
    paused_before_s_ = 1e-6 * static_cast<double>(away.count());
    LOG(WARNING) << name() << " is connected again after " << paused_before_s_ << " s";
  }
  image->stamp_us =
      static_cast<std::uint64_t>(static_cast<std::int64_t>(image->stamp_us) + later_us_);
  last_us_ = std::max(last_us_, image->stamp_us);
  last_came_ = silent_since_ = now;
  LockExposureInTime(*image);
  return image;
}

bool CameraConnection::TryToReopen() {
  const std::string uri = FindReconnected();
  if (uri.empty()) return false;
  try {
    Open(uri);
  } catch (const InputError& error) {  // the device may still be starting
    VLOG(1) << error.what();
    device_.reset();
    return false;
  }
  comes_after_pause_ = true;
  return true;
}

// Finds the device by vendor and product: its URI may change when it is reconnected.
std::string CameraConnection::FindReconnected() const {
  for (const OniDeviceInfo& device : Devices(*library_)) {
    if (device.usbVendorId == info_.usbVendorId && device.usbProductId == info_.usbProductId &&
        std::strcmp(device.name, info_.name) == 0 && std::strcmp(device.vendor, info_.vendor) == 0)
      return device.uri;
  }
  return "";
}

void CameraConnection::LockExposureInTime(const DeviceImage& image) {
  if (images_until_lock_ == 0 || image.is_depth() || --images_until_lock_ > 0) return;
  if (!device_->LockExposure())
    LOG(WARNING) << name() << " cannot lock exposure and white balance, which stay automatic";
}

}  // namespace surfit
