// Fuzz targets of recordings by phones and other devices. The tests make their seeds themselves.
#include <cstdlib>

#include "fuzz/targets.h"
#include "io/images/image_files.h"
#include "io/matroska/azure_camera.h"
#include "io/matroska/matroska_file.h"
#include "io/phones/mp4_samples.h"
#include "io/sequences/raw_frames.h"
#include "surfit/io/camera_files.h"
#include "testing/exr_writer.h"
#include "testing/mkv_writer.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

constexpr int kPhoneFrames = 2;

void ReadPhone(const std::string& folder, const char* format) {
  SequenceOptions options = OptionsOf(folder);
  options.format = format;
  try {
    ReadDevicePoses(options);
  } catch (const InputError&) {  // poses are optional
  }
  ReadAll(OpenSequence(options).get());
}

void ReadImuOf(const std::string& folder) { ReadImu(OptionsOf(folder), "tum"); }

constexpr char kConfidence[] = "confidence/";

// Depth and confidence of two frames, with these names.
void WriteDepths(const TempFolder& folder, const std::string& depth, const std::string& confidence,
                 const std::vector<std::string>& names) {
  for (int i = 0; i < kPhoneFrames; ++i) {
    WriteDepth(folder / (depth + names[i] + ".png"), NumberedDepth(i));
    WriteConfidence(folder / (confidence + names[i] + ".png"),
                    Image<std::uint8_t>(32, 24, static_cast<std::uint8_t>(1 + i)));
  }
}

std::string StrayOdometry() {
  return "timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy\n"
         "8.5, 000000, 0.1, 0.2, 0.3, 0, 0, 0, 1, 1860, 1830, 945, 705\n"
         "8.6, 000001, 0.2, 0.2, 0.3, 0, 0.6, 0, 0.8, 1865, 1830, 950, 705\n";
}
std::string StrayMatrix() { return "1860, 0.0, 945\n0.0, 1830, 705\n0.0, 0.0, 1.0"; }
void StrayFolder(const TempFolder& folder) {
  folder.Write("odometry.csv", StrayOdometry());
  folder.Write("camera_matrix.csv", StrayMatrix());
  WriteDepths(folder, "depth/", kConfidence, {"000000", "000001"});
}

// The camera matrix is read only without intrinsics of each frame.
void OldStrayFolder(const TempFolder& folder) {
  StrayFolder(folder);
  folder.Write("odometry.csv",
               "timestamp, frame, x, y, z, qx, qy, qz, qw\n"
               "8.5, 000000, 0.1, 0.2, 0.3, 0, 0, 0, 1\n"
               "8.6, 000001, 0.2, 0.2, 0.3, 0, 0.6, 0, 0.8\n");
}

std::string Pincam() { return "32 24 31 30 15.5 11.5\n"; }
std::string ArkitPoses() {
  return "8.5 0.1 -0.2 0.3 1 2 3\n8.6 0.1 -0.25 0.3 1.5 2 3\n8.7 0.1 -0.25 0.3 1.5 2 3\n";
}
void ArkitFolder(const TempFolder& folder) {
  WriteDepths(folder, "lowres_depth/", kConfidence, {"42_8.500", "42_8.600"});
  folder.Write("lowres_wide_intrinsics/42_8.500.pincam", Pincam());
  folder.Write("lowres_wide_intrinsics/42_8.600.pincam", Pincam());
  folder.Write("lowres_wide.traj", ArkitPoses());
}

std::string PolycamCamera() {
  return R"({"fx": 62, "fy": 61, "cx": 31.5, "cy": 23.5, "width": 64, "height": 48,)"
         R"( "blur_score": 31.2, "t_00": 1, "t_01": 0, "t_02": 0, "t_03": 0.5, "t_10": 0,)"
         R"( "t_11": 1, "t_12": 0, "t_13": 0.25, "t_20": 0, "t_21": 0, "t_22": 1, "t_23": 1})";
}
void PolycamFolder(const TempFolder& folder) {
  WriteDepths(folder, "keyframes/depth/", "keyframes/confidence/", {"8500000", "8600000"});
  for (const char* name : {"8500000", "8600000"})
    folder.Write(std::string("keyframes/cameras/") + name + ".json", PolycamCamera());
}

std::string ExrSeed() {
  Image<float> depth_m(32, 24);
  for (std::size_t i = 0; i < depth_m.size(); ++i)
    depth_m[i] = 1.f + 0.01f * static_cast<float>(i % 32);
  return ExrFile(depth_m);
}

// The same scan lines, compressed by OpenCV.
std::string CompressedExrSeed() {
  std::vector<unsigned char> bytes;
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  try {
    cv::imencode(".exr", cv::Mat(24, 32, CV_32FC1, cv::Scalar(1.5)), bytes);
  } catch (const cv::Exception&) {
    return ExrSeed();  // OpenCV without OpenEXR
  }
  return {bytes.begin(), bytes.end()};
}

