#include "io/openni/openni_device.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

#include "io/files/text.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

// Supported pixel formats.
bool IsDepth(OniPixelFormat format) {
  return format == ONI_PIXEL_FORMAT_DEPTH_1_MM || format == ONI_PIXEL_FORMAT_DEPTH_100_UM;
}
bool IsColor(OniPixelFormat format) {
  return format == ONI_PIXEL_FORMAT_RGB888 || format == ONI_PIXEL_FORMAT_GRAY8;
}

// Copies a frame with `convert` per pixel and undoes mirroring.
template <typename From, typename To, typename Convert>
Image<To> ImageOf(const OniFrame& frame, bool is_mirrored, const Convert& convert) {
  Image<To> image(frame.width, frame.height);
  for (int v = 0; v < frame.height; ++v) {
    const auto* const row = reinterpret_cast<const From*>(
        static_cast<const char*>(frame.data) + static_cast<std::ptrdiff_t>(v) * frame.stride);
    for (int u = 0; u < frame.width; ++u)
      image(is_mirrored ? frame.width - 1 - u : u, v) = convert(row[u]);
  }
  return image;
}

std::string ToText(const OniVideoMode& mode) {
  return Concat(mode.resolutionX, " x ", mode.resolutionY, " at ", mode.fps, " frames per second");
}

}  // namespace

double SecondsOf(std::uint64_t stamp_us) {
  constexpr std::uint64_t kPerSecond = 1000000;
  char text[40];
  std::snprintf(text, sizeof(text), "%llu.%06llu",
                static_cast<unsigned long long>(stamp_us / kPerSecond),
                static_cast<unsigned long long>(stamp_us % kPerSecond));
  return FiniteNumber(text);
}

OpenNiDevice::OpenNiDevice(std::shared_ptr<const OpenNiLibrary> library, const std::string& uri)
    : library_(std::move(library)), name_(uri) {
  library_->Require(library_->oniDeviceOpen(uri.c_str(), &device_),
                    "OpenNI2 cannot open '" + uri + "'");
  library_->oniDeviceGetInfo(device_, &info_);
  try {
    depth_ = Create(ONI_SENSOR_DEPTH);
    color_ = Create(ONI_SENSOR_COLOR);
    ThrowIf(depth_.stream == nullptr, name_, " has no depth");
  } catch (...) {
    library_->oniDeviceClose(device_);
    throw;
  }
}

OpenNiDevice::~OpenNiDevice() {
  // The player thread must be idle before the streams are destroyed.
  if (is_played_) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  for (const Stream* stream : {&depth_, &color_}) {
    if (stream->stream == nullptr) continue;
    library_->oniStreamStop(stream->stream);
    library_->oniStreamDestroy(stream->stream);
  }
  library_->oniDeviceClose(device_);
}

OpenNiDevice::Stream OpenNiDevice::Create(OniSensorType sensor) const {
  Stream stream;
  if (library_->oniDeviceGetSensorInfo(device_, sensor) == nullptr) return stream;
  library_->Require(
      library_->oniDeviceCreateStream(device_, sensor, &stream.stream),
      name_ + (sensor == ONI_SENSOR_DEPTH ? ": no depth stream" : ": no colour stream"));
  return stream;
}

void OpenNiDevice::SetMode(const SequenceOptions& options, OniSensorType sensor,
                           Stream* stream) const {
  const OniSensorInfo& modes = *library_->oniDeviceGetSensorInfo(device_, sensor);
  std::string all;
  for (int i = 0; i < modes.numSupportedVideoModes; ++i) {
    const OniVideoMode& mode = modes.pSupportedVideoModes[i];
    if (sensor == ONI_SENSOR_DEPTH ? !IsDepth(mode.pixelFormat)
                                   : mode.pixelFormat != ONI_PIXEL_FORMAT_RGB888)
      continue;
    all += (all.empty() ? "" : ", ") + ToText(mode);
    if (mode.resolutionX != options.device_width || mode.resolutionY != options.device_height ||
        mode.fps != options.device_fps)
      continue;
    if (Set(*stream, ONI_STREAM_PROPERTY_VIDEO_MODE, mode)) return;
    throw InputError(name_, " rejects ", ToText(mode), ": ", library_->Reason());
  }
  throw InputError("device_width, device_height and device_fps are ", options.device_width, ", ",
                   options.device_height, " and ", options.device_fps, ", must be a ",
                   sensor == ONI_SENSOR_DEPTH ? "depth" : "colour", " mode of ", name_, ": ", all);
}

