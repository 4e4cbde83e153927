// Reads OpenEXR images of one part in scan lines ("Technical Introduction to OpenEXR" and "OpenEXR
// File Layout" of the Academy Software Foundation). A file is
//   magic number and version, attributes of the header, a table of offsets, chunks of lines
// Supported compression: none, RLE, ZIPS and ZIP. Supported numbers: half and float.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "io/cursor.h"
#include "io/images/deflate.h"
#include "io/images/image_kinds.h"

namespace surfit {
namespace {

const std::string kExrMagic = "\x76\x2f\x31\x01";

enum class ExrNumber { kUint, kHalf, kFloat };

struct ExrChannel {
  std::string name;
  ExrNumber number = ExrNumber::kFloat;
  bool is_sampled = false;  // fewer values than pixels

  std::size_t bytes() const { return number == ExrNumber::kHalf ? 2 : 4; }
};

struct ExrHeader {
  std::vector<ExrChannel> channels;  // in the order of the numbers of a line
  int compression = -1;
  ImageSize size;
  int first_line = 0;
  std::uint64_t chunks_at = 0;

  int LinesPerChunk() const { return compression == 3 ? 16 : 1; }
  int ChunkCount() const { return (size.height + LinesPerChunk() - 1) / LinesPerChunk(); }
  std::size_t BytesPerLine() const {
    std::size_t bytes = 0;
    for (const ExrChannel& channel : channels) bytes += channel.bytes() * size.width;
    return bytes;
  }
};

std::string TakeText(Cursor* cursor) {
  constexpr std::size_t kMax = 255;
  std::string text;
  for (char c; (c = cursor->Take<char>()) != '\0';) {
    text += c;
    ThrowIf(text.size() > kMax, cursor->name(), " is damaged: a name of its header is too long");
  }
  return text;
}

std::vector<ExrChannel> ReadExrChannels(std::string_view bytes, const std::string& path) {
  Cursor cursor(bytes, path);
  std::vector<ExrChannel> channels;
  for (std::string name; !(name = TakeText(&cursor)).empty();) {
    const auto type = cursor.Take<std::int32_t>();
    ThrowIf(type < 0 || type > 2, path, " is damaged: the type of channel ", name, " is ", type);
    cursor.Take<std::uint32_t>();
    const auto across = cursor.Take<std::int32_t>(), down = cursor.Take<std::int32_t>();
    channels.push_back({name, static_cast<ExrNumber>(type), across != 1 || down != 1});
  }
  return channels;
}

// Sides of the data window [min, max]. Limited to int, so that damaged windows are too large.
int ExrSide(std::int32_t min, std::int32_t max) {
  const std::int64_t side = std::int64_t{max} - min + 1;
  return static_cast<int>(std::clamp<std::int64_t>(side, 0, std::numeric_limits<int>::max()));
}

ExrHeader ReadExrHeader(const std::string& bytes, const std::string& path) {
  constexpr std::uint32_t kOtherLayouts = 0x1A00;  // tiles, deep data, several parts
  Cursor cursor(bytes, path);
  cursor.Take<std::uint32_t>();
  const auto version = cursor.Take<std::uint32_t>();
  ThrowIf(
      (version & 0xFF) != 2 || (version & kOtherLayouts) != 0, path,
      " is an EXR file with tiles, deep data or several parts, must be one image in scan lines");
  ExrHeader header;
  for (std::string name; !(name = TakeText(&cursor)).empty();) {
    TakeText(&cursor);  // type
    const std::string_view value = cursor.Counted();
    Cursor values(value, path);
    if (name == "channels") header.channels = ReadExrChannels(value, path);
    if (name == "compression") header.compression = values.Take<std::uint8_t>();
    if (name == "dataWindow") {
      std::array<std::int32_t, 4> box;
      for (std::int32_t& side : box) side = values.Take<std::int32_t>();
      header.size = {ExrSide(box[0], box[2]), ExrSide(box[1], box[3])};
      header.first_line = box[1];
    }
  }
  RequireValidSize(header.size, path);
  header.chunks_at = cursor.at() + std::uint64_t{8} * header.ChunkCount();
  return header;
}

// Channel of depth: the only one, otherwise Z, Y or R.
std::size_t FindDepthChannel(const ExrHeader& header, const std::string& path) {
  const std::vector<ExrChannel>& channels = header.channels;
  std::string names;
  for (const ExrChannel& channel : channels) {
    ThrowIf(channel.is_sampled, path, ": channel ", channel.name,
            " must have one number per pixel");
    names += (names.empty() ? "" : ", ") + channel.name;
  }
  if (channels.size() == 1) return 0;
  for (const char* name : {"Z", "Y", "R"}) {
    for (std::size_t k = 0; k < channels.size(); ++k)
      if (channels[k].name == name) return k;
  }
  throw InputError(path, " has the channels ", names, ", a depth image must have Z, Y or R");
}

// Run lengths: a count n >= 0 and a byte that is repeated n + 1 times, or n < 0 and -n bytes.
std::string ExpandRuns(std::string_view packed, std::size_t size, const std::string& path) {
  Cursor cursor(packed, path);
  std::string bytes;
  while (bytes.size() < size) {
    const int count = cursor.Take<std::int8_t>();
    if (count < 0) {
      bytes += cursor.Bytes(static_cast<std::uint64_t>(-count));
    } else {
      bytes.append(static_cast<std::size_t>(count) + 1, cursor.Take<char>());
    }
  }
  ThrowIf(bytes.size() != size, path, " is damaged: a chunk has the wrong size");
  return bytes;
}

// Reverses the differences of consecutive bytes, then the separation of even and odd bytes.
std::string Interleaved(std::string bytes) {
  for (std::size_t i = 1; i < bytes.size(); ++i)
    bytes[i] = static_cast<char>(bytes[i] + bytes[i - 1] - 128);
  std::string mixed(bytes.size(), '\0');
  const std::size_t half = (bytes.size() + 1) / 2;
  for (std::size_t i = 0; i < bytes.size(); ++i) mixed[i] = bytes[i / 2 + (i % 2 == 0 ? 0 : half)];
  return mixed;
}

std::string ExpandChunk(std::string_view packed, int compression, std::size_t size,
                        const std::string& path) {
  constexpr int kNone = 0, kRuns = 1;                     // ZIPS and ZIP are above
  if (packed.size() == size) return std::string(packed);  // compression would be larger
  ThrowIf(compression == kNone, path, " is damaged: a chunk has the wrong size");
  if (compression == kRuns) return Interleaved(ExpandRuns(packed, size, path));
  std::string bytes(size, '\0');
  ThrowIf(!Inflate(packed.data(), packed.size(), bytes.data(), size), path,
          " is damaged: a chunk cannot be decompressed");
  return Interleaved(std::move(bytes));
}

float TakeExrNumber(ExrNumber number, Cursor* cursor) {
  if (number == ExrNumber::kFloat) return cursor->Take<float>();
  return static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(cursor->Take<std::uint16_t>()));
}

}  // namespace

