#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "testing/recordings.h"

namespace surfit::testing {

// Encoder of OpenEXR files with one channel of floats (openexr.com: "OpenEXR File Layout").

// Header. `window`: first and last column and row, as left, top, right, bottom. `compression`: 0
// none, 1 runs, 3 zip.
inline std::string ExrHead(const std::array<std::int32_t, 4>& window, char compression,
                           const std::string& channel) {
  const auto attribute = [](const std::string& name, const std::string& type,
                            const std::string& value) {
    return name + '\0' + type + '\0' + LittleEndian(static_cast<std::int32_t>(value.size())) +
           value;
  };
  const std::string channels =
      channel + '\0' +
      LittleEndian(std::int32_t{2}, std::uint32_t{0}, std::int32_t{1}, std::int32_t{1}) + '\0';
  const std::string box = LittleEndian(window[0], window[1], window[2], window[3]);
  return LittleEndian(std::uint32_t{0x01312f76}, std::uint32_t{2}) +
         attribute("channels", "chlist", channels) +
         attribute("compression", "compression", std::string(1, compression)) +
         attribute("dataWindow", "box2i", box) + attribute("displayWindow", "box2i", box) +
         attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
         attribute("pixelAspectRatio", "float", LittleEndian(1.f)) +
         attribute("screenWindowCenter", "v2f", LittleEndian(0.f, 0.f)) +
         attribute("screenWindowWidth", "float", LittleEndian(1.f)) + '\0';
}

// Scan lines from row `line`.
inline std::string ExrChunk(std::int32_t line, const std::string& data) {
  return LittleEndian(line, static_cast<std::int32_t>(data.size())) + data;
}

// File with these chunks, in their order.
inline std::string ExrFile(const std::string& head, const std::vector<std::string>& chunks) {
  std::string offsets, data;
  const std::uint64_t begin = head.size() + 8 * chunks.size();
  for (const std::string& chunk : chunks) {
    offsets += LittleEndian(std::uint64_t{begin + data.size()});
    data += chunk;
  }
  return head + offsets + data;
}

// File without compression.
inline std::string ExrFile(const Image<float>& image) {
  std::vector<std::string> chunks;
  for (int v = 0; v < image.height(); ++v) {
    chunks.push_back(
        ExrChunk(v, {reinterpret_cast<const char*>(image.row(v)), sizeof(float) * image.width()}));
  }
  return ExrFile(ExrHead({0, 0, image.width() - 1, image.height() - 1}, 0, "R"), chunks);
}

}  // namespace surfit::testing
