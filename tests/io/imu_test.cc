// Tests of the readers of inertial sensors.
#include <gmock/gmock.h>

#include <filesystem>

#include "io/bag_fixture.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/sequence.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ImuFilesTest : public ::testing::Test {
 protected:
  std::optional<ImuRecording> Read(const std::string& format = "tum") {
    options_.path = folder_.path();
    return ReadImu(options_, format);
  }

  TempFolder folder_;
  SequenceOptions options_;
};

TEST_F(ImuFilesTest, ReadsStrayScanner) {
  folder_.Write("imu.csv",
                "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n"
                "258528.5, -9.5, 0.25, 0.5, 0.125, -0.25, 1\n"
                "258528.75, -9, 0, 0, 0, 0, 0\n");
  const auto imu = Read();
  ASSERT_TRUE(imu);
  ASSERT_EQ(imu->samples.size(), 2u);
  EXPECT_EQ(imu->samples[0].stamp_s, 258528.5);
  EXPECT_EQ(imu->samples[0].accel_m_per_s2, Vector3d(9.5, -0.25, -0.5));
  EXPECT_EQ(imu->samples[0].gyro_rad_per_s, Vector3d(0.125, -0.25, 1));
  EXPECT_TRUE(imu->has_gyro);
  EXPECT_LT(imu->calibration.rotation_sigma_rad, 0.1);
  // The phone is held in landscape orientation: x of its sensor, which is up here, is -y of the
  // camera, which points up.
  EXPECT_LT(
      (imu->calibration.camera_from_imu.rotation * Vector3d(1, 0, 0) - Vector3d(0, -1, 0)).norm(),
      1e-12);
}

TEST_F(ImuFilesTest, ReadsEuroc) {
  std::filesystem::create_directories(folder_.path() + "/imu0");
  folder_.Write("imu0/data.csv",
                "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
                "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
                "1403636579758555392,-0.125,0.25,0.5,8.5,-0.5,-3\r\n"
                "1403636579763555584,0,0,0,8,0,0\r\n");
  const auto imu = Read();
  ASSERT_TRUE(imu);
  ASSERT_EQ(imu->samples.size(), 2u);
  EXPECT_NEAR(imu->samples[0].stamp_s, 1403636579.758555392, 1e-6);
  EXPECT_EQ(imu->samples[0].gyro_rad_per_s, Vector3d(-0.125, 0.25, 0.5));
  EXPECT_EQ(imu->samples[0].accel_m_per_s2, Vector3d(8.5, -0.5, -3));
  EXPECT_TRUE(std::isinf(imu->calibration.rotation_sigma_rad));
}

TEST_F(ImuFilesTest, ReadsAccelerometerOfTumWithoutGyroscope) {
  folder_.Write("accelerometer.txt",
                "# accelerometer data\n# timestamp ax ay az\n1.5 0.25 8.5 -4\n1.75 0 8 0\n");
  const auto imu = Read();
  ASSERT_TRUE(imu);
  EXPECT_FALSE(imu->has_gyro);
  ASSERT_EQ(imu->samples.size(), 2u);
  EXPECT_EQ(imu->samples[0].accel_m_per_s2, Vector3d(0.25, 8.5, -4));
}

TEST_F(ImuFilesTest, IsAbsentWithoutFileAndIfSwitchedOff) {
  EXPECT_FALSE(Read());
  folder_.Write("accelerometer.txt", "1.5 0.25 8.5 -4\n");
  EXPECT_TRUE(Read());
  options_.imu = false;
  EXPECT_FALSE(Read());
}

TEST_F(ImuFilesTest, CountsSamplesThatAreNotLater) {
  folder_.Write("accelerometer.txt", "1 0 8 0\n2 0 8 0\n2 0 8 0\n1.5 0 8 0\n3 0 8 0\n");
  const auto imu = Read();
  EXPECT_EQ(imu->samples.size(), 3u);
  EXPECT_EQ(imu->dropped_samples, 2);
}

TEST_F(ImuFilesTest, RejectsUnknownHeader) {
  folder_.Write("imu.csv", "time,gx,gy,gz,ax,ay,az\n1,0,0,0,0,0,9.8\n");
  ExpectInputError([&] { Read(); },
                   AllOf(HasSubstr("imu.csv:1"), HasSubstr("time,gx"), HasSubstr("EuRoC")));
}

TEST_F(ImuFilesTest, RejectsMissingColumnAndWordThatIsNoNumber) {
  folder_.Write("accelerometer.txt", "1 0 8 0\n2 0 8\n");
  ExpectInputError([&] { Read(); },
                   AllOf(HasSubstr("accelerometer.txt:2"), HasSubstr("3 columns")));
  folder_.Write("accelerometer.txt", "1 0 8 0\n2 0 8 nan\n");
  ExpectInputError([&] { Read(); }, AllOf(HasSubstr("accelerometer.txt:2"), HasSubstr("nan")));
}

TEST_F(ImuFilesTest, FileWithoutMeasurementsIsNotUsed) {
  folder_.Write("accelerometer.txt", "# no measurement\n");
  EXPECT_FALSE(Read());
}

