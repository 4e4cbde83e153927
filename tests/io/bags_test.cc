#include <glog/logging.h>

#include <cmath>
#include <limits>

#include "io/bag_fixture.h"
#include "surfit/core/options.h"
#include "surfit/io/sequence.h"
#include "testing/largest_allocation.h"
#include "testing/matchers.h"
#include "testing/ros_bag.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

// Bags written by rosbag, @mcap/core and SQLite: see tests/tools/bags/write_bags.py.
class ForeignBag : public ::testing::TestWithParam<const char*> {};

void ExpectWrittenFrames(const SequenceOptions& options) {
  const auto source = OpenSequence(options);
  const SequenceInfo& info = source->info();
  EXPECT_TRUE(info.warnings.empty());
  EXPECT_TRUE(info.camera.color_is_registered);
  EXPECT_THAT(info.camera_from, Names("CameraInfo"));
  EXPECT_EQ(info.pinhole.fx, 31);
  EXPECT_EQ(info.pinhole.fy, 30);
  EXPECT_EQ(info.pinhole.cx, 15.5);
  EXPECT_EQ(info.pinhole.cy, 11.5);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  const double depth_s[] = {5.003, 5.103, 5.203}, color_s[] = {5., 5.1, 5.2};  // as decimal text
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_EQ(results[i].frame->stamp_s, depth_s[i]);
    EXPECT_EQ(results[i].frame->color_stamp_s, color_s[i]);
    EXPECT_EQ(results[i].frame->color, NumberedColor(i));
    const auto raw = NumberedDepth(i);
    for (std::size_t k = 0; k < raw.size(); ++k)
      ASSERT_FLOAT_EQ(results[i].frame->depth_m[k], 0.001f * raw[k]);
  }
}

TEST_P(ForeignBag, HasTheWrittenFrames) {
  ExpectWrittenFrames(OptionsOf(std::string(SURFIT_CORPUS_DIR) + "/" + GetParam()));
}

std::string NameOfBag(const ::testing::TestParamInfo<const char*>& info) {
  std::string name = info.param;
  name[name.find('.')] = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Files, ForeignBag,
                         ::testing::Values("room.bag", "room_lz4.bag", "room_bz2.bag", "room.mcap",
                                           "room_lz4.mcap", "room_zstd.mcap", "room_plain.mcap",
                                           "room.db3"),
                         NameOfBag);

// A ROS 2 bag is a folder. The recorder splits long recordings into several files.
TEST(BagFolder, ReadsTheFramesOfAllFiles) {
  const TempFolder folder;
  folder.Write("metadata.yaml", "rosbag2_bagfile_information:\n");
  folder.Write("bag_0.db3", ReadBytes(std::string(SURFIT_CORPUS_DIR) + "/room.db3"));
  ExpectWrittenFrames(Options(folder));
  // Two copies of one file.
  const std::string mcap = ReadBytes(std::string(SURFIT_CORPUS_DIR) + "/room_plain.mcap");
  std::filesystem::remove(folder / "bag_0.db3");
  folder.Write("bag_0.mcap", mcap);
  folder.Write("bag_1.mcap", mcap);
  const auto source = OpenSequence(Options(folder));
  EXPECT_EQ(source->info().format, "mcap");
  EXPECT_EQ(source->info().frame_count, 6);
}

TEST_F(BagTest, ReadsEveryEncodingOfColor) {
  const std::string rgb = RawBytes(NumberedColor(1));
  std::string bgr, rgba, bgra;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    const std::string r(1, rgb[i]), g(1, rgb[i + 1]), b(1, rgb[i + 2]);
    bgr += b + g + r;
    rgba += r + g + b + "x";
    bgra += b + g + r + "x";
  }
  const std::pair<const char*, std::string> encodings[] = {{"rgb8", rgb},   {"bgr8", bgr},
                                                           {"8UC3", bgr},   {"rgba8", rgba},
                                                           {"bgra8", bgra}, {"8UC4", bgra}};
  for (const auto& [encoding, data] : encodings) {
    bag_ = {};
    AddDepth();
    AddInfos();
    AddOne(kColor, {encoding, data});
    EXPECT_EQ(First().color, NumberedColor(1)) << encoding;
  }
  bag_ = {};
  AddDepth();
  AddInfos();
  AddOne(kColor, {"mono8", std::string(32 * 24, '\x07')});
  EXPECT_EQ(First().color(3, 4), (Rgb8{7, 7, 7}));
  bag_ = {};
  AddDepth();
  AddInfos();
  AddCompressed(std::string(kColor) + "/compressed", "rgb8; png compressed bgr8",
                EncodedBytes(NumberedColor(2), ".png"));
  EXPECT_EQ(First().color, NumberedColor(2));
}

std::string PngBytes(const Image<std::uint16_t>& raw) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png",
               cv::Mat(raw.height(), raw.width(), CV_16UC1, const_cast<std::uint16_t*>(raw.data())),
               bytes);
  return {bytes.begin(), bytes.end()};
}