bool IsExr(const std::string& bytes) { return bytes.compare(0, kExrMagic.size(), kExrMagic) == 0; }

ImageSize ExrSize(const std::string& bytes, const std::string& path) {
  return ReadExrHeader(bytes, path).size;
}

RawDepth DecodeDepthExr(const std::string& bytes, const std::string& path) {
  const ExrHeader header = ReadExrHeader(bytes, path);
  ThrowIf(header.compression < 0 || header.compression > 3, path, " has compression ",
          header.compression, " of OpenEXR, must be 0 to 3: none, RLE, ZIPS or ZIP");
  const std::size_t depth = FindDepthChannel(header, path);
  const ExrChannel& channel = header.channels[depth];
  ThrowIf(channel.number == ExrNumber::kUint, path, ": channel ", channel.name,
          " has 32-bit integers, must have half or float numbers in metres");
  std::size_t before = 0;  // bytes of a line before the depth
  for (std::size_t k = 0; k < depth; ++k) before += header.channels[k].bytes() * header.size.width;
  Image<float> image(header.size.width, header.size.height);
  Cursor chunks(bytes, path);
  chunks.Bytes(header.chunks_at);
  for (int i = 0; i < header.ChunkCount(); ++i) {
    const std::int64_t top = std::int64_t{chunks.Take<std::int32_t>()} - header.first_line;
    ThrowIf(top < 0 || top >= header.size.height, path, " is damaged: it has no line ", top);
    const int count = std::min(header.LinesPerChunk(), header.size.height - static_cast<int>(top));
    const std::string lines =
        ExpandChunk(chunks.Counted(), header.compression, header.BytesPerLine() * count, path);
    for (int k = 0; k < count; ++k) {
      Cursor line(std::string_view(lines).substr(k * header.BytesPerLine() + before), path);
      float* const row = image.row(static_cast<int>(top) + k);
      std::generate_n(row, header.size.width, [&] { return TakeExrNumber(channel.number, &line); });
    }
  }
  return image;
}

}  // namespace surfit
