#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {

// Writes the depth of frames as 16-bit PNG files, and depth.txt in the TUM format.
inline void WriteDepthFrames(const std::vector<RgbdFrame>& frames, double units_per_metre,
                             const TempFolder& folder) {
  std::string list = "# depth\n";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Image<float>& depth_m = frames[i].depth_m;
    Image<std::uint16_t> raw(depth_m.width(), depth_m.height());
    for (std::size_t k = 0; k < raw.size(); ++k) {
      raw[k] = static_cast<std::uint16_t>(std::lround(units_per_metre * depth_m[k]));
    }
    const std::string name = Format("depth/%03d.png", static_cast<int>(i));
    WriteDepth(folder / name, raw);
    list += std::to_string(frames[i].stamp_s) + " " + name + "\n";
  }
  folder.Write("depth.txt", list);
}

}  // namespace surfit::testing
