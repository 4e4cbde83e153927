#include "fuzz/targets.h"

#include <gflags/gflags.h>
#include <glog/logging.h>

#include "apps/evaluate/view_evaluation.h"
#include "common/command_line.h"
#include "common/recorded_flags.h"
#include "io/files/places_file.h"
#include "io/images/image_files.h"
#include "output/report/report_data.h"
#include "run/results/tracking_dump.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/g2o.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/run/slam_run.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

constexpr int kWidth = 32, kHeight = 24;

void Nothing(const TempFolder&) {}

void Camera(const TempFolder& folder) { folder.Write("file.klg.yaml", SmallCameraYaml()); }

void TumFolder(const TempFolder& folder) { WriteTumSequence(folder, 2); }

void TumFolderWithoutColor(const TempFolder& folder) {
  TumFolder(folder);
  std::filesystem::rename(folder / "rgb", folder / "elsewhere");
}

void TumFolderWithConfidence(const TempFolder& folder) {
  TumFolder(folder);
  for (int i = 0; i < 2; ++i) {
    WriteConfidence(folder / Format("confidence/%03d.png", i),
                    Image<std::uint8_t>(kWidth, kHeight, static_cast<std::uint8_t>(i)));
  }
}

void SevenScenesFolder(const TempFolder& folder) {
  WriteColor(folder / "frame-000000.color.png", NumberedColor(0));
  WriteDepth(folder / "frame-000000.depth.png", NumberedDepth(0));
  folder.Write("camera.yaml", SmallCameraYaml());
}

void RedwoodFolder(const TempFolder& folder) {
  WriteColor(folder / "color/0.png", NumberedColor(0));
  WriteDepth(folder / "depth/0.png", NumberedDepth(0));
  folder.Write("camera_intrinsic.json",
               R"({"width": 32, "height": 24,)"
               R"( "intrinsic_matrix": [31, 0, 0, 0, 30, 0, 15.5, 11.5, 1]})");
}

void ReplicaFolder(const TempFolder& folder) {
  WriteColor(folder / "results/frame000000.jpg", NumberedColor(0));
  WriteDepth(folder / "results/depth000000.png", NumberedDepth(0));
  folder.Write("traj.txt", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
  folder.Write("cam_params.json",
               R"({"camera": {"w": 32, "h": 24, "fx": 31, "fy": 30, "cx": 15.5, "cy": 11.5,)"
               R"( "scale": 1000}})");
}

std::vector<Surfel> FewSurfels() {
  std::vector<Surfel> surfels(3);
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    surfels[i].position_in_world = {0.1f * static_cast<float>(i), 0, 1};
    surfels[i].normal_in_world = {0, 0, -1};
    surfels[i].radius_m = 0.05f;
    surfels[i].confidence = 1;
  }
  return surfels;
}

// Result folder of a run over the TUM folder `sequence`.
void RunFolder(const TempFolder& folder) {
  const TempFolder images;
  TumFolder(images);
  std::filesystem::rename(images.path(), folder / "sequence");
  SurfelMap map;
  map.Append(FewSurfels());
  WriteSurfelPly(map, folder / "map.ply");
  folder.Write("frames.csv", "frame,stamp_s\n0,5.003\n1,5.103\n");
  folder.Write("views/0.jpg", EncodeJpeg(NumberedColor(0), 90));
  folder.Write("summary.json", R"({"options": {"downsample": "1"}})");
  folder.Write("poses.json", R"({"poses": [[0, 5.003, 0, 0, 0, 0, 0, 0, 1]],)"
                             R"( "views": [{"files": {"input_color": "views/0.jpg"}}]})");
}

void DumpFolder(const TempFolder& folder) {
  PointCloud cloud;
  cloud.points.resize(kWidth * kHeight, {0.f, 0.f, 1.f});
  cloud.normals.resize(kWidth * kHeight, {0.f, 0.f, -1.f});
  WritePly(cloud, folder / "source.ply");
  WritePly(cloud, folder / "target.ply");
}

std::string FileIn(const std::string& folder) { return folder + "/file"; }

void ReadSequence(const std::string& path) { ReadAll(OpenSequence(OptionsOf(path)).get()); }

void ReadSequenceOf(const std::string& path, const char* format) {
  SequenceOptions options = OptionsOf(path);
  options.format = format;
  ReadAll(OpenSequence(options).get());
}

struct SlamFlags {
  SlamRunOptions usual, options;
  tools::Flags flags{TableOf(&options)};
};

SlamFlags& TheSlamFlags() {
  static auto* const flags = new SlamFlags;
  return *flags;
}

void ReadFlags(const std::string& folder) {
  SlamFlags& slam = TheSlamFlags();
  slam.options = slam.usual;
  const gflags::FlagSaver saver;
  for (const std::string& argument : tools::ExpandFlagFiles({"--flagfile=" + FileIn(folder)})) {
    const std::size_t equals = std::min(argument.find('='), argument.size() - 1);
    const std::string name = argument.substr(0, equals), value = argument.substr(equals + 1);
    gflags::SetCommandLineOption(name.substr(std::min<std::size_t>(2, name.size())).c_str(),
                                 value.c_str());
  }
  slam.flags.Apply();
  slam.flags.Check();
}

