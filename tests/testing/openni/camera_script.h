#pragma once

#include <cstdint>

namespace surfit::testing {

// Behaviour of the virtual camera of test_driver.cc. The environment variable SURFIT_TEST_CAMERA
// names a file with this struct and the frames. A frame is: uint64 timestamps of depth and colour
// in microseconds, depth (uint16 per pixel), and colour (3 bytes per pixel, if the camera has
// colour). The driver logs changed settings to the file with the suffix ".log".
struct CameraScript {
  std::int32_t width = 0, height = 0, frames = 0;
  std::int32_t has_color = 1;
  std::int32_t can_register = 1;
  float horizontal_fov_rad = 1, vertical_fov_rad = 0.8F;
  std::int32_t period_us = 3000;  // between frames
  // The camera is disconnected before this frame, and reconnected with a different URI and
  // timestamps from 0; -1: never.
  std::int32_t unplugged_at = -1;
  std::int32_t away_ms = 0;  // time until reconnection, ms; -1: forever
};

}  // namespace surfit::testing
