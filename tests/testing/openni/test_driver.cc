// OpenNI2 driver for tests with one virtual camera, see CameraScript.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

// The Debian package lacks the header that defines these macros of the driver headers.
#define XN_NEW(Type, ...) new Type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>

#include "testing/openni/camera_script.h"

namespace surfit::testing {
namespace {

struct StampedImage {
  std::uint64_t stamp_us = 0;
  std::vector<char> bytes;
};

// Contents of the script file.
class Film {
 public:
  bool Read() {
    const char* const path = std::getenv("SURFIT_TEST_CAMERA");
    if (path == nullptr) return false;
    log_ = std::string(path) + ".log";
    file_.open(path, std::ios::binary);
    file_.read(reinterpret_cast<char*>(&script_), sizeof(script_));
    begin_ = file_.tellg();
    return static_cast<bool>(file_);
  }

  const CameraScript& script() const { return script_; }

  // Reads depth and colour of a frame.
  void ReadFrame(int index, StampedImage* depth, StampedImage* color) {
    const std::streamoff pixels = static_cast<std::streamoff>(script_.width) * script_.height;
    const std::streamoff size = 16 + pixels * (script_.has_color != 0 ? 5 : 2);
    file_.seekg(begin_ + index * size);
    for (StampedImage* image : {depth, color})
      file_.read(reinterpret_cast<char*>(&image->stamp_us), sizeof(image->stamp_us));
    depth->bytes.resize(2 * pixels);
    color->bytes.resize(script_.has_color != 0 ? 3 * pixels : 0);
    for (StampedImage* image : {depth, color})
      file_.read(image->bytes.data(), static_cast<std::streamsize>(image->bytes.size()));
  }

  void Log(const std::string& line) const { std::ofstream(log_, std::ios::app) << line << "\n"; }

 private:
  CameraScript script_;
  std::ifstream file_;
  std::streamoff begin_ = 0;
  std::string log_;
};

template <typename T>
OniStatus Give(const T& value, void* data, int* size) {
  if (*size < static_cast<int>(sizeof(T))) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof(T));
  *size = sizeof(T);
  return ONI_STATUS_OK;
}

class TestStream : public oni::driver::StreamBase {
 public:
  TestStream(const Film& film, OniSensorType sensor) : film_(film), sensor_(sensor) {}

  OniVideoMode mode() const {
    const bool is_depth = sensor_ == ONI_SENSOR_DEPTH;
    return {is_depth ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888, film_.script().width,
            film_.script().height, 30};
  }

  OniBool isPropertySupported(int id) override {
    char data[64];
    int size = sizeof(data);
    return getProperty(id, data, &size) == ONI_STATUS_OK ? TRUE : FALSE;
  }

  OniStatus getProperty(int id, void* data, int* size) override {
    switch (id) {
      case ONI_STREAM_PROPERTY_VIDEO_MODE:
        return Give(mode(), data, size);
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        return Give(film_.script().horizontal_fov_rad, data, size);
      case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return Give(film_.script().vertical_fov_rad, data, size);
      case ONI_STREAM_PROPERTY_MAX_VALUE:
        return Give(65534, data, size);
      // Playback of recordings requires these properties.
      case ONI_STREAM_PROPERTY_STRIDE:
        return Give(getRequiredFrameSize() / mode().resolutionY, data, size);
      case ONI_STREAM_PROPERTY_CROPPING:
        return Give(OniCropping{}, data, size);
      case ONI_STREAM_PROPERTY_MIRRORING:
        return Give(mirrors_, data, size);
      case ONI_STREAM_PROPERTY_AUTO_EXPOSURE:
      case ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE:
        return sensor_ == ONI_SENSOR_COLOR ? Give(TRUE, data, size) : ONI_STATUS_NOT_SUPPORTED;
      default:
        return ONI_STATUS_NOT_SUPPORTED;
    }
  }

  OniStatus setProperty(int id, const void* data, int size) override {
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) {
      const auto& asked = *static_cast<const OniVideoMode*>(data);
      film_.Log("mode " + std::to_string(asked.resolutionX) + "x" +
                std::to_string(asked.resolutionY));
      const bool has = asked.resolutionX == mode().resolutionX &&
                       asked.resolutionY == mode().resolutionY &&
                       asked.pixelFormat == mode().pixelFormat;
      return has ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
    }
    int value = 0;
    std::memcpy(&value, data, std::min<std::size_t>(sizeof(value), size));
    if (id == ONI_STREAM_PROPERTY_MIRRORING) mirrors_ = value;
    film_.Log("stream property " + std::to_string(id) + " = " + std::to_string(value));
    return ONI_STATUS_OK;
  }

  int getRequiredFrameSize() override {
    return mode().resolutionX * mode().resolutionY * (sensor_ == ONI_SENSOR_DEPTH ? 2 : 3);
  }

  OniStatus start() override {
    is_started_ = true;
    return ONI_STATUS_OK;
  }
  void stop() override { is_started_ = false; }
  bool is_started() const { return is_started_; }

  void Send(const StampedImage& image) {
    if (!is_started_) return;
    OniFrame* const frame = getServices().acquireFrame();
    if (frame == nullptr) return;
    Copy(image.bytes, static_cast<char*>(frame->data));
    frame->dataSize = static_cast<int>(image.bytes.size());
    frame->sensorType = sensor_;
    frame->timestamp = image.stamp_us;
    frame->frameIndex = ++count_;
    frame->videoMode = mode();
    frame->width = frame->videoMode.resolutionX;
    frame->height = frame->videoMode.resolutionY;
    frame->croppingEnabled = FALSE;
    frame->cropOriginX = frame->cropOriginY = 0;
    frame->stride = frame->dataSize / frame->height;
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }

