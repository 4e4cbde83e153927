#include "io/images/image_files.h"

#include <zlib.h>

#include <random>

#include "io/images/image_kinds.h"
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

Image<Rgb8> ByOpenCv(const std::string& bytes) {
  const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
  const cv::Mat bgr = cv::imdecode(row, cv::IMREAD_COLOR);
  Image<Rgb8> image(bgr.cols, bgr.rows);
  for (const auto [u, v] : PixelsOf(image)) {
    const auto& pixel = bgr.at<cv::Vec3b>(v, u);
    image(u, v) = {pixel[2], pixel[1], pixel[0]};
  }
  return image;
}

std::string BigEndian(std::size_t number) {
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(number >> shift);
  return bytes;
}

TEST(ReadDepthImage, ReadsCountsOfPngAndPgm) {
  TempFolder folder;
  for (const char* name : {"depth.png", "depth.pgm"}) {
    WriteDepth(folder / name, SomeDepth());
    EXPECT_EQ(std::get<Image<std::uint16_t>>(ReadDepthImage(folder / name)), SomeDepth()) << name;
  }
}

TEST(ReadDepthImage, ReadsMetresOfFloatTiff) {
  TempFolder folder;
  Image<float> metres(5, 4, 1.25f);
  metres(3, 2) = 0;
  WriteDepth(folder / "depth.tiff", metres);
  EXPECT_EQ(std::get<Image<float>>(ReadDepthImage(folder / "depth.tiff")), metres);
}

TEST(ReadDepthImage, RejectsAColorImage) {
  TempFolder folder;
  WriteColor(folder / "color.png", SomeColor());
  ExpectInputError([&] { ReadDepthImage(folder / "color.png"); }, Names("color.png", 3, 8));
}

TEST(ReadColorImage, ReadsRedGreenBlueOfPng) {
  TempFolder folder;
  WriteColor(folder / "color.png", SomeColor());
  EXPECT_EQ(ReadColorImage(folder / "color.png"), SomeColor());
}

TEST(ReadColorImage, ReadsTheSameJpegPixelsAsOpenCv) {
  TempFolder folder;
  WriteColor(folder / "color.jpg", SomeColor());
  const Image<Rgb8> read = ReadColorImage(folder / "color.jpg");
  const cv::Mat bgr = cv::imread(folder / "color.jpg");
  for (const auto [u, v] : PixelsOf(read)) {
    const auto& p = bgr.at<cv::Vec3b>(v, u);
    EXPECT_EQ(read(u, v), (Rgb8{p[2], p[1], p[0]}));
  }
}

// Depth 0.5 + 0.01 (u + 37 v) m in deflate-compressed tiles of 16 x 16 pixels, as in GIS files.
TEST(ReadDepthImage, ReadsMetresOfATiledTiff) {
  const std::string bytes = ReadBytes(SURFIT_CORPUS_DIR "/tiled_metres.tiff");
  Image<float> metres(37, 20);
  for (std::size_t i = 0; i < metres.size(); ++i) metres[i] = 0.5f + 0.01f * static_cast<float>(i);
  EXPECT_EQ(std::get<Image<float>>(DecodeDepthImage(bytes, "a.tiff")), metres);
  std::string damaged = bytes;
  damaged.replace(20, 60, std::string(60, 'x'));
  EXPECT_THROW(DecodeDepthImage(damaged, "a.tiff"), InputError);
}

// The rows are red, green and blue in file order. The orientation tag (upside down) is ignored.
TEST(ReadColorImage, IgnoresTheOrientationOfATiff) {
  const Image<Rgb8> image = ReadColorImage(SURFIT_CORPUS_DIR "/upside_down.tiff");
  ASSERT_EQ(image.height(), 3);
  EXPECT_EQ(image(0, 0), (Rgb8{255, 0, 0}));
  EXPECT_EQ(image(1, 1), (Rgb8{0, 255, 0}));
  EXPECT_EQ(image(3, 2), (Rgb8{0, 0, 255}));
}

TEST(ReadDepthImage, ReadsCountsOfTiff) {
  const TempFolder folder;
  WriteDepth(folder / "depth.tiff", SomeDepth());
  EXPECT_EQ(std::get<Image<std::uint16_t>>(ReadDepthImage(folder / "depth.tiff")), SomeDepth());
}

// Truncates the file at every byte, with and without zero padding. Expects that no version decodes.
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

