#include "io/image_files.h"

#include <random>

#include "testing/largest_allocation.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

Image<std::uint16_t> SomeDepth() {
  std::mt19937_64 rng(3);
  Image<std::uint16_t> depth(37, 23);
  for (auto& d : depth) d = static_cast<std::uint16_t>(rng());
  depth[0] = 0;
  depth[1] = 65535;
  return depth;
}

Image<Rgb8> SomeColor() {
  Image<Rgb8> color(37, 23);
  for (const auto [u, v] : PixelsOf(37, 23)) {
    color(u, v) = {static_cast<std::uint8_t>(200 - u), static_cast<std::uint8_t>(9 * v),
                   static_cast<std::uint8_t>(3 * u)};
  }
  return color;
}

TEST(ReadDepthImage, GivesTheCountsOfPngAndPgm) {
  TempFolder folder;
  for (const char* name : {"depth.png", "depth.pgm"}) {
    WriteDepth(folder / name, SomeDepth());
    EXPECT_EQ(std::get<Image<std::uint16_t>>(ReadDepthImage(folder / name)), SomeDepth()) << name;
  }
}

TEST(ReadDepthImage, GivesTheMetresOfFloatTiff) {
  TempFolder folder;
  Image<float> metres(5, 4, 1.25f);
  metres(3, 2) = 0;
  WriteDepth(folder / "depth.tiff", metres);
  EXPECT_EQ(std::get<Image<float>>(ReadDepthImage(folder / "depth.tiff")), metres);
}

TEST(ReadDepthImage, RefusesAColorImage) {
  TempFolder folder;
  WriteColor(folder / "color.png", SomeColor());
  ExpectInputError([&] { ReadDepthImage(folder / "color.png"); },
                   HasSubstr("color.png has 3 channel(s) of 8 bits"));
}

TEST(ReadColorImage, GivesRedGreenBlueOfPng) {
  TempFolder folder;
  WriteColor(folder / "color.png", SomeColor());
  EXPECT_EQ(ReadColorImage(folder / "color.png"), SomeColor());
}

TEST(ReadColorImage, GivesTheSameJpegPixelsAsOpenCv) {
  TempFolder folder;
  WriteColor(folder / "color.jpg", SomeColor());
  const Image<Rgb8> read = ReadColorImage(folder / "color.jpg");
  const cv::Mat bgr = cv::imread(folder / "color.jpg");
  for (const auto [u, v] : PixelsOf(read)) {
    const auto& p = bgr.at<cv::Vec3b>(v, u);
    EXPECT_EQ(read(u, v), (Rgb8{p[2], p[1], p[0]}));
  }
}

// Wherever the file ends, and whether the rest is gone or was never written (zeros), the picture
// must count as unreadable.
void ExpectEveryTruncationIsRefused(const std::string& path) {
  const std::string bytes = ReadBytes(path);
  ASSERT_GT(bytes.size(), 100u);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string cut = bytes.substr(0, size);
    EXPECT_THROW(DecodeColorImage(cut, path), InputError) << path << " cut to " << size;
    const std::string zeroed = cut + std::string(bytes.size() - size, '\0');
    if (zeroed == bytes) continue;
    EXPECT_THROW(DecodeColorImage(zeroed, path), InputError) << path << " zero from " << size;
  }
}

