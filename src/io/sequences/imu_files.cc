#include <glog/logging.h>

#include <fstream>
#include <limits>
#include <utility>

#include "io/bags/bag_imu.h"
#include "io/files/text.h"
#include "io/sequences/folder.h"
#include "io/sequences/sequence_camera.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

// Text form of inertial measurements.
struct ImuForm {
  std::size_t columns = 7;
  double units_per_second = 1;  // of the time
  int gyro = 1, accel = 4;      // first columns; gyro 0: none
  double accel_sign = 1;        // -1: the negative of the specific force
};

std::string FirstLine(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

bool IsStray(const std::string& header) {
  return header.find("a_x") != std::string::npos && header.find("alpha_x") != std::string::npos;
}

ImuForm FormOf(const std::string& path) {
  if (EndsWith(path, ".txt")) return {4, 1, 0, 1, 1};
  const std::string header = FirstLine(path);
  if (IsStray(header)) return {7, 1, 4, 1, -1};
  if (header.find("w_RS_S_x") != std::string::npos) return {7, 1e9, 1, 4, 1};
  throw InputError(path, ":1: the header is '", header.substr(0, 80),
                   "', must be that of Stray Scanner (timestamp, a_x, ..., alpha_z) or EuRoC "
                   "(#timestamp [ns],w_RS_S_x ...)");
}

Eigen::Vector3d VectorAt(const TextRow& row, int first) {
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i) vector[i] = ParseNumber(row.columns[first + i], row.place);
  return vector;
}

std::vector<ImuSample> ReadImuText(const std::string& path) {
  const ImuForm form = FormOf(path);
  std::vector<ImuSample> samples;
  ForEachTextRow(path, [&](const TextRow& row) {
    if (row.columns[0] == "timestamp") return;
    ThrowIf(row.columns.size() < form.columns, row.place, " has ", row.columns.size(),
            " columns, must have ", form.columns);
    ImuSample sample;
    sample.stamp_s = ParseNumber(row.columns[0], row.place) / form.units_per_second;
    if (form.gyro > 0) sample.gyro_rad_per_s = VectorAt(row, form.gyro);
    sample.accel_m_per_s2 = form.accel_sign * VectorAt(row, form.accel);
    samples.push_back(sample);
  });
  return samples;
}

ImuCalibration UnknownMounting() {
  ImuCalibration calibration;
  calibration.rotation_sigma_rad = std::numeric_limits<double>::infinity();
  calibration.time_offset_sigma_s = 0.03;
  return calibration;
}

// An iPhone in landscape orientation, as Stray Scanner records. The axes of the motion sensor are x
// right, y up, z out of the screen in portrait orientation. Depth images have the same clock. The
// phone removes most of both biases. Assumed: 0.1 degrees/s and 0.03 m/s^2 remain.
ImuCalibration PhoneMounting() {
  ImuCalibration calibration;
  Eigen::Matrix3d rotation;
  rotation << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  calibration.camera_from_imu = Rigid3d(rotation, Eigen::Vector3d::Zero());
  calibration.rotation_sigma_rad = 0.01;
  calibration.time_offset_sigma_s = 0.005;
  calibration.noise.gyro_bias_sigma = 0.002;
  calibration.noise.accel_bias_sigma = 0.03;
  return calibration;
}

std::optional<ImuRecording> ReadFolderImu(const std::string& folder) {
  for (const char* name : {"/imu.csv", "/imu/data.csv", "/imu0/data.csv", "/accelerometer.txt"}) {
    const std::string path = folder + name;
    if (!HasFile(path)) continue;
    ImuRecording imu;
    imu.samples = ReadImuText(path);
    imu.has_gyro = !EndsWith(path, ".txt");
    imu.calibration = IsStray(FirstLine(path)) ? PhoneMounting() : UnknownMounting();
    imu.read_from = path;
    return imu;
  }
  return std::nullopt;
}

// Removes samples that are not later than the sample before.
void KeepAscending(ImuRecording* imu) {
  std::vector<ImuSample> kept;
  for (const ImuSample& sample : imu->samples) {
    if (kept.empty() || sample.stamp_s > kept.back().stamp_s) kept.push_back(sample);
  }
  imu->dropped_samples += static_cast<int>(imu->samples.size() - kept.size());
  imu->samples = std::move(kept);
}

}  // namespace

std::optional<ImuRecording> ReadImu(const SequenceOptions& options, const std::string& format) {
  if (!options.imu || IsLive(options)) return std::nullopt;
  std::optional<ImuRecording> imu;
  if (IsBag(format)) {
    imu = ReadBagImu(options.path, format, IsFolder(options.path));
    if (imu) imu->calibration = UnknownMounting();
  } else if (IsFolder(options.path)) {
    imu = ReadFolderImu(options.path);
  }
  if (!imu) return std::nullopt;
  KeepAscending(&*imu);
  if (imu->samples.empty()) {
    LOG(WARNING) << imu->read_from << " has no inertial measurements, and is not used";
    return std::nullopt;
  }
  const std::string yaml = CameraFile(options, format);
  if (!yaml.empty()) imu->calibration = ReadImuCalibration(yaml, imu->calibration);
  if (imu->dropped_samples > 0) {
    LOG(WARNING) << imu->read_from << ": " << imu->dropped_samples
                 << " samples are not later than the sample before, and are not used";
  }
  return imu;
}

}  // namespace surfit
