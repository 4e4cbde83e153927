#pragma once

#include <cstdint>

namespace surfit::testing {

// What the virtual camera of test_driver.cc does. The file that the environment variable
// SURFIT_TEST_CAMERA names begins with one, and frames follow it: two uint64 stamps of depth and
// colour (microseconds), depth (uint16 a pixel), colour (three bytes a pixel; of a camera that has
// any). What is set in the camera, the driver appends to the file's name with ".log".
struct CameraScript {
  std::int32_t width = 0, height = 0, frames = 0;
  std::int32_t has_color = 1;
  std::int32_t can_register = 1;
  float horizontal_fov_rad = 1, vertical_fov_rad = 0.8F;
  std::int32_t period_us = 3000;  // between frames
  // It is unplugged before this frame, and plugged in again later, with other name and stamps from
  // 0. -1: never.
  std::int32_t unplugged_at = -1;
  std::int32_t away_ms = 0;  // -1: for good
};

}  // namespace surfit::testing
