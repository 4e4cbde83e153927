// Recordings and clouds in forms that other programs write.
#include <turbojpeg.h>
#include <zlib.h>

#include <cmath>
#include <random>

#include "io/depth/depth_encoding.h"
#include "io/images/image_files.h"
#include "surfit/io/g2o.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

constexpr int kWidth = 80, kHeight = 60;
constexpr int kFar = 2500;  // mm
constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";

// Depth of a slanted wall and a box in front of it, in mm. It moves with the frame.
Image<std::uint16_t> SlantedDepth(int frame) {
  Image<std::uint16_t> depth(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool is_box = u > 20 + frame && u < 40 + frame && v > 20 && v < 40;
      depth(u, v) = static_cast<std::uint16_t>((is_box ? 900 : 1500) + 9 * u + 13 * v + 11 * frame);
    }
  }
  return depth;
}

std::vector<FrameImages> FirstImages(const std::function<RawDepth(int)>& depth_of) {
  std::vector<FrameImages> images;
  for (int i = 0; i < 4; ++i) images.push_back({depth_of(i), {}, "depth.png", ""});
  return images;
}

RgbdCamera CameraOf(double units_per_metre) {
  RgbdCamera camera;
  camera.depth_units_per_metre = units_per_metre;
  return camera;
}

template <typename F>
Image<std::uint16_t> Changed(Image<std::uint16_t> depth, const F& change) {
  for (auto& count : depth) count = static_cast<std::uint16_t>(change(count));
  return depth;
}

// Detects the encoding of the images, decodes the first image and returns it.
Image<std::uint16_t> Decoded(const std::vector<FrameImages>& images, double units_per_metre,
                             std::vector<std::string>* warnings) {
  const DepthEncoding encoding = DetectDepthEncoding(images, CameraOf(units_per_metre), warnings);
  RawDepth depth = images[0].depth;
  DecodeDepth(encoding, &depth);
  return std::get<Image<std::uint16_t>>(depth);
}

TEST(DepthEncoding, IsPlainForCountsAndFloats) {
  std::vector<std::string> warnings;
  const auto counts = FirstImages([](int i) { return SlantedDepth(i); });
  for (const double units : {1000., 5000., 6553.5})
    EXPECT_TRUE(DetectDepthEncoding(counts, CameraOf(units), &warnings).IsPlain());
  const auto floats = FirstImages([](int i) {
    Image<float> metres(kWidth, kHeight);
    for (std::size_t k = 0; k < metres.size(); ++k) metres[k] = 0.001f * SlantedDepth(i)[k];
    return metres;
  });
  EXPECT_TRUE(DetectDepthEncoding(floats, CameraOf(5000), &warnings).IsPlain());
  EXPECT_THAT(warnings, ::testing::IsEmpty());
}

TEST(DepthEncoding, CorrectsSwappedBytes) {
  const auto images = FirstImages([](int i) {
    return Changed(SlantedDepth(i), [](int count) { return count << 8 | count >> 8; });
  });
  std::vector<std::string> warnings;
  EXPECT_EQ(Decoded(images, 1000, &warnings), SlantedDepth(0));
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", "bytes")));
}

TEST(DepthEncoding, CorrectsRotatedBits) {
  const auto images = FirstImages([](int i) {
    return Changed(SlantedDepth(i), [](int count) { return count << 3 | count >> 13; });
  });
  std::vector<std::string> warnings;
  EXPECT_EQ(Decoded(images, 1000, &warnings), SlantedDepth(0));
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", "rotated", 3)));
  // With this scale, the counts are plausible.
  warnings.clear();
  EXPECT_TRUE(DetectDepthEncoding(images, CameraOf(8000), &warnings).IsPlain());
}

TEST(DepthEncoding, ConvertsFloatsInMillimetres) {
  const auto images = FirstImages([](int i) {
    Image<float> depth(kWidth, kHeight);
    for (std::size_t k = 0; k < depth.size(); ++k) depth[k] = SlantedDepth(i)[k];
    return depth;
  });
  std::vector<std::string> warnings;
  RawDepth depth = images[0].depth;
  DecodeDepth(DetectDepthEncoding(images, CameraOf(1000), &warnings), &depth);
  EXPECT_FLOAT_EQ(std::get<Image<float>>(depth)[0], 1.5f);
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", "mm")));
}