TEST_F(BagTest, ReadsEveryEncodingOfDepth) {
  AddInfos();
  Image<float> metres(32, 24);
  for (std::size_t i = 0; i < metres.size(); ++i) metres[i] = 1 + 0.01f * static_cast<float>(i % 7);
  metres[5] = std::numeric_limits<float>::quiet_NaN();
  const RosBagEncoder empty = bag_;
  AddOne(kDepth, {"32FC1", RawBytes(metres)});
  RgbdFrame frame = First();
  EXPECT_EQ(frame.depth_m[8], metres[8]);
  EXPECT_EQ(frame.depth_m[5], 0);
  EXPECT_TRUE(frame.color.empty());

  bag_ = empty;
  std::string padded;
  for (int v = 0; v < 24; ++v) padded += RawBytes(NumberedDepth(1)).substr(64 * v, 64) + "padding!";
  AddOne(kDepth, {"mono16", padded, 32, 24, 72});
  EXPECT_FLOAT_EQ(First().depth_m[37], 0.001f * NumberedDepth(1)[37]);

  bag_ = empty;
  AddCompressed(std::string(kDepth) + "/compressedDepth", "16UC1; compressedDepth png",
                std::string(12, '\0') + PngBytes(NumberedDepth(2)));
  EXPECT_FLOAT_EQ(First().depth_m[37], 0.001f * NumberedDepth(2)[37]);

  // compressed_depth_image_transport: z = a / (count - b).
  bag_ = empty;
  Image<std::uint16_t> counts(32, 24, 500);
  counts[3] = 0;
  AddCompressed(std::string(kDepth) + "/compressedDepth", "32FC1; compressedDepth png",
                LittleEndian(0, 1200.f, -100.f) + PngBytes(counts));
  frame = First();
  EXPECT_FLOAT_EQ(frame.depth_m[4], 2);
  EXPECT_EQ(frame.depth_m[3], 0);
}

TEST_F(BagTest, PrefersRawImagesAndColor) {
  AddDepth();
  AddInfos();
  AddOne("/camera/ir/image_raw", {"mono16", std::string(2 * 32 * 24, '\x01')});
  AddOne("/camera/left/image_raw", {"mono8", std::string(32 * 24, '\x01')});
  AddCompressed(std::string(kColor) + "/compressed", "rgb8; jpeg compressed bgr8",
                EncodedBytes(NumberedColor(9), ".jpg"));
  AddColor();
  EXPECT_EQ(First().color, NumberedColor(0));
}

TEST_F(BagTest, RejectsMissingAndAmbiguousTopics) {
  AddInfos();
  ExpectError(Names("a.bag", "/camera/depth/camera_info", "sensor_msgs/CameraInfo"));
  AddColor();
  ExpectError(Names("a.bag", "/camera/rgb/image_raw", "rgb8", "depth_topic", "--topics"));
  AddDepth();
  AddDepth("/left/depth/image");
  ExpectError(Names("a.bag", 2, "/camera/depth/image_raw", "/left/depth/image", "16UC1",
                    "depth_topic", "--topics"));
  options_.depth_topic = "/right/depth/image";
  ExpectError(Names("depth_topic", "/right/depth/image"));
  options_.depth_topic = kDepth;
  EXPECT_EQ(Open()->info().frame_count, 3);
  AddColor("/left/rgb/image");
  ExpectError(Names(2, "/camera/rgb/image_raw", "/left/rgb/image", "color_topic", "--topics"));
  options_.color_topic = "none";
  EXPECT_TRUE(First().color.empty());
  EXPECT_EQ(FlagValues(options_).at("topics"), std::string(kDepth) + ",none");
  options_.color_topic = kColor;
  EXPECT_EQ(First().color, NumberedColor(0));
  options_.depth_topic = kColor;
  ExpectError(Names("/camera/rgb/image_raw", 0, "rgb8", "16UC1"));
}

// As the recorder of RealSense writes the unit of a D405: 0.1 mm.
TEST_F(BagTest, ReadsTheDepthUnitOfTheSensor) {
  const std::string depth = "/device_0/sensor_0/Depth_0/image/data";
  AddDepth(depth);
  AddInfo("/device_0/sensor_0/Depth_0/info/camera_info");
  bag_.Add("/device_0/sensor_1/option/Depth_Units/value", "std_msgs/Float32", 5,
           LittleEndian(0.002f));
  EXPECT_EQ(Open()->info().camera.depth_units_per_metre, 1000);
  bag_.Add("/device_0/sensor_0/option/Depth_Units/value", "std_msgs/Float32", 5,
           LittleEndian(0.0001f));
  const SequenceInfo opened = Open()->info();
  EXPECT_DOUBLE_EQ(opened.camera.depth_units_per_metre, 10000);
  EXPECT_THAT(opened.warnings, ::testing::Each(::testing::Not(::testing::HasSubstr("likely"))));
}