TEST(DecodeColorImage, RefusesEveryTruncation) {
  TempFolder folder;
  WriteColor(folder / "color.png", SomeColor());
  ExpectEveryTruncationIsRefused(folder / "color.png");
  WriteColor(folder / "baseline.jpg", SomeColor());
  ExpectEveryTruncationIsRefused(folder / "baseline.jpg");
  WriteColor(folder / "progressive.jpg", SomeColor(), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  ExpectEveryTruncationIsRefused(folder / "progressive.jpg");
}

// Cut anywhere, the depth is refused, or all of it is there (a TIFF may lack bytes that say
// nothing).
void ExpectTruncatedDepthIsRefusedOrWhole(const std::string& path) {
  const std::string bytes = ReadBytes(path);
  const RawDepth whole = DecodeDepthImage(bytes, path);
  int refused = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    try {
      EXPECT_EQ(DecodeDepthImage(bytes.substr(0, size), path), whole) << path << " cut to " << size;
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, static_cast<int>(bytes.size()) - 10);
}

// A few bytes that claim 256 million pixels, before any memory is taken for them.
TEST(DecodeDepthImage, RefusesMorePixelsThanBytesCanHold) {
  const auto entry = [](int tag, int type, int value) {
    return LittleEndian(static_cast<std::int16_t>(tag), static_cast<std::int16_t>(type), 1, value);
  };
  const std::string tiff = "II*" + LittleEndian('\0', 8, std::int16_t{2});
  std::string png = EncodedBytes(NumberedColor(0), ".png"),
              jpeg = EncodedBytes(NumberedColor(0), ".jpg");
  png.replace(16, 8, std::string("\0\0\x3E\x80\0\0\x3E\x80", 8));
  jpeg.replace(jpeg.find("\xFF\xC0") + 5, 4, "\x3E\x80\x3E\x80");
  for (const std::string& bytes : {std::string("P5 16000#\n 16000 65535\n"),
                                   tiff + entry(256, 3, 16000) + entry(257, 4, 16000), png, jpeg}) {
    ResetLargestAllocation();
    ExpectInputError([&] { ClaimedSize(bytes, "a.png"); }, HasSubstr("cannot hold 16000 x 16000"));
    EXPECT_THROW(DecodeDepthImage(bytes, "a.png"), InputError);
    EXPECT_THROW(DecodeColorImage(bytes, "a.png"), InputError);
    EXPECT_LT(LargestAllocation(), 1u << 20);
  }
  ExpectInputError([&] { ClaimedSize(tiff + entry(256, 16, 1) + entry(257, 4, 1), "a.tiff"); },
                   HasSubstr("its size is odd"));
}

TEST(DecodeColorImage, RefusesOtherKinds) {
  for (const char* kind : {".bmp", ".webp", ".ras"}) {
    ExpectInputError([&] { DecodeColorImage(EncodedBytes(NumberedColor(0), kind), "a.png"); },
                     HasSubstr("neither PNG, JPEG, TIFF, PGM nor PPM"));
  }
}

// As little as there may be: nothing but black, in one bit a pixel.
TEST(ReadColorImage, GivesAPngOfOneBitAPixel) {
  const TempFolder folder;
  cv::imwrite(folder / "black.png", cv::Mat(480, 640, CV_8UC1, cv::Scalar(0)),
              {cv::IMWRITE_PNG_BILEVEL, 1, cv::IMWRITE_PNG_COMPRESSION, 9});
  EXPECT_EQ(ReadColorImage(folder / "black.png"), Image<Rgb8>(640, 480));
}

TEST(DecodeDepthImage, RefusesTruncatedDepth) {
  TempFolder folder;
  WriteDepth(folder / "depth.png", SomeDepth());
  ExpectTruncatedDepthIsRefusedOrWhole(folder / "depth.png");
  WriteDepth(folder / "depth.pgm", SomeDepth());
  ExpectTruncatedDepthIsRefusedOrWhole(folder / "depth.pgm");
  WriteDepth(folder / "depth.tiff", Image<float>(37, 23, 1.25f));
  ExpectTruncatedDepthIsRefusedOrWhole(folder / "depth.tiff");
}

TEST(DecodeDepthImage, RefusesAPngWithAnyByteFlipped) {
  TempFolder folder;
  const std::string path = folder / "depth.png";
  WriteDepth(path, SomeDepth());
  const std::string bytes = ReadBytes(path);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] ^= 0x10;
    EXPECT_THROW(DecodeDepthImage(damaged, path), InputError) << "byte " << i;
  }
}

// JPEG has no checksums, so that damage to a coefficient can pass for a picture; damage that the
// decoder notices must not: here a piece cut out of the middle.
TEST(DecodeColorImage, RefusesAJpegWithAPieceMissing) {
  TempFolder folder;
  const std::string path = folder / "color.jpg";
  WriteColor(path, SomeColor());
  std::string bytes = ReadBytes(path);
  bytes.erase(bytes.size() - 40, 20);
  ExpectInputError([&] { DecodeColorImage(bytes, path); },
                   HasSubstr("color.jpg is truncated or damaged"));
}

TEST(ReadImage, NamesWhatIsNoImage) {
  TempFolder folder;
  WriteBytes(folder / "text.png", "no image at all");
  ExpectInputError([&] { ReadColorImage(folder / "text.png"); }, HasSubstr("text.png"));
  ExpectInputError([&] { ReadColorImage(folder / "missing.png"); }, HasSubstr("missing.png"));
  ExpectInputError([&] { ReadColorImage(folder.path()); }, HasSubstr(folder.path()));
}

std::string SomePng() {
  TempFolder folder;
  WriteDepth(folder / "depth.png", Image<std::uint16_t>(20, 10, 1234));
  return ReadBytes(folder / "depth.png");
}

TEST(RequireWholePng, AcceptsAWholeFileWhateverFollows) {
  EXPECT_TRUE(IsPng(SomePng()));
  EXPECT_NO_THROW(RequireWholePng(SomePng(), "a.png"));
  EXPECT_NO_THROW(RequireWholePng(SomePng() + "padding", "a.png"));
}

TEST(RequireWholePng, RefusesEveryTruncation) {
  const std::string bytes = SomePng();
  for (std::size_t size = 8; size < bytes.size(); ++size) {
    ExpectInputError([&] { RequireWholePng(bytes.substr(0, size), "a.png"); },
                     ::testing::StrEq("a.png is truncated"));
  }
}

TEST(RequireWholePng, RefusesEveryFlippedByte) {
  const std::string bytes = SomePng();
  for (std::size_t i = 8; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] ^= 0x10;
    ExpectInputError([&] { RequireWholePng(damaged, "a.png"); }, HasSubstr("a.png is "));
  }
}

TEST(IsPng, LooksAtTheSignature) {
  EXPECT_FALSE(IsPng(""));
  EXPECT_FALSE(IsPng("\x89PNG"));
  EXPECT_FALSE(IsPng("P5 20 10 65535 and so on"));
}

}  // namespace
}  // namespace surfit::testing