TEST(DepthEncoding, ReadsAFarPlaneAsMissing) {
  const auto images = FirstImages([](int i) {
    return Changed(SlantedDepth(i), [](int count) { return std::min(count, kFar); });
  });
  std::vector<std::string> warnings;
  const Image<std::uint16_t> decoded = Decoded(images, 1000, &warnings);
  const Image<std::uint16_t> true_depth = SlantedDepth(0);
  for (std::size_t k = 0; k < decoded.size(); ++k)
    ASSERT_EQ(decoded[k], true_depth[k] < kFar ? true_depth[k] : 0) << k;
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", 2500, 2.5)));
}

// A static camera cannot show whether a value is a surface.
TEST(DepthEncoding, KeepsAFrequentValueOfAStaticCamera) {
  const auto images = FirstImages([](int) {
    return Changed(SlantedDepth(0), [](int count) { return std::min(count, 2500); });
  });
  std::vector<std::string> warnings;
  EXPECT_TRUE(DetectDepthEncoding(images, CameraOf(1000), &warnings).IsPlain());
}

TEST(FarDepthWarning, NamesTheRatioBeyondTheLimit) {
  const auto images = FirstImages(
      [](int i) { return Changed(SlantedDepth(i), [](int count) { return 5 * count; }); });
  EXPECT_FALSE(FarDepthWarning(images, CameraOf(5000), 8));
  EXPECT_THAT(FarDepthWarning(images, CameraOf(1000), 8).value_or(""), Names("max_depth_m", 8));
}

TEST(DepthScaleWarning, DoesNotClaimAnotherScaleIfTheScaleIsGiven) {
  const Image<std::uint16_t> depth(10, 10, 1800);
  EXPECT_THAT(DepthScaleWarning(depth, 10000, "d.png", true).value_or(""),
              ::testing::AllOf(Names("d.png", 0.18, 10000, 1000, 1.8),
                               ::testing::Not(::testing::HasSubstr("likely"))));
}

class FolderTest : public ::testing::Test {
 protected:
  void WriteFrames(const std::string& depth, const std::string& color) const {
    for (int i = 0; i < 3; ++i) {
      WriteDepth(folder_ / (depth + Format("/frame_%05d.png", i + 1)), SlantedDepth(i));
      WriteColor(folder_ / (color + Format("/frame_%05d.png", i + 1)),
                 NumberedColor(i, kWidth, kHeight));
    }
  }
  std::unique_ptr<FrameSource> Open() const { return OpenSequence(Options(folder_)); }

  TempFolder folder_;
};

TEST_F(FolderTest, DecodesAllFrames) {
  for (int i = 0; i < 3; ++i)
    WriteDepth(folder_ / Format("depth/%d.png", i),
               Changed(SlantedDepth(i), [](int count) { return count << 8 | count >> 8; }));
  SequenceOptions options = Options(folder_);
  options.intrinsics = {70, 70, 40, 30};
  const auto source = OpenSequence(options);
  EXPECT_THAT(source->info().warnings, ::testing::Contains(Names("bytes")));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i)
    EXPECT_FLOAT_EQ(results[i].frame->depth_m[0], 0.001f * SlantedDepth(i)[0]);
}

TEST_F(FolderTest, ReadsCameraAndFilesOfNerfstudio) {
  WriteFrames("depth", "images");
  std::string frames;
  for (const int i : {2, 1, 3}) {
    const std::string name = Format("frame_%05d.png", i);
    frames += (frames.empty() ? "" : ",") + std::string("{\"file_path\": \"images/") + name +
              "\", \"depth_file_path\": \"depth/" + name + "\"}";
  }
  folder_.Write(
      "transforms.json",
      "{\"fl_x\": 71, \"fl_y\": 72, \"cx\": 40, \"cy\": 30, \"w\": 80, \"h\": 60, \"k1\": "
      "0.01, \"camera_model\": \"OPENCV\", \"depth_unit_scale_factor\": 0.0005, "
      "\"frames\": [" +
          frames + "]}");
  const auto source = Open();
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "nerfstudio");
  EXPECT_FALSE(info.camera_is_guessed);
  EXPECT_EQ(info.camera.depth.fx, 71);
  EXPECT_EQ(info.camera.depth.fy, 72);
  EXPECT_EQ(info.camera.depth.distortion[0], 0.01);
  EXPECT_DOUBLE_EQ(info.camera.depth_units_per_metre, 2000);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_EQ(results[i].frame->color(40, 30).r, i);
  }
}