 private:
  void Copy(const std::vector<char>& bytes, char* data) const {
    const std::size_t pixel_bytes = sensor_ == ONI_SENSOR_DEPTH ? 2 : 3;
    const std::size_t width = mode().resolutionX, pixels = bytes.size() / pixel_bytes;
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::size_t u = i % width, from = mirrors_ != FALSE ? i - u + width - 1 - u : i;
      std::memcpy(data + i * pixel_bytes, bytes.data() + from * pixel_bytes, pixel_bytes);
    }
  }

  const Film& film_;
  const OniSensorType sensor_;
  std::atomic<bool> is_started_{false};
  OniBool mirrors_ = TRUE;  // default of cameras
  int count_ = 0;
};

class TestDevice : public oni::driver::DeviceBase {
 public:
  explicit TestDevice(const Film& film) : film_(film) {
    for (const OniSensorType sensor : {ONI_SENSOR_DEPTH, ONI_SENSOR_COLOR}) {
      if (sensor == ONI_SENSOR_COLOR && film.script().has_color == 0) continue;
      modes_[sensor_count_] = TestStream(film, sensor).mode();
      sensors_[sensor_count_] = {sensor, 1, &modes_[sensor_count_]};
      ++sensor_count_;
    }
  }

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = sensors_;
    *count = sensor_count_;
    return ONI_STATUS_OK;
  }

  oni::driver::StreamBase* createStream(OniSensorType sensor) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    streams_.push_back(new TestStream(film_, sensor));
    return streams_.back();
  }

  void destroyStream(oni::driver::StreamBase* stream) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    streams_.erase(std::find(streams_.begin(), streams_.end(), stream));
    delete stream;
  }

  OniBool isPropertySupported(int id) override {
    return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION && film_.script().can_register != 0;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    return isPropertySupported(id) ? Give(registration_, data, size) : ONI_STATUS_NOT_SUPPORTED;
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (!isPropertySupported(id)) return ONI_STATUS_NOT_SUPPORTED;
    std::memcpy(&registration_, data, std::min<std::size_t>(sizeof(registration_), size));
    film_.Log("registration " + std::to_string(registration_));
    return ONI_STATUS_OK;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_OFF || film_.script().can_register != 0;
  }

  // Sends images to all streams. Returns false until all streams are started.
  bool Send(const StampedImage& depth, const StampedImage& color) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (streams_.empty()) return false;
    for (TestStream* stream : streams_) {
      if (!stream->is_started()) return false;
    }
    for (TestStream* stream : streams_)
      stream->Send(stream->mode().pixelFormat == ONI_PIXEL_FORMAT_RGB888 ? color : depth);
    return true;
  }

 private:
  const Film& film_;
  OniVideoMode modes_[2];
  OniSensorInfo sensors_[2];
  int sensor_count_ = 0;
  std::mutex mutex_;
  std::vector<TestStream*> streams_;
  int registration_ = ONI_IMAGE_REGISTRATION_OFF;
};

class TestDriver : public oni::driver::DriverBase {
 public:
  explicit TestDriver(OniDriverServices* services) : DriverBase(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    if (!film_.Read()) return ONI_STATUS_OK;  // no camera
    PlugIn();
    thread_ = std::thread([this] { Play(); });
    return ONI_STATUS_OK;
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char* /*mode*/) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (std::string(uri) != info_.uri || is_away_) return nullptr;
    device_ = new TestDevice(film_);
    return device_;
  }

  void deviceClose(oni::driver::DeviceBase* device) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (device == device_) device_ = nullptr;
    delete device;
  }

  OniStatus tryDevice(const char* uri) override {
    return std::string(uri) == info_.uri ? ONI_STATUS_OK : ONI_STATUS_ERROR;
  }

  void shutdown() override {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void PlugIn() {
    std::snprintf(info_.uri, sizeof(info_.uri), "test://%d", ++plugged_in_);
    std::snprintf(info_.vendor, sizeof(info_.vendor), "Surfit");
    std::snprintf(info_.name, sizeof(info_.name), "Virtual");
    info_.usbVendorId = 1;
    info_.usbProductId = 2;
    is_away_ = false;
    deviceConnected(&info_);
  }

  // Waits until the streams are started, and sends the frame.
  void Send(const StampedImage& depth, const StampedImage& color) {
    const std::chrono::microseconds period(film_.script().period_us);
    while (!ends_) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (device_ != nullptr && device_->Send(depth, color)) break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(period);
  }

  void Unplug() {
    is_away_ = true;
    deviceDisconnected(&info_);
    if (film_.script().away_ms < 0) return;
    const auto back =
        std::chrono::steady_clock::now() + std::chrono::milliseconds(film_.script().away_ms);
    while (!ends_ && std::chrono::steady_clock::now() < back)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (!ends_) PlugIn();
  }

  void Play() {
    StampedImage depth, color;
    std::uint64_t zero_us = 0;
    for (int i = 0; i < film_.script().frames && !ends_; ++i) {
      film_.ReadFrame(i, &depth, &color);
      if (i == film_.script().unplugged_at) {
        Unplug();
        if (is_away_) return;
        zero_us = std::min(depth.stamp_us, color.stamp_us);
      }
      depth.stamp_us -= zero_us;
      color.stamp_us -= zero_us;
      Send(depth, color);
    }
  }

  Film film_;
  OniDeviceInfo info_ = {};
  std::mutex mutex_;
  TestDevice* device_ = nullptr;
  std::thread thread_;
  std::atomic<bool> ends_{false}, is_away_{false};
  int plugged_in_ = 0;
};

}  // namespace
}  // namespace surfit::testing

ONI_EXPORT_DRIVER(surfit::testing::TestDriver)