void OpenNiDevice::SetUp(const SequenceOptions& options) {
  SetMode(options, ONI_SENSOR_DEPTH, &depth_);
  Set(depth_, ONI_STREAM_PROPERTY_MIRRORING, OniBool{FALSE});
  if (!has_color()) return;
  SetMode(options, ONI_SENSOR_COLOR, &color_);
  Set(color_, ONI_STREAM_PROPERTY_MIRRORING, OniBool{FALSE});
  const auto mode = options.device_registration ? ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR
                                                : ONI_IMAGE_REGISTRATION_OFF;
  is_registered_ = options.device_registration &&
                   library_->oniDeviceIsImageRegistrationModeSupported(device_, mode) != FALSE;
  if (is_registered_ || !options.device_registration) {
    const OniStatus status = library_->oniDeviceSetProperty(
        device_, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION, &mode, sizeof(mode));
    is_registered_ = is_registered_ && status == ONI_STATUS_OK;
  }
  library_->oniDeviceEnableDepthColorSync(device_);  // not supported by all devices
}

void OpenNiDevice::PlayOnRequest(const SequenceOptions& options) {
  is_registered_ = options.device_registration;  // recordings do not store this setting
  is_played_ = true;
  const float on_request = -1;
  // Without repetition, the player of OpenNI2 polls the streams at the end of the file, even while
  // they are destroyed.
  const OniBool repeats = TRUE;
  library_->Require(library_->oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_PLAYBACK_SPEED,
                                                   &on_request, sizeof(on_request)),
                    name_ + " cannot be played image by image");
  library_->oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED, &repeats,
                                 sizeof(repeats));
}

void OpenNiDevice::Start() {
  for (Stream* stream : {&depth_, &color_}) {
    if (stream->stream == nullptr) continue;
    stream->mode =
        Get<OniVideoMode>(*stream, ONI_STREAM_PROPERTY_VIDEO_MODE).value_or(OniVideoMode{});
    stream->is_mirrored =
        Get<OniBool>(*stream, ONI_STREAM_PROPERTY_MIRRORING).value_or(FALSE) != FALSE;
    const OniPixelFormat format = stream->mode.pixelFormat;
    ThrowIf(stream == &depth_ ? !IsDepth(format) : !IsColor(format), name_, ": the ",
            stream == &depth_ ? "depth" : "colour", " stream has the OpenNI2 pixel format ",
            static_cast<int>(format), ", must be ",
            stream == &depth_ ? "depth in units of 1 or 0.1 mm" : "8-bit RGB or grey");
  }
  for (const Stream* stream : {&depth_, &color_}) {
    if (stream->stream == nullptr) continue;
    library_->Require(library_->oniStreamStart(stream->stream), name_ + " does not start");
  }
}

int OpenNiDevice::CountOf(const Stream& stream) const {
  return Get<int>(stream, ONI_STREAM_PROPERTY_NUMBER_OF_FRAMES).value_or(0);
}

std::optional<DeviceImage> OpenNiDevice::Next(int wait_ms) {
  OniStreamHandle streams[] = {depth_.stream, color_.stream};
  int ready = 0;
  if (library_->oniWaitForAnyStream(streams, 2, &ready, wait_ms) != ONI_STATUS_OK)
    return std::nullopt;
  OniFrame* frame = nullptr;
  library_->Require(library_->oniStreamReadFrame(streams[ready], &frame),
                    name_ + ": an image cannot be read");
  const std::shared_ptr<OniFrame> release(frame, library_->oniFrameRelease);
  return Take(*frame, ready == 0 ? depth_ : color_);
}

