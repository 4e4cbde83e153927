#include <turbojpeg.h>
#include <zlib.h>

#include "io/images/image_files.h"
#include "testing/exr_writer.h"
#include "testing/matchers.h"
#include "testing/recordings.h"

namespace surfit::testing {
namespace {

std::string Npy(const std::string& type, const std::string& shape, const std::string& data,
                const char* fortran = "False") {
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': " + fortran + ", 'shape': " + shape + ", }";
  header.resize(117, ' ');
  header += '\n';
  return std::string("\x93NUMPY\x01\0", 8) +
         LittleEndian(static_cast<std::uint16_t>(header.size())) + header + data;
}

TEST(DecodeDepthImage, ReadsArraysOfNumPy) {
  Image<float> metres(3, 2);
  for (std::size_t i = 0; i < 6; ++i) metres[i] = 0.5f + static_cast<float>(i);
  const auto read = [](const std::string& bytes) {
    return std::get<Image<float>>(DecodeDepthImage(bytes, "a.npy"));
  };
  EXPECT_EQ(read(Npy("<f4", "(2, 3)", LittleEndian(.5f, 1.5f, 2.5f, 3.5f, 4.5f, 5.5f))), metres);
  EXPECT_EQ(read(Npy("<f8", "(2, 3, 1)", LittleEndian(.5, 1.5, 2.5, 3.5, 4.5, 5.5))), metres);
  EXPECT_EQ(read(Npy("<f4", "(2, 3)", LittleEndian(.5f, 3.5f, 1.5f, 4.5f, 2.5f, 5.5f), "True")),
            metres);
  const auto counts = DecodeDepthImage(Npy(">u2", "(1, 2)", std::string("\1\2\3\4", 4)), "a.npy");
  EXPECT_EQ(std::get<Image<std::uint16_t>>(counts)[0], 0x102);
  EXPECT_EQ(std::get<Image<std::uint16_t>>(counts)[1], 0x304);
}

TEST(DecodeDepthImage, RejectsOtherArraysByName) {
  const auto read = [](const std::string& bytes) { DecodeDepthImage(bytes, "a.npy"); };
  ExpectInputError([&] { read(Npy("<i8", "(1, 1)", LittleEndian(std::int64_t{5}))); },
                   Names("a.npy", "<i8"));
  ExpectInputError([&] { read(Npy("<f4", "(2, 3)", LittleEndian(1.f))); }, Names("a.npy"));
  ExpectInputError([&] { read(Npy("<f4", "(6,)", std::string(24, '\0'))); }, Names("a.npy"));
}

// Lines of kExrWidth numbers.
constexpr int kExrWidth = 4;
std::string Exr(char compression, const std::vector<std::string>& chunks) {
  return ExrFile(ExrHead({0, 5, kExrWidth - 1, 6}, compression, "Z"), chunks);
}

// Separates even and odd bytes and takes differences, as OpenEXR does before compression.
std::string Predicted(const std::string& bytes) {
  std::string parts;
  for (const std::size_t first : {0, 1}) {
    for (std::size_t i = first; i < bytes.size(); i += 2) parts += bytes[i];
  }
  std::string differences = parts;
  for (std::size_t i = 1; i < parts.size(); ++i)
    differences[i] = static_cast<char>(parts[i] - parts[i - 1] + 128);
  return differences;
}

std::string Zipped(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size,
           reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  packed.resize(size);
  return packed;
}

TEST(DecodeDepthImage, ReadsOpenExr) {
  const std::string first = LittleEndian(1.f, 1.f, 1.f, 1.f);
  const std::string second = LittleEndian(2.f, 2.f, 2.f, 2.25f);
  const auto expect = [](const std::string& bytes) {
    const auto depth = std::get<Image<float>>(DecodeDepthImage(bytes, "a.exr"));
    ASSERT_EQ(depth.width(), kExrWidth);
    ASSERT_EQ(depth.height(), 2);
    EXPECT_EQ(depth(0, 0), 1.f);
    EXPECT_EQ(depth(3, 0), 1.f);
    EXPECT_EQ(depth(0, 1), 2.f);
    EXPECT_EQ(depth(3, 1), 2.25f);
  };
  expect(Exr(0, {ExrChunk(5, first), ExrChunk(6, second)}));
  expect(Exr(0, {ExrChunk(6, second), ExrChunk(5, first)}));  // decreasing lines
  expect(Exr(3, {ExrChunk(5, Zipped(Predicted(first + second)))}));
  std::string runs;  // of single bytes
  for (const char byte : Predicted(first)) runs += std::string("\xff", 1) + byte;
  expect(Exr(1, {ExrChunk(5, runs), ExrChunk(6, second)}));
}

TEST(DecodeDepthImage, RejectsOtherOpenExrByName) {
  ExpectInputError([] { DecodeDepthImage(Exr(4, {ExrChunk(5, "x")}), "a.exr"); },
                   Names("a.exr", 4));
  ExpectInputError([] { DecodeDepthImage(Exr(3, {ExrChunk(5, "x")}), "a.exr"); }, Names("a.exr"));
  ExpectInputError([] { DecodeColorImage(Exr(0, {}), "a.exr"); }, Names("a.exr", "EXR"));
}

TEST(DecodeColorImage, IgnoresStrayBytesBeforeTheEndOfJpeg) {
  const Image<Rgb8> color = NumberedColor(77, 40, 30);
  const std::string jpeg = EncodeJpeg(color, 95);
  for (const std::string& stray : {std::string("\0", 1), std::string("\0\x12\x34", 3)}) {
    const std::string padded =
        jpeg.substr(0, jpeg.size() - 2) + stray + jpeg.substr(jpeg.size() - 2);
    EXPECT_EQ(DecodeColorImage(padded, "a.jpg"), DecodeColorImage(jpeg, "a.jpg"));
  }
  ExpectInputError([&] { DecodeColorImage(jpeg.substr(0, jpeg.size() / 2), "a.jpg"); },
                   Names("a.jpg"));
}

TEST(DecodeColorImage, NamesCmykJpeg) {
  const std::vector<unsigned char> pixels(4 * 16 * 16, 100);
  const tjhandle encoder = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  ASSERT_EQ(
      tjCompress2(encoder, pixels.data(), 16, 0, 16, TJPF_CMYK, &bytes, &size, TJSAMP_444, 90, 0),
      0);
  const std::string jpeg(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  tjDestroy(encoder);
  ExpectInputError([&] { DecodeColorImage(jpeg, "a.jpg"); }, Names("a.jpg", "CMYK"));
}

}  // namespace
}  // namespace surfit::testing