std::string Record3dMetadata() {
  return R"({"w": 32, "h": 24, "fps": 30, "K": [31, 0, 0, 0, 30, 0, 15.5, 11.5, 1],)"
         R"( "poses": [[0, 0, 0, 1, 0.1, 0.2, 0.3], [0, 0.6, 0, 0.8, 0.1, 0.2, 0.4]],)"
         R"( "initPose": [0, 0, 0, 1, 0, 0, 0], "perFrameIntrinsicCoeffs":)"
         R"( [[31, 30, 15.5, 11.5], [31.5, 30, 15.5, 11.5]], "frameTimestamps": [8.5, 8.6]})";
}
void Record3dFolder(const TempFolder& folder) {
  for (int i = 0; i < kPhoneFrames; ++i) {
    folder.Write(Format("depth/%d.exr", i), ExrSeed());
    folder.Write(Format("rgb/%d.jpg", i), EncodeJpeg(NumberedColor(i), 90));
  }
}

std::string NerfstudioTransforms() {
  const auto frame = [](int i) {
    return Format(R"({"file_path": "images/%d.png", )", i) +
           Format(R"("depth_file_path": "depth/%d.png", )", i) +
           R"("fl_x": 31, "fl_y": 30, "cx": 15.5, "cy": 11.5, "w": 32, "h": 24,)"
           R"( "transform_matrix": [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]})";
  };
  return R"({"camera_model": "OPENCV", "k1": 0.01, "k2": 0, "p1": 0, "p2": 0,)"
         R"( "applied_scale": 0.5, "depth_unit_scale_factor": 0.001, "frames": [)" +
         frame(0) + ", " + frame(1) + "]}";
}
void NerfstudioFolder(const TempFolder& folder) {
  WriteDepths(folder, "depth/", kConfidence, {"0", "1"});
  for (int i = 0; i < kPhoneFrames; ++i)
    WriteColor(folder / Format("images/%d.png", i), NumberedColor(i));
}

std::string KinectCamera(const char* location, int width, int height) {
  return std::string(
             R"({"Intrinsics": {"ModelParameterCount": 14, "ModelParameters": [0.51, 0.5,)") +
         R"( 0.49, 0.49, 0.4, 0.06, 0.004, 0.77, 0.14, 0.02, 0, 0, 0.00006, -0.0001],)"
         R"( "ModelType": "CALIBRATION_LensDistortionModelBrownConrady"}, "Location": ")" +
         location + R"(", "MetricRadius": 1.7, "Rt": {"Rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1],)" +
         Format(R"( "Translation": [-0.03, 0, 0]}, "SensorHeight": %d, )", height) +
         Format(R"("SensorWidth": %d})", width);
}
std::string KinectCalibration() {
  return R"({"CalibrationInformation": {"Cameras": [)" +
         KinectCamera("CALIBRATION_CameraLocationD0", 1024, 1024) + ", " +
         KinectCamera("CALIBRATION_CameraLocationPV0", 4096, 3072) +
         R"(], "InertialSensors": []}})";
}
// A frame without valid images, because the structure of the file is fuzzed.
std::string KinectFile() {
  MkvWriter writer;
  const int depth = writer.AddTrack("DEPTH", 320, 288, "b16g");
  const int color = writer.AddTrack("COLOR", 32, 24, "MJPG");
  writer.AddTag("K4A_DEPTH_MODE", "NFOV_2X2BINNED");
  for (const std::uint64_t time_us : {0, 33333}) {
    writer.BeginCluster(time_us);
    writer.AddFrame(depth, time_us, "depth", /*in_group=*/time_us > 0);
    writer.AddFrame(color, time_us + 1000, "color");
  }
  writer.AddAttachment("calibration.json", KinectCalibration());
  return writer.File();
}
void ReadKinect(const std::string& folder) {
  const std::string path = folder + "/file.mkv";
  ReadMatroska(BinaryFile(path));
  try {
    ReadAll(OpenSequence(OptionsOf(path)).get());
  } catch (const InputError&) {  // the images are invalid
  }
}
void ReadKinectCalibration(const std::string& folder) {
  const AzureCalibration calibration = ParseAzureCalibration(
      ReadBytes(folder + "/calibration.json"), {320, 288}, {1280, 720}, "calibration.json");
  AzureUndistorter(calibration.depth).Undistorted(Image<std::uint16_t>(320, 288));
}