DeviceImage OpenNiDevice::Take(const OniFrame& frame, const Stream& stream) const {
  const OniPixelFormat format = frame.videoMode.pixelFormat;
  const int pixel_bytes = IsDepth(format) ? 2 : format == ONI_PIXEL_FORMAT_RGB888 ? 3 : 1;
  ThrowIf(
      format != stream.mode.pixelFormat || frame.width < 1 || frame.height < 1 ||
          frame.stride < frame.width * pixel_bytes ||
          static_cast<std::int64_t>(frame.stride) * (frame.height - 1) + frame.width * pixel_bytes >
              frame.dataSize,
      name_, ": image ", frame.frameIndex, " does not match the format of its stream");
  ThrowIf(frame.croppingEnabled != FALSE, name_, ": image ", frame.frameIndex,
          " is cropped, must be the full image");
  DeviceImage image;
  image.stamp_us = frame.timestamp;
  image.number = frame.frameIndex;
  const auto as_is = [](auto pixel) { return pixel; };
  if (IsDepth(format)) {
    image.depth = ImageOf<std::uint16_t, std::uint16_t>(frame, stream.is_mirrored, as_is);
  } else if (format == ONI_PIXEL_FORMAT_RGB888) {
    image.color = ImageOf<Rgb8, Rgb8>(frame, stream.is_mirrored, as_is);
  } else {
    image.color = ImageOf<std::uint8_t, Rgb8>(frame, stream.is_mirrored, [](std::uint8_t grey) {
      return Rgb8{grey, grey, grey};
    });
  }
  return image;
}

PinholeCamera OpenNiDevice::PinholeOf(const Stream& stream) const {
  const auto horizontal_rad = Get<float>(stream, ONI_STREAM_PROPERTY_HORIZONTAL_FOV);
  const auto vertical_rad = Get<float>(stream, ONI_STREAM_PROPERTY_VERTICAL_FOV);
  if (!horizontal_rad || !vertical_rad || !(*horizontal_rad > 0) || !(*vertical_rad > 0)) {
    throw InputError(
        name_,
        " does not report its field of view: set a camera.yaml, a preset as camera, or intrinsics");
  }
  PinholeCamera camera;
  camera.width = stream.mode.resolutionX;
  camera.height = stream.mode.resolutionY;
  camera.fx = camera.width / (2 * std::tan(0.5 * *horizontal_rad));
  camera.fy = camera.height / (2 * std::tan(0.5 * *vertical_rad));
  camera.cx = 0.5 * (camera.width - 1);
  camera.cy = 0.5 * (camera.height - 1);
  return camera;
}

RgbdCamera OpenNiDevice::Camera(const SequenceOptions& options) const {
  RgbdCamera camera = CameraPreset("xtion");  // for noise and readout time
  camera.latency_s = 0;                       // timestamps are from the device clock
  camera.depth_units_per_metre =
      depth_.mode.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_1_MM ? 1000 : 10000;
  if (depth_.mode.fps > 0) camera.frames_per_second = depth_.mode.fps;
  camera.color_is_registered = !has_color() || is_registered_;
  // Registered depth has the intrinsics of the colour camera.
  const bool sees_as_color = has_color() && is_registered_;
  if (!options.intrinsics) camera.depth = PinholeOf(sees_as_color ? color_ : depth_);
  if (camera.color_is_registered) return camera;
  ThrowIf(!options.color_from_depth, name_,
          " does not register depth to colour: set color_from_depth, or a camera.yaml with it");
  if (!options.color_intrinsics) camera.color = PinholeOf(color_);
  return camera;
}

bool OpenNiDevice::LockExposure() {
  if (!has_color()) return false;
  const bool exposure = Set(color_, ONI_STREAM_PROPERTY_AUTO_EXPOSURE, OniBool{FALSE});
  const bool balance = Set(color_, ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE, OniBool{FALSE});
  return exposure && balance;
}

}  // namespace surfit
