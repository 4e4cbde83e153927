#pragma once

#include "slam/simulated_sequence.h"

namespace surfit::testing {

// Frames of a room by an ideal sensor.
inline const SimulatedSequence& IdealRoom() {
  constexpr int kFrames = 25;
  static const auto* const room = new SimulatedSequence(SimulateRoom(1, kFrames, Sensor::kIdeal));
  return *room;
}

// One of them without any depth.
inline RgbdFrame Blank(int index) {
  RgbdFrame frame = IdealRoom().frames[index];
  frame.depth_m = Image<float>(frame.depth_m.width(), frame.depth_m.height(), 0.f);
  return frame;
}

// At 160 x 120 a pixel sees a spot of 1 / 131 rad, 15 mm wide at 2 m, the typical depth.
inline constexpr double kPixelRad = 1 / 131.25;
inline constexpr double kPixelAt2m = 2 * kPixelRad;

}  // namespace surfit::testing
