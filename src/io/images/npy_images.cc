// Reads arrays of NumPy, format version 1 to 3: "\x93NUMPY", two bytes of version, the length of
// the header, and the header as a dictionary of Python:
//   {'descr': '<f4', 'fortran_order': False, 'shape': (480, 640), }
// The numbers follow (numpy.lib.format in the documentation of NumPy).
#include <algorithm>
#include <cstring>

#include "io/files/text.h"
#include "io/images/image_kinds.h"

namespace surfit {
namespace {

const std::string kNpySignature = "\x93NUMPY";

struct NpyHeader {
  std::string type;  // byte order, kind and bytes per number: <f4
  bool is_column_major = false;
  ImageSize size;
  std::size_t data_at = 0;
};

// Text of a key up to the end of its value.
std::string NpyValue(const std::string& header, const std::string& key, const char* end,
                     const std::string& path) {
  const std::size_t at = header.find("'" + key + "':");
  const std::size_t begin = at == header.npos ? at : at + key.size() + 3;
  const std::size_t stop = begin == header.npos ? begin : header.find_first_of(end, begin);
  ThrowIf(stop == header.npos, path, " is damaged: its header has no ", key);
  return header.substr(begin, stop - begin);
}

int NpySide(std::string_view word, const std::string& path) {
  constexpr std::int64_t kMost = 1 << 30;
  return static_cast<int>(std::min(kMost, WithContext(path, [&] { return ParseCount(word); })));
}

NpyHeader ReadNpyHeader(const std::string& bytes, const std::string& path) {
  const auto byte = [&](std::size_t at) {
    ThrowIf(at >= bytes.size(), path, " is truncated");
    return static_cast<std::size_t>(static_cast<unsigned char>(bytes[at]));
  };
  const std::size_t version = byte(6), begin = version == 1 ? 10 : 12;
  ThrowIf(version < 1 || version > 3, path, " has version ", version, " of NPY, must be 1 to 3");
  std::size_t length = byte(8) | byte(9) << 8;
  if (version > 1) length |= byte(10) << 16 | byte(11) << 24;
  ThrowIf(length > bytes.size() || begin > bytes.size() - length, path, " is truncated");
  const std::string header = bytes.substr(begin, length);
  NpyHeader npy;
  npy.data_at = begin + length;
  std::string type = NpyValue(header, "descr", ",}", path);
  type.erase(std::remove_if(type.begin(), type.end(), [](char c) { return c == '\'' || c == ' '; }),
             type.end());
  npy.type = type;
  npy.is_column_major =
      NpyValue(header, "fortran_order", ",}", path).find("True") != std::string::npos;
  std::string shape = NpyValue(header, "shape", ")", path);
  std::replace_if(
      shape.begin(), shape.end(), [](char c) { return c == '(' || c == ','; }, ' ');
  const Words sides = SplitWords(shape);
  ThrowIf(sides.size() < 2 || sides.size() > 3 || (sides.size() == 3 && sides[2] != "1"), path,
          " has an array of ", sides.size(), " dimensions (", shape,
          "), a depth image must have (height, width) or (height, width, 1)");
  npy.size = {NpySide(sides[1], path), NpySide(sides[0], path)};
  return npy;
}

template <typename T, typename Pixel>
RawDepth NpyPixels(const std::string& bytes, const NpyHeader& npy, const std::string& path) {
  const std::size_t count = npy.size.pixels();
  ThrowIf((bytes.size() - npy.data_at) / sizeof(T) < count, path, " is truncated");
  const bool is_big_endian = npy.type[0] == '>';
  Image<Pixel> image(npy.size.width, npy.size.height);
  for (std::size_t i = 0; i < count; ++i) {
    char number[sizeof(T)];
    std::memcpy(number, &bytes[npy.data_at + i * sizeof(T)], sizeof(T));
    if (is_big_endian) std::reverse(number, number + sizeof(T));
    T value;
    std::memcpy(&value, number, sizeof(T));
    const std::size_t height = static_cast<std::size_t>(npy.size.height);
    const std::size_t at = npy.is_column_major ? i % height * npy.size.width + i / height : i;
    image[at] = static_cast<Pixel>(value);
  }
  return image;
}

}  // namespace

bool IsNpy(const std::string& bytes) {
  return bytes.compare(0, kNpySignature.size(), kNpySignature) == 0;
}

ImageSize NpySize(const std::string& bytes, const std::string& path) {
  return ReadNpyHeader(bytes, path).size;
}

RawDepth DecodeDepthNpy(const std::string& bytes, const std::string& path) {
  const NpyHeader npy = ReadNpyHeader(bytes, path);
  const std::string kind = npy.type.size() == 3 ? npy.type.substr(1) : "";
  if (kind == "u2") return NpyPixels<std::uint16_t, std::uint16_t>(bytes, npy, path);
  if (kind == "f4") return NpyPixels<float, float>(bytes, npy, path);
  if (kind == "f8") return NpyPixels<double, float>(bytes, npy, path);
  throw InputError(path, " has numbers of type '", npy.type,
                   "', a depth image must have u2, f4 or f8: 16-bit counts, or floats in metres");
}

}  // namespace surfit