TEST_F(ImuFilesTest, CameraFileReplacesCalibration) {
  folder_.Write("accelerometer.txt", "1 0 8 0\n");
  ImuCalibration truth;
  truth.camera_from_imu =
      Rigid3d(QuaternionExp<double>(Vector3d(0.5, -1, 0.25)), {0.01, 0.02, 0.03});
  truth.time_offset_s = 0.0125;
  truth.time_offset_sigma_s = 0.001;
  truth.rotation_sigma_rad = 0.002;
  truth.noise.gyro_density = 0.0007;
  WriteCameraYaml(CameraPreset("tum_fr1"), folder_.path() + "/camera.yaml", {}, &truth);
  const ImuCalibration found = Read()->calibration;
  EXPECT_THAT(found.camera_from_imu, RigidNear(truth.camera_from_imu, 1e-12, 1e-12));
  EXPECT_EQ(found.time_offset_s, 0.0125);
  EXPECT_EQ(found.time_offset_sigma_s, 0.001);
  EXPECT_EQ(found.rotation_sigma_rad, 0.002);
  EXPECT_EQ(found.noise.gyro_density, 0.0007);
  EXPECT_NO_THROW(ReadCameraYaml(folder_.path() + "/camera.yaml"));
}

TEST_F(ImuFilesTest, RejectsInvalidCalibration) {
  const std::string camera =
      "depth_camera: {width: 4, height: 3, fx: 4, fy: 4, cx: 2, cy: 1}\n"
      "depth_units_per_metre: 1000\n";
  const auto reads = [&](const std::string& imu) {
    const std::string path = folder_.Write("camera.yaml", camera + "imu: {" + imu + "}\n");
    return [path] { ReadImuCalibration(path, {}); };
  };
  EXPECT_NO_THROW(reads("time_offset_s: 0.5")());
  ExpectInputError(reads("time_offset_s: 2"), HasSubstr("time_offset_s is 2"));
  ExpectInputError(reads("gyro_density: -1"), HasSubstr("gyro_density"));
  ExpectInputError(reads("rotation_sigma_rad: -1"), HasSubstr("rotation_sigma_rad is -1"));
  ExpectInputError(reads("gyro: 1"), HasSubstr("'gyro' is not a known key"));
}

// sensor_msgs/Imu.
std::string RosImu(double stamp_s, const Vector3d& gyro, const Vector3d& accel) {
  std::string bytes = RosHeader(stamp_s, "imu_frame");
  for (int i = 0; i < 4 + 9; ++i) bytes += LittleEndian(double{7});
  bytes += LittleEndian(gyro.x(), gyro.y(), gyro.z());
  for (int i = 0; i < 9; ++i) bytes += LittleEndian(double{8});
  bytes += LittleEndian(accel.x(), accel.y(), accel.z());
  for (int i = 0; i < 9; ++i) bytes += LittleEndian(double{9});
  return bytes;
}

class BagImuTest : public BagTest {
 protected:
  void AddImu(const std::string& topic, double stamp_s, const Vector3d& gyro,
              const Vector3d& accel) {
    bag_.Add(topic, "sensor_msgs/Imu", stamp_s, RosImu(stamp_s, gyro, accel));
  }
  std::optional<ImuRecording> Read() {
    options_.path = folder_.Write("a.bag", bag_.File());
    return ReadImu(options_, "bag");
  }
};

TEST_F(BagImuTest, ReadsSingleTopic) {
  AddDepth();
  EXPECT_FALSE(Read());
  AddImu("/imu", 5, {1, 2, 3}, {4, 5, 6});
  AddImu("/imu", 5.25, {-1, -2, -3}, {-4, -5, -6});
  const auto imu = Read();
  ASSERT_TRUE(imu);
  ASSERT_EQ(imu->samples.size(), 2u);
  EXPECT_NEAR(imu->samples[1].stamp_s, 5.25, 1e-9);
  EXPECT_EQ(imu->samples[0].gyro_rad_per_s, Vector3d(1, 2, 3));
  EXPECT_EQ(imu->samples[1].accel_m_per_s2, Vector3d(-4, -5, -6));
}

TEST_F(BagImuTest, InterpolatesAccelerometerOfSeparateTopic) {
  AddDepth();
  for (int i = 0; i < 3; ++i)
    AddImu("/camera/gyro/sample", 5 + 0.03125 * i, {1. * i, 0, 0}, Vector3d::Zero());
  AddImu("/camera/accel/sample", 5.03125 - 0.0078125, Vector3d::Zero(), {0, 8, 0});
  AddImu("/camera/accel/sample", 5.03125 + 0.0234375, Vector3d::Zero(), {0, 12, 0});
  const auto imu = Read();
  ASSERT_TRUE(imu);
  ASSERT_EQ(imu->samples.size(), 1u);
  EXPECT_EQ(imu->dropped_samples, 2);
  EXPECT_EQ(imu->samples[0].gyro_rad_per_s, Vector3d(1, 0, 0));
  EXPECT_NEAR(imu->samples[0].accel_m_per_s2.y(), 9, 1e-6);
}

TEST_F(BagImuTest, RejectsSeveralTopicsAndInvalidNumbers) {
  AddDepth();
  AddImu("/imu", 5, Vector3d::Zero(), Vector3d::Zero());
  AddImu("/imu_of_base", 5, Vector3d::Zero(), Vector3d::Zero());
  ExpectInputError([&] { Read(); }, HasSubstr("has the Imu topics /imu, /imu_of_base"));
  bag_ = {};
  AddDepth();
  AddImu("/imu", 5, {0, std::nan(""), 0}, Vector3d::Zero());
  ExpectInputError([&] { Read(); }, HasSubstr("/imu has a measurement that is not a number"));
}

}  // namespace
}  // namespace surfit::testing
