#pragma once

#include <cstdint>
#include <string>

#include "io/binary_file.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// The head of a .sens file (ScanNet's SensorData, version 4), little endian: uint32 version, uint64
// length and name of the sensor, 4 x 4 floats (row by row) intrinsics and extrinsics of colour,
// then of depth; int32 compression of colour (0 raw, 1 PNG, 2 JPEG) and of depth (0 raw, 1 zlib, 2
// occi); uint32 width and height of colour, then of depth; float depth counts per metre; uint64
// number of frames.
struct SensHeader {
  enum class DepthCoding { kRaw = 0, kZlib = 1 };

  // Extrinsics map the sensor's frame to a camera's. ScanNet's are identities: it registers colour
  // to depth by intrinsics alone.
  RgbdCamera camera;
  bool raw_color = false;  // else PNG or JPEG, as the bytes say
  DepthCoding depth_coding = DepthCoding::kZlib;
  std::uint64_t frame_count = 0;
  std::uint64_t size = 0;  // bytes
};

// Throws InputError naming the file and what is wrong; depth compressed by occipital's encoder,
// which is not public, is refused.
SensHeader ReadSensHeader(const BinaryFile& file);

}  // namespace surfit