TEST(DecodeColorImage, RejectsEveryTruncation) {
  TempFolder folder;
  WriteColor(folder / "color.png", SomeColor());
  ExpectEveryTruncationIsRefused(folder / "color.png");
  WriteColor(folder / "baseline.jpg", SomeColor());
  ExpectEveryTruncationIsRefused(folder / "baseline.jpg");
  WriteColor(folder / "progressive.jpg", SomeColor(), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  ExpectEveryTruncationIsRefused(folder / "progressive.jpg");
}

// Truncates the file at every byte. Expects an error or all depths: a TIFF may end with unused
// bytes.
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

// Small files whose headers claim 256 million pixels are rejected before memory is allocated.
TEST(DecodeDepthImage, RejectsMorePixelsThanBytesCanHold) {
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
    ExpectInputError([&] { SizeInHeader(bytes, "a.png"); }, Names("a.png", 16000));
    EXPECT_THROW(DecodeDepthImage(bytes, "a.png"), InputError);
    EXPECT_THROW(DecodeColorImage(bytes, "a.png"), InputError);
    EXPECT_LT(LargestAllocation(), 1u << 20);
  }
  ExpectInputError([&] { SizeInHeader(tiff + entry(256, 16, 1) + entry(257, 4, 1), "a.tiff"); },
                   Names("a.tiff"));
}

TEST(DecodeColorImage, RejectsOtherFormats) {
  for (const char* kind : {".bmp", ".webp", ".ras"}) {
    ExpectInputError([&] { DecodeColorImage(EncodedBytes(NumberedColor(0), kind), "a.png"); },
                     Names("a.png", "PNG", "JPEG", "TIFF", "PGM", "PPM"));
  }
}

std::string Chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const auto checksum = crc32(0, reinterpret_cast<const Bytef*>(body.data()), body.size());
  return BigEndian(data.size()) + body + BigEndian(checksum);
}

// PNG file with these rows. Each row begins with its filter byte (PNG specification, 4 and 7).
// `chunks` is inserted before the image data.
std::string Png(ImageSize size, char bits, char type, const std::string& rows,
                const std::string& chunks = "") {
  const std::string header =
      BigEndian(size.width) + BigEndian(size.height) + bits + type + std::string(3, '\0');
  uLongf count = compressBound(rows.size());
  std::string packed(count, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &count,
           reinterpret_cast<const Bytef*>(rows.data()), rows.size());
  packed.resize(count);
  return "\x89PNG\r\n\x1A\n" + Chunk("IHDR", header) + chunks + Chunk("IDAT", packed) +
         Chunk("IEND", "");
}

constexpr char kGray = 0, kRgb = 2, kPalette = 3, kRgbAlpha = 6;

// Hand-made files, compared with OpenCV.
TEST(DecodeColorImage, DecodesEveryKindOfPngLikeOpenCv) {
  const std::string palette = Chunk("PLTE", "abcdefghijkl");
  for (const std::string& png :
       {Png({4, 2}, 2, kPalette, {"\0\x1B\0\xE4", 4}, palette),
        Png({4, 2}, 2, kPalette, {"\0\x1B\0\xE4", 4}, palette + Chunk("tRNS", {"\0\x80", 2})),
        Png({4, 2}, 2, kGray, {"\0\x1B\0\xE4", 4}), Png({3, 1}, 8, kGray, {"\0azy", 4}),
        Png({2, 1}, 16, kGray, {"\0a\xFF\xFFy", 5}), Png({1, 1}, 16, kRgb, {"\0aAbBcC", 7}),
        Png({1, 2}, 8, kRgbAlpha, {"\0abc\x10\0def\xFF", 10}),
        Png({2, 1}, 8, kRgb, {"\0abcdef", 7}, Chunk("gAMA", BigEndian(100000))),
        EncodedBytes(SomeColor(), ".png")}) {
    EXPECT_EQ(DecodeColorImage(png, "a.png"), ByOpenCv(png));
  }
}

// Rows of random bytes. Every filter occurs in the first row and after every other filter.
std::string FilteredRows(ImageSize size, int pixel_bytes) {
  std::mt19937_64 rng(7);
  std::string rows;
  for (int v = 0; v < size.height; ++v) {
    rows += static_cast<char>((v + v / 5) % 5);
    for (int i = 0; i < size.width * pixel_bytes; ++i) rows += static_cast<char>(rng());
  }
  return rows;
}

TEST(DecodeColorImage, UndoesEveryFilterOfAPng) {
  for (const int first : {0, 1, 2, 3, 4}) {
    std::string rows = FilteredRows({9, 30}, 3);
    rows[0] = static_cast<char>(first);
    const std::string png = Png({9, 30}, 8, kRgb, rows);
    EXPECT_TRUE(ReadPlainColor(PngChunks(png, "a.png")));
    EXPECT_EQ(DecodeColorImage(png, "a.png"), ByOpenCv(png)) << first;
  }
}

