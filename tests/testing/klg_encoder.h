#pragma once

#include "testing/frame_codings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {

inline std::string KlgFrame(std::int64_t stamp_us, const std::string& depth,
                            const std::string& color) {
  return LittleEndian(stamp_us, static_cast<std::int32_t>(depth.size()),
                      static_cast<std::int32_t>(color.size())) +
         depth + color;
}

// `count` of the small numbered frames at 10 Hz from time 5. Depth is raw or compressed, colour
// raw, JPEG or none ("", ".jpg", "none").
inline std::string KlgFile(int count, bool zlib, const std::string& color) {
  std::string file = LittleEndian(static_cast<std::int32_t>(count));
  for (int i = 0; i < count; ++i) {
    const auto depth = NumberedDepth(i);
    const auto rgb = NumberedColor(i);
    const std::string color_bytes =
        color == "none" ? "" : (color.empty() ? RawBytes(rgb) : EncodedBytes(rgb, color));
    file += KlgFrame(5000000 + 100000 * i, zlib ? ZlibBytes(depth) : RawBytes(depth), color_bytes);
  }
  return file;
}

}  // namespace surfit::testing
