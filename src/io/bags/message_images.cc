#include "io/bags/message_images.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "io/cursor.h"
#include "io/images/image_files.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

bool Names(const std::string& text, const char* word) { return text.find(word) != text.npos; }

struct Layout {
  int bytes = 3;
  int r = 0, g = 1, b = 2;
};

std::optional<Layout> LayoutOf(const std::string& encoding) {
  static const auto* const layouts = new std::map<std::string, Layout>{
      {"rgb8", {3, 0, 1, 2}},  {"bgr8", {3, 2, 1, 0}},  {"8UC3", {3, 2, 1, 0}},
      {"rgba8", {4, 0, 1, 2}}, {"bgra8", {4, 2, 1, 0}}, {"8UC4", {4, 2, 1, 0}},
      {"mono8", {1, 0, 0, 0}}, {"8UC1", {1, 0, 0, 0}}};
  const auto found = layouts->find(encoding);
  if (found == layouts->end()) return std::nullopt;
  return found->second;
}

bool IsCounts(const std::string& encoding) { return encoding == "16UC1" || encoding == "mono16"; }

InputError WrongEncoding(const ImageMessage& message, const char* must, const std::string& name) {
  return InputError(Concat(name, " has encoding '", message.encoding, "', must be ", must));
}

// Throws InputError if image size, step and data size do not fit. `bytes`: bytes per pixel.
void RequireRows(const ImageMessage& message, int bytes, const std::string& name) {
  constexpr std::uint32_t kMost = 1u << 30;
  const ImageSize size{static_cast<int>(std::min(message.width, kMost)),
                       static_cast<int>(std::min(message.height, kMost))};
  RequireValidSize(size, name);
  const std::uint64_t row = std::uint64_t{message.width} * bytes;
  ThrowIf(message.step < row || std::uint64_t{message.step} * message.height > message.data.size(),
          name, " has ", message.data.size(), " bytes in rows of ", message.step, ", must have ",
          row, " for each of ", message.height, " rows");
}

template <typename T>
Image<T> CopyRows(const ImageMessage& message, const std::string& name) {
  RequireRows(message, sizeof(T), name);
  Image<T> image(static_cast<int>(message.width), static_cast<int>(message.height));
  for (int v = 0; v < image.height(); ++v) {
    std::memcpy(&image(0, v), &message.data[std::size_t{message.step} * v],
                sizeof(T) * image.width());
  }
  if (message.is_big_endian) {
    for (T& pixel : image) {
      auto* const bytes = reinterpret_cast<char*>(&pixel);
      std::reverse(bytes, bytes + sizeof(T));
    }
  }
  return image;
}

// Decodes compressed_depth_image_transport: an int32, two floats a and b, then a PNG. For 32FC1, a
// PNG value `count` is inverse depth: z = a / (count - b), m. Count 0: no depth.
RawDepth CompressedDepth(const ImageMessage& message, const std::string& name) {
  Cursor cursor(message.data, name);
  cursor.Take<std::int32_t>();
  const auto a = cursor.Take<float>(), b = cursor.Take<float>();
  const std::string png(cursor.Bytes(cursor.left()));
  if (!IsPng(png)) throw WrongEncoding(message, "compressed as a PNG", name);
  RawDepth depth = DecodeDepthImage(png, name);
  const auto* const counts = std::get_if<Image<std::uint16_t>>(&depth);
  if (counts == nullptr || !Names(message.encoding, "32FC1")) return depth;
  Image<float> metres(counts->width(), counts->height());
  for (std::size_t i = 0; i < metres.size(); ++i) {
    const float z = a / (static_cast<float>((*counts)[i]) - b);
    metres[i] = (*counts)[i] != 0 && std::isfinite(z) && z > 0 ? z : 0;
  }
  return metres;
}

}  // namespace

ImageKind KindOf(const ImageMessage& message, const std::string& topic) {
  const std::string& encoding = message.encoding;
  if (message.is_compressed) {
    if (Names(encoding, "compressedDepth") || Names(encoding, "16UC1")) return ImageKind::kDepth;
    if (Names(encoding, "mono8")) return ImageKind::kGrey;
    return IsPng(message.data) || IsJpeg(message.data) ? ImageKind::kColor : ImageKind::kUnreadable;
  }
  if (encoding == "16UC1" || encoding == "32FC1") return ImageKind::kDepth;
  if (encoding == "mono16") {
    std::string name = topic;
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return Names(name, "depth") ? ImageKind::kDepth : ImageKind::kUnreadable;
  }
  const auto layout = LayoutOf(encoding);
  if (!layout) return ImageKind::kUnreadable;
  return layout->bytes == 1 ? ImageKind::kGrey : ImageKind::kColor;
}

RawDepth DepthOf(const ImageMessage& message, const std::string& name) {
  if (message.is_compressed) {
    return Names(message.encoding, "compressedDepth") ? CompressedDepth(message, name)
                                                      : DecodeDepthImage(message.data, name);
  }
  if (IsCounts(message.encoding)) return CopyRows<std::uint16_t>(message, name);
  if (message.encoding == "32FC1") return CopyRows<float>(message, name);
  throw WrongEncoding(message, "16UC1, mono16 or 32FC1", name);
}

Image<Rgb8> ColorOf(const ImageMessage& message, const std::string& name) {
  if (message.is_compressed) return DecodeColorImage(message.data, name);
  const auto layout = LayoutOf(message.encoding);
  if (!layout) throw WrongEncoding(message, "rgb8, bgr8, rgba8, bgra8 or mono8", name);
  RequireRows(message, layout->bytes, name);
  Image<Rgb8> image(static_cast<int>(message.width), static_cast<int>(message.height));
  for (int v = 0; v < image.height(); ++v) {
    const char* pixel = &message.data[std::size_t{message.step} * v];
    for (int u = 0; u < image.width(); ++u, pixel += layout->bytes) {
      const auto at = [&](int channel) { return static_cast<std::uint8_t>(pixel[channel]); };
      image(u, v) = {at(layout->r), at(layout->g), at(layout->b)};
    }
  }
  return image;
}

}  // namespace surfit