TEST(DecodeDepthImage, UndoesEveryFilterOfAPng) {
  for (const int first : {0, 1, 2, 3, 4}) {
    std::string rows = FilteredRows({9, 30}, 2);
    rows[0] = static_cast<char>(first);
    const std::string png = Png({9, 30}, 16, kGray, rows);
    EXPECT_TRUE(ReadPlainCounts(PngChunks(png, "a.png")));
    const cv::Mat row(1, static_cast<int>(png.size()), CV_8UC1, const_cast<char*>(png.data()));
    const cv::Mat expected = cv::imdecode(row, cv::IMREAD_UNCHANGED);
    const auto counts = std::get<Image<std::uint16_t>>(DecodeDepthImage(png, "a.png"));
    for (const auto [u, v] : PixelsOf(counts))
      EXPECT_EQ(counts(u, v), expected.at<std::uint16_t>(v, u)) << first << ": " << u << ", " << v;
  }
}

// libpng decodes unusual files. It rejects a chunk between the data chunks, and accepts a palette
// in an RGB image.
TEST(DecodeColorImage, LeavesOddPngsToLibpng) {
  std::string apart = EncodedBytes(SomeColor(), ".png");
  const std::size_t end = apart.size() - 12;
  apart.insert(end, Chunk("tEXt", std::string("a\0b", 3)) + Chunk("IDAT", ""));
  EXPECT_FALSE(ReadPlainColor(PngChunks(apart, "a.png")));
  const std::string palette = Png({2, 1}, 8, kRgb, {"\0abcdef", 7}, Chunk("PLTE", "abc"));
  EXPECT_FALSE(ReadPlainColor(PngChunks(palette, "a.png")));
  EXPECT_EQ(DecodeColorImage(palette, "a.png"), ByOpenCv(palette));
}

TEST(DecodeDepthImage, RejectsPngsOfOtherTypes) {
  ExpectInputError(
      [&] {
        DecodeDepthImage(Png({3, 1}, 8, kGray, {"\0azy", 4}), "a.png");
      },
      Names("a.png", 1, 8));
  ExpectInputError(
      [&] {
        DecodeDepthImage(Png({1, 1}, 16, kRgb, {"\0aAbBcC", 7}), "a.png");
      },
      Names("a.png", 3, 16));
}

// All checksums are correct, so only the decoder can detect the fault.
TEST(DecodeImage, RejectsPngsWithIncompleteRows) {
  const std::string two_of_three_rows = {"\0ab\0cd", 6};
  for (const std::string& png :
       {Png({2, 3}, 8, kGray, two_of_three_rows), Png({1, 3}, 16, kGray, two_of_three_rows),
        Png({2, 2}, 8, kGray,
            {"\x09"
             "ab\0cd",
             6}),
        Png({4, 2}, 2, kPalette, {"\0\0\0\0", 4}),
        Png({2, 2}, 16, kPalette, std::string(10, '\0'), Chunk("PLTE", "abc"))}) {
    EXPECT_THROW(DecodeColorImage(png, "a.png"), InputError);
    EXPECT_THROW(DecodeDepthImage(png, "a.png"), InputError);
  }
}

TEST(EncodePng, RoundTripsThePixels) {
  EXPECT_EQ(DecodeColorImage(EncodePng(SomeColor()), "a.png"), SomeColor());
  EXPECT_EQ(ByOpenCv(EncodePng(SomeColor())), SomeColor());
  EXPECT_EQ(std::get<Image<std::uint16_t>>(DecodeDepthImage(EncodePng(SomeDepth()), "a.png")),
            SomeDepth());
  ExpectInputError([] { EncodePng(Image<Rgb8>()); }, Names("PNG", 0));
}

TEST(DecodeColorImage, DecodesTextAndBinaryPgmAndPpm) {
  const Image<Rgb8> two(2, 1, {255, 0, 102});
  for (const std::string& bytes :
       {std::string("P3 2 1 255 255 0 102 255 0 102"),
        std::string("P3\n# two\n2 1 5 5 0 2 5 0 2\n"), std::string("P6 2 1 255 \xFF\0f\xFF\0f", 17),
        std::string("P6 2 1 5 \5\0\2\5\0\2", 15),
        std::string("P6 2 1 65535\n\xFF\xFF\0\0\x66\x66\xFF\xFF\0\0\x66\x66", 25)}) {
    EXPECT_EQ(DecodeColorImage(bytes, "a.ppm"), two) << bytes;
  }
  EXPECT_EQ(DecodeColorImage("P5 1 1 255\nz", "a.pgm"), Image<Rgb8>(1, 1, {'z', 'z', 'z'}));
  EXPECT_EQ(DecodeColorImage("P2 1 1 255 7", "a.pgm"), Image<Rgb8>(1, 1, {7, 7, 7}));
}