std::string Box(const std::string& type, const std::string& content) {
  const auto size = static_cast<std::uint32_t>(8 + content.size());
  std::string bytes;
  for (int i = 3; i >= 0; --i) bytes += static_cast<char>(size >> (8 * i));
  return bytes + type + content;
}
std::string Big(std::initializer_list<std::uint32_t> numbers) {
  std::string bytes;
  for (const std::uint32_t number : numbers) {
    for (int i = 3; i >= 0; --i) bytes += static_cast<char>(number >> (8 * i));
  }
  return bytes;
}
// Header of a video with three frames. The edit list hides the first frame.
std::string VideoHeader() {
  const std::string handler = Box("hdlr", Big({0, 0}) + "vide" + std::string(13, '\0'));
  const std::string table =
      Box("stbl", Box("stts", Big({0, 1, 3, 20})) + Box("ctts", Big({0, 1, 3, 0})) +
                      Box("stsz", Big({0, 0, 3, 10, 10, 10})));
  const std::string media =
      Box("mdia", Box("mdhd", Big({0, 0, 0, 600, 60, 0})) + handler + Box("minf", table));
  const std::string edits = Box("edts", Box("elst", Big({0, 1, 40, 20, 0x10000})));
  return Box("ftyp", "isom" + Big({512}) + "isom") +
         Box("moov", Box("mvhd", Big({0, 0, 0, 600, 60}) + std::string(80, '\0')) +
                         Box("trak", Box("tkhd", std::string(84, '\0')) + edits + media));
}

std::string NumpyArray() {
  std::string head = "{'descr': '<f4', 'fortran_order': False, 'shape': (24, 32), }";
  head.resize(117, ' ');
  head += '\n';
  std::string file = std::string("\x93NUMPY\x01\x00", 8) +
                     LittleEndian(static_cast<std::uint16_t>(head.size())) + head;
  for (int i = 0; i < 24 * 32; ++i) file += LittleEndian(1.5f);
  return file;
}

std::vector<FuzzTarget> PhoneTargets() {
  return {
      {"stray_odometry",
       "odometry.csv",
       StrayFolder,
       [](const std::string& f) { ReadPhone(f, "stray_scanner"); },
       {StrayOdometry()}},
      {"stray_camera",
       "camera_matrix.csv",
       OldStrayFolder,
       [](const std::string& f) { ReadPhone(f, "stray_scanner"); },
       {StrayMatrix()}},
      {"video_header",
       "file.mp4",
       [](const TempFolder&) {},
       [](const std::string& f) { ReadMp4Samples(f + "/file.mp4"); },
       {VideoHeader()}},
      {"arkit_camera",
       "lowres_wide_intrinsics/42_8.500.pincam",
       ArkitFolder,
       [](const std::string& f) { ReadPhone(f, "arkit_scenes"); },
       {Pincam()}},
      {"arkit_poses",
       "lowres_wide.traj",
       ArkitFolder,
       [](const std::string& f) { ReadPhone(f, "arkit_scenes"); },
       {ArkitPoses()}},
      {"polycam_camera",
       "keyframes/cameras/8500000.json",
       PolycamFolder,
       [](const std::string& f) { ReadPhone(f, "polycam"); },
       {PolycamCamera()}},
      {"record3d_metadata",
       "metadata.json",
       Record3dFolder,
       [](const std::string& f) { ReadPhone(f, "record3d"); },
       {Record3dMetadata()}},
      {"nerfstudio",
       "transforms.json",
       NerfstudioFolder,
       [](const std::string& f) { ReadPhone(f, "nerfstudio"); },
       {NerfstudioTransforms()}},
  };
}

}  // namespace

std::vector<FuzzTarget> DeviceTargets() {
  std::vector<FuzzTarget> targets = PhoneTargets();
  const auto nothing = [](const TempFolder&) {};
  const std::vector<FuzzTarget> others = {
      {"matroska", "file.mkv", nothing, ReadKinect, {KinectFile()}},
      {"matroska_calibration",
       "calibration.json",
       nothing,
       ReadKinectCalibration,
       {KinectCalibration()}},
      {"open_exr",
       "file.exr",
       nothing,
       [](const std::string& f) { ReadDepthImage(f + "/file.exr"); },
       {ExrSeed(), CompressedExrSeed()}},
      {"numpy_array",
       "file.npy",
       nothing,
       [](const std::string& f) { ReadDepthImage(f + "/file.npy"); },
       {NumpyArray()}},
      {"imu_stray",
       "imu.csv",
       nothing,
       ReadImuOf,
       {"timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n"
        "258528.5, -9.5, 0.25, 0.5, 0.125, -0.25, 1\n258528.75, -9, 0, 0, 0, 0, 0\n"}},
      {"imu_euroc",
       "imu0/data.csv",
       nothing,
       ReadImuOf,
       {"#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
        "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
        "1403636579758555392,-0.125,0.25,0.5,8.5,-0.5,-3\r\n"
        "1403636579763555584,0,0,0,8,0,0\r\n"}},
      {"imu_tum",
       "accelerometer.txt",
       nothing,
       ReadImuOf,
       {"# accelerometer data\n# timestamp ax ay az\n1.5 0.25 8.5 -4\n1.75 0 8 0\n"}},
  };
  targets.insert(targets.end(), others.begin(), others.end());
  return targets;
}

}  // namespace surfit::testing
