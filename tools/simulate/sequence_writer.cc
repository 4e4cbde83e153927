#include "simulate/sequence_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>
#include <vector>

#include "io/images/image_files.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/trajectory_files.h"

namespace surfit::tools {
namespace {

namespace fs = std::filesystem;

// Marks a folder of this program, which the program may empty.
constexpr char kMark[] = "simulated_by_surfit.txt";

void MakeEmptyFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder)) throw InputError(Concat(folder, " cannot be created"));
  if (!fs::is_empty(folder)) {
    if (!fs::exists(folder + "/" + kMark)) {
      throw InputError(
          Concat(folder, " contains other files, must be empty, new or of an earlier simulation"));
    }
    for (const auto& entry : fs::directory_iterator(folder)) fs::remove_all(entry.path());
  }
  WriteFileAtomically(folder + "/" + kMark, [](std::ostream& out) {
    out << "The next simulation into this folder deletes all of its files.\n";
  });
}

template <typename T>
void WritePng(const Image<T>& image, const std::string& path) {
  const std::string bytes = EncodePng(image);
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  if (!file.flush()) throw InputError(Concat(path, " cannot be written"));
}

// Depths above the 16-bit range become 0 (missing).
Image<std::uint16_t> ToUnits(const Image<float>& depth_m, double units_per_metre) {
  Image<std::uint16_t> units(depth_m.width(), depth_m.height());
  std::transform(depth_m.begin(), depth_m.end(), units.begin(), [&](float depth) {
    const double value = std::round(depth * units_per_metre);
    return value <= std::numeric_limits<std::uint16_t>::max() ? static_cast<std::uint16_t>(value)
                                                              : std::uint16_t{0};
  });
  return units;
}

}  // namespace

SequenceWriter::SequenceWriter(const std::string& folder, SequenceLayout layout,
                               const RgbdCamera& camera, double latency_s, bool has_confidence,
                               const ImuCalibration* imu)
    : folder_(folder),
      layout_(layout),
      camera_(camera),
      latency_s_(latency_s),
      has_confidence_(has_confidence) {
  MakeEmptyFolder(folder);
  for (const std::string& kind : Kinds()) fs::create_directory(Concat(folder, "/", kind));
  const bool mirrored = layout == SequenceLayout::kIclNuim;
  WriteCameraYaml(mirrored ? Mirrored(camera) : camera, folder + "/camera.yaml", {}, imu);
}

std::vector<std::string> SequenceWriter::Kinds() const {
  if (has_confidence_) return {"rgb", "depth", "confidence"};
  return {"rgb", "depth"};
}

int SequenceWriter::LinkImages(const std::string& folder) const {
  int count = 0;
  for (const std::string& kind : Kinds()) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(fs::path(folder) / kind, error)) {
      fs::create_hard_link(entry.path(), fs::path(folder_) / kind / entry.path().filename(), error);
      if (error) break;
      ++count;
    }
    if (error) throw InputError(Concat(folder, "/", kind, " cannot be linked: ", error.message()));
  }
  return count;
}

double SequenceWriter::StampOf(int i, double stamp_s) const {
  return layout_ == SequenceLayout::kIclNuim ? i : stamp_s;
}

std::string SequenceWriter::NameOf(int i, double stamp_s) const {
  if (layout_ == SequenceLayout::kIclNuim) return std::to_string(i);
  return std::to_string(ImageStamp(stamp_s));  // six decimals
}

void SequenceWriter::WriteLists(const Trajectory& world_from_camera) const {
  const bool icl = layout_ == SequenceLayout::kIclNuim;
  Trajectory poses;
  std::string color_list = "# timestamp filename\n", depth_list = color_list;
  std::string confidence_list = color_list, pairs;
  for (std::size_t i = 0; i < world_from_camera.size(); ++i) {
    const StampedPose& pose = world_from_camera[i];
    const int frame = static_cast<int>(i);
    poses.push_back({StampOf(frame, pose.stamp_s),
                     icl ? Mirrored(pose.world_from_camera) : pose.world_from_camera});
    const std::string name = NameOf(frame, pose.stamp_s);
    const std::string color = Concat(name, " rgb/", name, ".png");
    const std::string depth = Concat(name, " depth/", name, ".png");
    color_list += color + "\n";
    depth_list += depth + "\n";
    confidence_list += Concat(name, " confidence/", name, ".png\n");
    pairs += icl ? Concat(depth, " ", color, "\n") : Concat(color, " ", depth, "\n");
  }
  const auto write = [&](const char* name, const std::string& text) {
    WriteFileAtomically(folder_ + "/" + name, [&](std::ostream& out) { out << text; });
  };
  write("associations.txt", pairs);
  if (has_confidence_) write("confidence.txt", confidence_list);
  WriteTumTrajectory(poses, folder_ + "/groundtruth.txt");
  if (icl) {
    WriteTumTrajectory(poses, folder_ + "/simulated.gt.freiburg");
  } else {
    write("rgb.txt", color_list);
    write("depth.txt", depth_list);
  }
}

void SequenceWriter::WriteTruth(const Trajectory& world_from_camera,
                                const SequenceTruth& truth) const {
  const bool mirrored = layout_ == SequenceLayout::kIclNuim;
  WriteCameraYaml(mirrored ? Mirrored(truth.camera) : truth.camera, folder_ + "/truth_camera.yaml",
                  mirrored ? Mirrored(truth.field) : truth.field);
  WriteFileAtomically(folder_ + "/truth_color.txt", [&](std::ostream& out) {
    out << "# image, middle of exposure and readout in the time of groundtruth.txt (s), exposure "
           "(s), readout (s), gains of red, green and blue\n"
        << std::setprecision(std::numeric_limits<double>::max_digits10);
    for (std::size_t i = 0; i < world_from_camera.size(); ++i) {
      const Eigen::Vector3f& gain = truth.gains[i];
      out << "rgb/" << NameOf(static_cast<int>(i), world_from_camera[i].stamp_s) << ".png "
          << truth.color_moments_s[i] << " " << truth.exposure_s << " " << truth.color_readout_s
          << " " << gain.x() << " " << gain.y() << " " << gain.z() << "\n";
    }
  });
}

void SequenceWriter::WriteImu(const std::string& name,
                              const std::vector<ImuSample>& samples) const {
  WriteFileAtomically(folder_ + "/" + name, [&](std::ostream& out) {
    out << "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
           "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
        << std::setprecision(std::numeric_limits<double>::max_digits10);
    for (const ImuSample& sample : samples) {
      out << std::llround(sample.stamp_s * 1e9);
      for (const Eigen::Vector3d& vector : {sample.gyro_rad_per_s, sample.accel_m_per_s2}) {
        for (int k = 0; k < 3; ++k) out << "," << vector[k];
      }
      out << "\n";
    }
  });
}

void SequenceWriter::WriteFrame(int i, double stamp_s, const Image<Rgb8>& color,
                                const Image<float>& depth_m,
                                const Image<std::uint8_t>& confidence) const {
  const std::string file = NameOf(i, stamp_s) + ".png";
  WritePng(color, folder_ + "/rgb/" + file);
  WritePng(ToUnits(depth_m, camera_.depth_units_per_metre), folder_ + "/depth/" + file);
  if (has_confidence_) WritePng(confidence, folder_ + "/confidence/" + file);
}

}  // namespace surfit::tools
