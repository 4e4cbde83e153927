// Fast decoder of common PNG files. Uses libdeflate, which is several times faster than zlib in
// libpng.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>

#include "io/images/deflate.h"
#include "io/images/image_kinds.h"

namespace surfit {
namespace {

using Bytes = const std::uint8_t*;

// Paeth predictor: the neighbour that is nearest to left + above - corner (PNG specification, 9.4).
int Paeth(int left, int above, int corner) {
  const int to_left = above - corner, to_above = left - corner;
  const int from_left = std::abs(to_left), from_above = std::abs(to_above);
  const int from_corner = std::abs(to_left + to_above);
  const int other = from_above <= from_corner ? above : corner;
  return from_left <= std::min(from_above, from_corner) ? left : other;
}

// Undoes the Paeth filter of a row. kSize: bytes per pixel. `above`: decoded previous row, zeros
// for the first row.
template <int kSize>
void UndoPaeth(Bytes above, std::size_t count, std::uint8_t* row) {
  std::array<int, kSize> left{}, corner{};
  for (std::size_t i = 0; i < count; i += kSize) {
    for (int k = 0; k < kSize; ++k) {
      const int up = above[i + k];
      left[k] = (row[i + k] + Paeth(left[k], up, corner[k])) & 0xFF;
      corner[k] = up;
      row[i + k] = static_cast<std::uint8_t>(left[k]);
    }
  }
}

// Returns false for an unknown filter type.
template <int kSize>
bool UndoFilter(int filter, Bytes above, std::size_t count, std::uint8_t* row) {
  switch (filter) {
    case 0:
      return true;
    case 1:
      for (std::size_t i = kSize; i < count; ++i) row[i] += row[i - kSize];
      return true;
    case 2:
      for (std::size_t i = 0; i < count; ++i) row[i] += above[i];
      return true;
    case 3:
      for (std::size_t i = 0; i < kSize; ++i) row[i] += above[i] / 2;
      for (std::size_t i = kSize; i < count; ++i) row[i] += (row[i - kSize] + above[i]) / 2;
      return true;
    case 4:
      UndoPaeth<kSize>(above, count, row);
      return true;
    default:
      return false;
  }
}

// Image size, bit depth and colour type of the IHDR chunk (PNG specification, 11.2.2).
struct PlainHeader {
  ImageSize size;
  int bits = 0, type = 0;
};

std::optional<PlainHeader> ReadHeader(const PngChunk& chunk) {
  constexpr std::size_t kBytes = 13;
  if (chunk.type != "IHDR" || chunk.data.size() != kBytes) return std::nullopt;
  const auto* const data = reinterpret_cast<Bytes>(chunk.data.data());
  const auto number = [](Bytes at) {
    return static_cast<int>(std::uint32_t{at[0]} << 24 | at[1] << 16 | at[2] << 8 | at[3]);
  };
  const bool has_usual_methods = data[10] == 0 && data[11] == 0 && data[12] == 0;
  if (!has_usual_methods) return std::nullopt;
  return PlainHeader{{number(data), number(data + 4)}, data[8], data[9]};
}

// Joined data of the IDAT chunks. Returns std::nullopt if they are not consecutive or the file has
// further critical chunks, for example a palette.
std::optional<std::string> CompressedRows(const std::vector<PngChunk>& png) {
  std::string data;
  bool has_ended = false;
  for (auto chunk = png.begin() + 1; chunk != png.end(); ++chunk) {
    const bool is_data = chunk->type == "IDAT";
    if (is_data && has_ended) return std::nullopt;
    if (is_data) data.append(chunk->data);
    has_ended = !is_data && !data.empty();
    const bool may_be_ignored = (chunk->type[0] & 0x20) != 0;
    if (!is_data && !may_be_ignored && chunk->type != "IEND") return std::nullopt;
  }
  return data;
}

// Decompressed rows. Each row is one byte of filter type, then the pixels.
struct Rows {
  std::size_t count = 0;  // bytes per row without the filter type
  std::vector<std::uint8_t> bytes;

  std::uint8_t* row(int v) { return bytes.data() + (count + 1) * v; }
};

template <int kSize>
std::optional<Rows> ReadRows(const std::vector<PngChunk>& png, ImageSize size) {
  const std::optional<std::string> data = CompressedRows(png);
  if (!data) return std::nullopt;
  const std::size_t count = std::size_t{kSize} * size.width;
  Rows rows{count, std::vector<std::uint8_t>((count + 1) * size.height)};
  if (!Inflate(data->data(), data->size(), rows.bytes.data(), rows.bytes.size()))
    return std::nullopt;
  const std::vector<std::uint8_t> nothing(count);
  Bytes above = nothing.data();
  for (int v = 0; v < size.height; ++v) {
    std::uint8_t* const row = rows.row(v);
    if (!UndoFilter<kSize>(row[0], above, count, row + 1)) return std::nullopt;
    above = row + 1;
  }
  return rows;
}

}  // namespace

std::optional<Image<std::uint16_t>> ReadPlainCounts(const std::vector<PngChunk>& png) {
  constexpr int kGray = 0;
  const std::optional<PlainHeader> header = ReadHeader(png.front());
  if (!header || header->type != kGray || header->bits != 16) return std::nullopt;
  std::optional<Rows> rows = ReadRows<2>(png, header->size);
  if (!rows) return std::nullopt;
  Image<std::uint16_t> counts(header->size.width, header->size.height);
  for (int v = 0; v < counts.height(); ++v) {
    Bytes byte = rows->row(v) + 1;
    std::uint16_t* const out = counts.row(v);
    for (int u = 0; u < counts.width(); ++u)
      out[u] = static_cast<std::uint16_t>(byte[2 * u] << 8 | byte[2 * u + 1]);
  }
  return counts;
}

std::optional<Image<Rgb8>> ReadPlainColor(const std::vector<PngChunk>& png) {
  constexpr int kRgb = 2;
  static_assert(sizeof(Rgb8) == 3, "rows are copied as red, green, blue");
  const std::optional<PlainHeader> header = ReadHeader(png.front());
  if (!header || header->type != kRgb || header->bits != 8) return std::nullopt;
  std::optional<Rows> rows = ReadRows<3>(png, header->size);
  if (!rows) return std::nullopt;
  Image<Rgb8> color(header->size.width, header->size.height);
  for (int v = 0; v < color.height(); ++v)
    std::memcpy(static_cast<void*>(color.row(v)), rows->row(v) + 1, rows->count);
  return color;
}

}  // namespace surfit