TEST_F(BagTest, ReadsBigEndianDepth) {
  Image<std::uint16_t> swapped = NumberedDepth(0);
  for (auto& count : swapped) count = static_cast<std::uint16_t>(count << 8 | count >> 8);
  RosImage image{"16UC1", RawBytes(swapped)};
  image.is_big_endian = 1;
  AddOne(kDepth, image);
  AddInfo("/camera/depth/camera_info");
  EXPECT_FLOAT_EQ(First().depth_m[0], 0.001f * NumberedDepth(0)[0]);
}

TEST_F(BagTest, UsesRecordingTimesForMissingStamps) {
  AddInfos();
  for (int i = 0; i < 3; ++i)
    bag_.Add(kDepth, kImage, 7 + i,
             RosImage{"16UC1", RawBytes(NumberedDepth(i))}.Bytes(0, kOptical));
  const auto source = Open();
  EXPECT_THAT(source->info().warnings, ElementsAre(Names("a.bag", kDepth)));
  EXPECT_EQ(source->Next()->stamp_s, 7);
  AddColor();
  ExpectError(Names("/camera/rgb/image_raw", 0.02));
}

TEST_F(BagTest, LeavesOutSingleMessagesWithoutStamp) {
  AddInfos();
  for (int i = 0; i < 6; ++i) {
    const double stamp_s = i == 0 || i == 3 ? 0 : 7 + 0.1 * i;
    bag_.Add(kDepth, kImage, 7 + 0.1 * i,
             RosImage{"16UC1", RawBytes(NumberedDepth(i))}.Bytes(stamp_s, kOptical));
  }
  const auto source = Open();
  EXPECT_THAT(source->info().warnings, ElementsAre(Names(2, 6, kDepth)));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 4u);
  EXPECT_DOUBLE_EQ(results[0].stamp_s, 7.1);
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 7.5);
}

// The clock of the second part starts at the time of the first part, as in a bag in a loop. Or the
// clock starts before the first part.
TEST_F(BagTest, KeepsTheOrderOfTwoTakes) {
  for (const double lag_s : {0, -20}) {
    bag_ = {};
    AddInfos();
    for (int i = 0; i < 20; ++i) {
      const double stamp_s = 107 + 0.1 * (i % 10) + (i < 10 ? 0 : lag_s);
      bag_.Add(kDepth, kImage, 7 + 0.1 * i,
               RosImage{"16UC1", RawBytes(NumberedDepth(i))}.Bytes(stamp_s, kOptical));
      bag_.Add(kColor, kImage, 7 + 0.1 * i,
               RosImage{"rgb8", RawBytes(NumberedColor(i))}.Bytes(stamp_s, kOptical));
    }
    const auto source = Open();
    EXPECT_THAT(source->info().warnings,
                ElementsAre(HasSubstr("timestamps go back 1 times, first at frame 10")));
    const auto results = ReadAll(source.get());
    ASSERT_EQ(results.size(), 20u);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(results[i].frame->color(0, 0).r, i);
  }
}

TEST_F(BagTest, ReadsADamagedFileUpToTheDamage) {
  AddInfos();
  AddDepth();
  std::string bytes = bag_.File();
  options_.path = folder_.Write("a.bag", bytes.substr(0, bytes.size() - 1));
  auto source = OpenSequence(options_);
  EXPECT_EQ(source->info().frame_count, 2);
  EXPECT_THAT(source->info().warnings, ElementsAre(Names("a.bag")));
  bag_.AddChunk("lz4", 1000, "no frame of lz4");
  AddColor();
  source = Open();
  EXPECT_EQ(source->info().frame_count, 3);
  EXPECT_THAT(source->info().warnings, ElementsAre(Names(1000)));
  bag_.AddChunk("rar", 1000, "");
  ExpectError(Names("rar", "lz4", "zstd", "bz2"));
}

TEST_F(BagTest, RejectsOtherFilesByName) {
  for (const char* name : {"x.bag", "x.mcap", "x.db3"}) {
    options_.path = folder_.Write(name, "something else, of more bytes than a first line has");
    ExpectInputError([&] { OpenSequence(options_); }, Names(name));
  }
  options_.path = folder_.Write("x.bag", bag_.File("rosbag/AesCbcEncryptor"));
  ExpectInputError([&] { OpenSequence(options_); }, AllOf(Names("x.bag"), HasSubstr("encrypt")));
}

TEST_F(BagTest, RejectsHugeSizesBeforeAllocation) {
  AddInfos();
  AddDepth();
  bag_.AddChunk("lz4", 0xFFFFFFFF, std::string(100, 'x'));
  bag_.AddChunk("bz2", 200 << 20, std::string(100, 'x'));
  ResetLargestAllocation();
  EXPECT_EQ(Open()->info().warnings.size(), 2u);
  EXPECT_LT(LargestAllocation(), 1u << 20);
  bag_ = {};
  AddInfos();
  AddOne(kDepth, {"16UC1", std::string(100, 'x'), 16384, 16384, 32768});
  ResetLargestAllocation();
  ExpectError(Names(100, 32768, 16384));
  EXPECT_LT(LargestAllocation(), 1u << 20);
}

}  // namespace
}  // namespace surfit::testing