TEST_F(FolderTest, RejectsNerfstudioFisheyeByItsModel) {
  WriteFrames("depth", "images");
  folder_.Write("transforms.json",
                "{\"fl_x\": 71, \"cx\": 40, \"cy\": 30, \"w\": 80, \"h\": 60, \"camera_model\": "
                "\"OPENCV_FISHEYE\", \"frames\": []}");
  ExpectInputError([&] { Open(); }, Names("transforms.json", "OPENCV_FISHEYE"));
}

TEST_F(FolderTest, ReadsTheCameraOfInfoText) {
  for (int i = 0; i < 3; ++i)
    WriteDepth(folder_ / Format("frame-%06d.depth.png", i), SlantedDepth(i));
  folder_.Write(
      "_info.txt",
      "m_versionNumber = 4\nm_colorWidth = 80\nm_colorHeight = 60\nm_depthWidth = 80\n"
      "m_depthHeight = 60\nm_depthShift = 2000\nm_calibrationColorIntrinsic = 75 0 40 0 0 "
      "76 30 0 0 0 1 0 0 0 0 1\nm_calibrationDepthIntrinsic = 75 0 40 0 0 76 30 0 0 0 1 0 "
      "0 0 0 1\n");
  const SequenceInfo info = Open()->info();
  EXPECT_EQ(info.format, "seven_scenes");
  EXPECT_EQ(info.camera.depth.fx, 75);
  EXPECT_EQ(info.camera.depth.fy, 76);
  EXPECT_EQ(info.camera.depth_units_per_metre, 2000);
  EXPECT_TRUE(info.camera.color_is_registered);
}

TEST_F(FolderTest, TellsThatTheCameraOfSevenScenesIsGuessedByNames) {
  Image<std::uint16_t> depth(640, 480, 1800);
  for (std::size_t i = 0; i < depth.size(); ++i)
    depth[i] = static_cast<std::uint16_t>(1500 + i % 640);
  WriteDepth(folder_ / "frame-000000.depth.png", depth);
  EXPECT_TRUE(Open()->info().camera_is_guessed);
  SequenceOptions options = Options(folder_);
  options.format = "seven_scenes";
  EXPECT_FALSE(OpenSequence(options)->info().camera_is_guessed);
}

TEST_F(FolderTest, RejectsIntrinsicsThatAreRatiosOfTheImageSize) {
  WriteFrames("depth", "color");
  SequenceOptions options = Options(folder_);
  options.intrinsics = {0.8, 1.1, 0.5, 0.5};
  ExpectInputError([&] { OpenSequence(options); }, Names("fx", 0.8, 1.1, 0.5, 80, 60));
}

TEST_F(FolderTest, NamesAnImageFormatThatIsNotSupported) {
  WriteDepth(folder_ / "depth/1.png", SlantedDepth(0));
  folder_.Write("color/1.webp", std::string("RIFF\x20\0\0\0WEBPVP8 ", 16) + std::string(40, 'x'));
  SequenceOptions options = Options(folder_);
  options.intrinsics = {70, 70, 40, 30};
  ExpectInputError([&] { OpenSequence(options); }, Names("color/1.webp", "WebP"));
}

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

std::string Attribute(const std::string& name, const std::string& type, const std::string& value) {
  return name + '\0' + type + '\0' + LittleEndian(static_cast<std::uint32_t>(value.size())) + value;
}

// OpenEXR file with one channel of floats, and lines of kExrWidth numbers.
constexpr int kExrWidth = 4;
std::string Exr(char compression, const std::vector<std::string>& chunks) {
  const std::string channel =
      std::string("Z") + '\0' +
      LittleEndian(std::int32_t{2}, std::uint32_t{0}, std::int32_t{1}, std::int32_t{1}) + '\0';
  const std::string box =
      LittleEndian(std::int32_t{0}, std::int32_t{5}, std::int32_t{kExrWidth - 1}, std::int32_t{6});
  std::string file = LittleEndian(std::uint32_t{0x01312f76}, std::uint32_t{2}) +
                     Attribute("channels", "chlist", channel) +
                     Attribute("compression", "compression", std::string(1, compression)) +
                     Attribute("dataWindow", "box2i", box) + '\0';
  file += std::string(8 * chunks.size(), '\0');  // offsets
  for (const std::string& chunk : chunks) file += chunk;
  return file;
}

