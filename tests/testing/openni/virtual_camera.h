#pragma once

#include <OniCAPI.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "surfit/core/image.h"
#include "testing/openni/camera_script.h"
#include "testing/temp_folder.h"

namespace surfit::testing {

// One frame of the virtual camera.
struct FilmFrame {
  std::uint64_t depth_us = 0, color_us = 0;
  Image<std::uint16_t> depth;
  Image<Rgb8> color;
};

// The virtual camera of test_driver.cc, for this process and its children. It is connected during
// the lifetime of this object. Use library() as openni2_library.
class VirtualCamera {
 public:
  static std::string library() { return SURFIT_TOOLS_DIR "/../tests/openni/libOpenNI2.so.0"; }

  // The film determines image sizes and number of frames, and must not be empty. The other values
  // are those of `script`.
  VirtualCamera(CameraScript script, const std::vector<FilmFrame>& film) {
    script.width = film[0].depth.width();
    script.height = film[0].depth.height();
    script.frames = static_cast<int>(film.size());
    std::ofstream file(path(), std::ios::binary);
    const auto write = [&](const auto* data, std::size_t count) {
      file.write(reinterpret_cast<const char*>(data),
                 static_cast<std::streamsize>(count * sizeof(*data)));
    };
    write(&script, 1);
    for (const FilmFrame& frame : film) {
      write(&frame.depth_us, 1);
      write(&frame.color_us, 1);
      write(frame.depth.data(), frame.depth.size());
      if (script.has_color != 0) write(frame.color.data(), frame.color.size());
    }
    setenv("SURFIT_TEST_CAMERA", path().c_str(), /*overwrite=*/1);
  }
  ~VirtualCamera() { unsetenv("SURFIT_TEST_CAMERA"); }
  VirtualCamera(const VirtualCamera&) = delete;
  VirtualCamera& operator=(const VirtualCamera&) = delete;

  // Log of changed settings.
  std::string Log() const {
    std::ifstream log(path() + ".log");
    return {std::istreambuf_iterator<char>(log), std::istreambuf_iterator<char>()};
  }

 private:
  std::string path() const { return folder_ / "film"; }

  TempFolder folder_;
};

// Frame of a film at 30 Hz with timestamps from 0. The recorder of OpenNI2 drops the first frame,
// and sets the timestamp of the second frame to 0.
inline FilmFrame FilmFrameOf(int number, Image<std::uint16_t> depth, Image<Rgb8> color) {
  constexpr std::uint64_t kPeriod_us = 33333;
  const std::uint64_t stamp_us = kPeriod_us * number;
  return {stamp_us, stamp_us, std::move(depth), std::move(color)};
}

// Records all frames of the existing VirtualCamera with the recorder of OpenNI2.
inline void RecordOni(const std::string& path) {
  void* const library = dlopen(VirtualCamera::library().c_str(), RTLD_NOW | RTLD_NODELETE);
  ASSERT_NE(library, nullptr) << dlerror();
#define SURFIT_CALL(name) reinterpret_cast<decltype(&::name)>(dlsym(library, #name))
  ASSERT_EQ(SURFIT_CALL(oniInitialize)(ONI_API_VERSION), ONI_STATUS_OK);
  OniDeviceHandle device = nullptr;
  ASSERT_EQ(SURFIT_CALL(oniDeviceOpen)("test://1", &device), ONI_STATUS_OK);
  OniStreamHandle streams[2] = {};
  OniRecorderHandle recorder = nullptr;
  ASSERT_EQ(SURFIT_CALL(oniCreateRecorder)(path.c_str(), &recorder), ONI_STATUS_OK);
  int count = 0;
  for (const OniSensorType sensor : {ONI_SENSOR_DEPTH, ONI_SENSOR_COLOR}) {
    if (SURFIT_CALL(oniDeviceGetSensorInfo)(device, sensor) == nullptr) continue;
    ASSERT_EQ(SURFIT_CALL(oniDeviceCreateStream)(device, sensor, &streams[count]), ONI_STATUS_OK);
    ASSERT_EQ(SURFIT_CALL(oniRecorderAttachStream)(recorder, streams[count], FALSE), ONI_STATUS_OK);
    ++count;
  }
  ASSERT_EQ(SURFIT_CALL(oniRecorderStart)(recorder), ONI_STATUS_OK);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // start of the recorder thread
  for (int i = 0; i < count; ++i) ASSERT_EQ(SURFIT_CALL(oniStreamStart)(streams[i]), ONI_STATUS_OK);
  constexpr int kSilence_ms = 1000;
  int ready = 0;
  OniFrame* frame = nullptr;
  while (SURFIT_CALL(oniWaitForAnyStream)(streams, count, &ready, kSilence_ms) == ONI_STATUS_OK) {
    ASSERT_EQ(SURFIT_CALL(oniStreamReadFrame)(streams[ready], &frame), ONI_STATUS_OK);
    SURFIT_CALL(oniFrameRelease)(frame);
  }
  SURFIT_CALL(oniRecorderStop)(recorder);
  SURFIT_CALL(oniRecorderDestroy)(&recorder);
  for (int i = 0; i < count; ++i) {
    SURFIT_CALL(oniStreamStop)(streams[i]);
    SURFIT_CALL(oniStreamDestroy)(streams[i]);
  }
  SURFIT_CALL(oniDeviceClose)(device);
  SURFIT_CALL(oniShutdown)();
#undef SURFIT_CALL
}

}  // namespace surfit::testing