TEST(DecodeDepthImage, DecodesATextPgm) {
  Image<std::uint16_t> expected(1, 2, 7);
  expected[1] = 59999;
  EXPECT_EQ(std::get<Image<std::uint16_t>>(DecodeDepthImage("P2 1 2 60000 7 59999", "a.pgm")),
            expected);
  for (const char* const bytes : {"P2 2 2 60000 1 2 3", "P2 1 1 70000 1", "P2 1 1 0 1", "P2 1 1",
                                  "P5 1 1 65535 a", "P5 1 1 65535", "P2 1 1 60000 x "}) {
    EXPECT_THROW(DecodeDepthImage(bytes, "a.pgm"), InputError) << bytes;
  }
}

// The smallest kind of PNG: black, with one bit per pixel.
TEST(ReadColorImage, ReadsAPngWithOneBitPerPixel) {
  const TempFolder folder;
  cv::imwrite(folder / "black.png", cv::Mat(480, 640, CV_8UC1, cv::Scalar(0)),
              {cv::IMWRITE_PNG_BILEVEL, 1, cv::IMWRITE_PNG_COMPRESSION, 9});
  EXPECT_EQ(ReadColorImage(folder / "black.png"), Image<Rgb8>(640, 480));
}

TEST(DecodeDepthImage, RejectsTruncatedDepth) {
  TempFolder folder;
  WriteDepth(folder / "depth.png", SomeDepth());
  ExpectTruncatedDepthIsRefusedOrWhole(folder / "depth.png");
  WriteDepth(folder / "depth.pgm", SomeDepth());
  ExpectTruncatedDepthIsRefusedOrWhole(folder / "depth.pgm");
  WriteDepth(folder / "depth.tiff", Image<float>(37, 23, 1.25f));
  ExpectTruncatedDepthIsRefusedOrWhole(folder / "depth.tiff");
}

TEST(DecodeDepthImage, RejectsAPngWithAnyByteFlipped) {
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

// JPEG has no checksums, so damaged coefficients can go unnoticed. A missing piece must be
// rejected.
TEST(DecodeColorImage, RejectsAJpegWithAMissingPiece) {
  TempFolder folder;
  const std::string path = folder / "color.jpg";
  WriteColor(path, SomeColor());
  std::string bytes = ReadBytes(path);
  bytes.erase(bytes.size() - 40, 20);
  ExpectInputError([&] { DecodeColorImage(bytes, path); }, Names("color.jpg"));
}

TEST(ReadImage, RejectsFilesThatAreNoImages) {
  TempFolder folder;
  WriteBytes(folder / "text.png", "no image at all");
  ExpectInputError([&] { ReadColorImage(folder / "text.png"); }, Names("text.png"));
  ExpectInputError([&] { ReadColorImage(folder / "missing.png"); }, Names("missing.png"));
  ExpectInputError([&] { ReadColorImage(folder.path()); }, Names(folder.path()));
}

std::string SomePng() {
  TempFolder folder;
  WriteDepth(folder / "depth.png", Image<std::uint16_t>(20, 10, 1234));
  return ReadBytes(folder / "depth.png");
}

TEST(PngChunks, AcceptsAFileWithTrailingBytes) {
  EXPECT_TRUE(IsPng(SomePng()));
  for (const std::string& png : {SomePng(), SomePng() + "padding"}) {
    const std::vector<PngChunk> chunks = PngChunks(png, "a.png");
    EXPECT_EQ(chunks.front().type, "IHDR");
    EXPECT_EQ(chunks.front().data.size(), 13u);
    EXPECT_EQ(chunks.back().type, "IEND");
  }
}

TEST(PngChunks, RejectsEveryTruncation) {
  const std::string bytes = SomePng();
  for (std::size_t size = 8; size < bytes.size(); ++size) {
    ExpectInputError([&] { PngChunks(bytes.substr(0, size), "a.png"); }, Names("a.png"));
  }
}

TEST(PngChunks, RejectsEveryFlippedByte) {
  const std::string bytes = SomePng();
  for (std::size_t i = 8; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] ^= 0x10;
    ExpectInputError([&] { PngChunks(damaged, "a.png"); }, Names("a.png"));
  }
}

TEST(IsPng, ChecksTheSignature) {
  EXPECT_FALSE(IsPng(""));
  EXPECT_FALSE(IsPng("\x89PNG"));
  EXPECT_FALSE(IsPng("P5 20 10 65535 and so on"));
}

}  // namespace
}  // namespace surfit::testing