std::string ExrChunk(std::int32_t line, const std::string& data) {
  return LittleEndian(line, static_cast<std::uint32_t>(data.size())) + data;
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

TEST(ByteOrderMark, IsIgnoredInTextFiles) {
  const TempFolder folder;
  WriteTumSequence(folder, 2);
  for (const char* name : {"depth.txt", "rgb.txt", "groundtruth.txt"}) {
    const std::string text = ReadBytes(folder / name);
    folder.Write(name, kByteOrderMark + text.substr(text.find('\n') + 1));
  }
  EXPECT_EQ(OpenSequence(Options(folder))->info().frame_count, 2);
  EXPECT_EQ(ReadTumTrajectory(folder / "groundtruth.txt").size(), 2u);
  const std::string graph = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
  EXPECT_EQ(ReadG2o(folder.Write("a.g2o", kByteOrderMark + graph)).graph.poses.size(), 1u);
}

TEST(G2o, CountsVerticesOfOtherTypesWithTheirFix) {
  const TempFolder folder;
  const std::string point = "VERTEX_TRACKXYZ 0 1 2 3\nFIX 0\n";
  ExpectInputError([&] { ReadG2o(folder.Write("point.g2o", point)); },
                   Names("point.g2o", "VERTEX_TRACKXYZ", "FIX"));
  const G2oFile file =
      ReadG2o(folder.Write("mixed.g2o", point + "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\nFIX 1\n"));
  EXPECT_TRUE(file.graph.poses.at(0).fixed);
  EXPECT_EQ(file.ignored_lines.at("FIX"), 1u);
}

std::string Reversed(std::string bytes) {
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

TEST(Ply, ReadsBigEndianAndUpperCaseNames) {
  const TempFolder folder;
  const PointCloud cloud = ReadPointCloud(folder.Write(
      "a.ply",
      "ply\nformat binary_big_endian 1.0\nelement VERTEX 1\nproperty float X\nproperty "
      "double Y\nproperty short Z\nend_header\n" +
          Reversed(LittleEndian(1.5f)) + Reversed(LittleEndian(2.5)) +
          Reversed(LittleEndian(std::int16_t{-3}))));
  ASSERT_EQ(cloud.points.size(), 1u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1.5f, 2.5f, -3));
}

TEST(Pcd, SkipsFieldsOfEightBytes) {
  const TempFolder folder;
  const PointCloud cloud = ReadPointCloud(folder.Write(
      "a.pcd",
      "VERSION 0.7\nFIELDS t x y z s\nSIZE 8 4 4 4 8\nTYPE U F F F I\nWIDTH 1\nHEIGHT 1\n"
      "POINTS 1\nDATA binary\n" +
          LittleEndian(std::uint64_t{7}, 1.f, 2.f, 3.f, std::int64_t{-9})));
  ASSERT_EQ(cloud.points.size(), 1u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
}

TEST(ReadPointCloud, KeepsThePrecisionOfCoordinatesFarFromTheOrigin) {
  const TempFolder folder;
  const auto write = [&](double x) {
    return folder.Write("a.ply",
                        "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty double "
                        "x\nproperty double y\nproperty double z\nelement face 5\nend_header\n" +
                            LittleEndian(x, 0., 0., x + 0.001, 0., 0.));
  };
  std::optional<Eigen::Vector3d> origin;
  PointCloud far = ReadPointCloud(write(5e6 + 3), &origin);
  EXPECT_EQ(*origin, Eigen::Vector3d(5e6 + 3, 0, 0));
  EXPECT_EQ(far.points[0].x(), 0);
  EXPECT_NEAR(far.points[1].x(), 0.001, 1e-8);
  EXPECT_EQ(CountFaces(folder / "a.ply"), 5u);
  far.origin = *origin;
  WritePly(far, folder / "b.ply");
  EXPECT_EQ(ReadPointCloud(folder / "b.ply", &origin).points, far.points);
  origin.reset();
  EXPECT_EQ(ReadPointCloud(write(3), &origin).points[0], Eigen::Vector3f(3, 0, 0));
  EXPECT_EQ(*origin, Eigen::Vector3d(0, 0, 0));
}

}  // namespace
}  // namespace surfit::testing