void ReadRecordedFlags(const std::string& folder) {
  SlamFlags& slam = TheSlamFlags();
  slam.options = slam.usual;
  slam.options.output = folder;
  const gflags::FlagSaver saver;
  tools::ApplyRecordedFlags(folder, TableOf(&slam.options.sequence), {});
  slam.flags.Apply();
  slam.flags.Check();
}

void JudgeViews(const std::string& folder) {
  ViewEvaluationOptions options;
  options.run = folder;
  options.sequence.path = folder + "/sequence";
  options.pictures = 1;
  options.threads = 1;
  EvaluateViews(options, [](int) {});
}

// Targets that read a sequence: name, file in the folder, other files of the folder, reader.
std::vector<FuzzTarget> SequenceTargets() {
  return {
      {"klg", "file.klg", Camera, [](const std::string& f) { ReadSequence(f + "/file.klg"); }},
      {"sens", "file.sens", Nothing, [](const std::string& f) { ReadSequence(f + "/file.sens"); }},
      {"bag", "file.bag", Nothing, [](const std::string& f) { ReadSequence(f + "/file.bag"); }},
      {"db3", "file.db3", Nothing, [](const std::string& f) { ReadSequence(f + "/file.db3"); }},
      {"mcap", "file.mcap", Nothing, [](const std::string& f) { ReadSequence(f + "/file.mcap"); }},
      {"camera_yaml", "camera.yaml", TumFolder, ReadSequence},
      {"tum_associations", "associations.txt", TumFolder, ReadSequence},
      {"tum_color_list", "rgb.txt", TumFolder, ReadSequence},
      {"tum_depth_list", "depth.txt", TumFolder, ReadSequence},
      {"confidence_list", "confidence.txt", TumFolderWithConfidence, ReadSequence},
      {"text_link", "rgb", TumFolderWithoutColor, ReadSequence},
      {"seven_scenes_pose", "frame-000000.pose.txt", SevenScenesFolder, ReadSequence},
      {"redwood_poses", "trajectory.log", RedwoodFolder, ReadSequence},
      {"redwood_camera", "camera_intrinsic.json", RedwoodFolder, ReadSequence},
      {"replica_poses", "traj.txt", ReplicaFolder, ReadSequence},
      {"replica_camera", "cam_params.json", ReplicaFolder,
       [](const std::string& f) { ReadSequenceOf(f, "replica"); }},
      {"depth_image", "file", Nothing, [](const std::string& f) { ReadDepthImage(FileIn(f)); }},
      {"color_image", "file", Nothing, [](const std::string& f) { ReadColorImage(FileIn(f)); }},
      {"confidence_image", "file", Nothing,
       [](const std::string& f) { ReadConfidenceImage(FileIn(f)); }},
  };
}

std::vector<FuzzTarget> ResultTargets() {
  return {
      {"ply", "file", Nothing, [](const std::string& f) { ReadPly(FileIn(f)); }},
      {"pcd", "file", Nothing, [](const std::string& f) { ReadPointCloud(FileIn(f)); }},
      {"surfel_ply", "file", Nothing, [](const std::string& f) { ReadSurfelPly(FileIn(f)); }},
      {"g2o", "file", Nothing, [](const std::string& f) { ReadG2o(FileIn(f)); }},
      {"trajectory", "file", Nothing, [](const std::string& f) { ReadTumTrajectory(FileIn(f)); }},
      {"stamps", "file", Nothing, [](const std::string& f) { ReadTumStamps(FileIn(f)); }},
      {"flags", "file", Nothing, ReadFlags},
      {"summary", "summary.json", RunFolder, ReadRecordedFlags},
      {"reported_poses", "poses.json", RunFolder, [](const std::string& f) { ReadRun(f, 2); }},
      {"judged_poses", "poses.json", RunFolder, JudgeViews},
      {"tracking_dump", "frame.json", DumpFolder,
       [](const std::string& f) { ReadTrackingDump(f); }},
      {"places", "file", Nothing, [](const std::string& f) { ReadPlaces(FileIn(f)); }},
  };
}

}  // namespace

const std::vector<FuzzTarget>& FuzzTargets() {
  static const auto* const targets = [] {
    auto* const all = new std::vector<FuzzTarget>(SequenceTargets());
    for (FuzzTarget& target : ResultTargets()) all->push_back(std::move(target));
    for (FuzzTarget& target : DeviceTargets()) all->push_back(std::move(target));
    return all;
  }();
  return *targets;
}

FuzzedReader::FuzzedReader(const FuzzTarget& target) : target_(target) {
  FLAGS_minloglevel = google::GLOG_FATAL;
  target.prepare(folder_);
}

bool FuzzedReader::Takes(const std::string& bytes) const {
  folder_.Write(target_.file, bytes);
  try {
    target_.read(folder_.path());
  } catch (const InputError&) {
    return false;
  }
  return true;
}

}  // namespace surfit::testing
