// Converts sequences, maps and trajectories to formats of other programs.

#include <cstdio>
#include <filesystem>

#include "common/tool_main.h"
#include "core/shared_options.h"
#include "io/sequences/klg_writer.h"
#include "surfit/core/error.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"

namespace surfit::tools {
namespace {

struct Options {
  SequenceOptions sequence;
  std::string cloud, trajectory, output;
  bool make_camera_yaml = false;
  KlgOptions klg;

  void Visit(OptionVisitor& v) {
    v.AddPart(sequence, "sequence", "input sequence", OptionalPart());
    v.Group("input");
    v.Add(cloud, "cloud", "instead of a sequence: a map or point cloud (PLY or PCD)", Everyday());
    v.Add(trajectory, "trajectory", "instead of a sequence: a trajectory in TUM format",
          Everyday());
    v.Group("output");
    v.Add(output, SharedOption("output", Everyday()));
    v.Add(make_camera_yaml, "make_camera_yaml",
          "write the camera of the sequence to a camera.yaml, as a template; default of --output: "
          "camera.yaml in the folder of the sequence",
          Everyday());
    v.AddPart(klg, "klg", ".klg file");
  }
};

bool EndsWith(const std::string& path, const std::string& ending) {
  return path.size() > ending.size() &&
         path.compare(path.size() - ending.size(), ending.size(), ending) == 0;
}

void RequireEnding(const std::string& output, bool holds, const char* endings) {
  if (!holds) throw InputError(Concat("--output is ", output, ", must end in ", endings));
}

void ConvertSequence(const Options& options) {
  constexpr int kFramesAhead = 4;
  RequireEnding(options.output, EndsWith(options.output, ".klg"), ".klg");
  const auto source = ReadAhead(OpenSequence(options.sequence), kFramesAhead);
  const KlgSummary summary = WriteKlg(source.get(), options.output, options.klg);
  std::printf("%s: %d frames, %d skipped, %lld depths above 65.534 m removed\n",
              options.output.c_str(), summary.frames_written, summary.frames_skipped,
              static_cast<long long>(summary.depths_out_of_range));
  if (source->info().low_confidence_ratio)
    std::printf("depth of low confidence is written as missing; .klg has no confidence images\n");
}

// Path of the camera.yaml that is used for the sequence by default.
std::string OwnCameraFile(const std::string& sequence) {
  return std::filesystem::is_directory(sequence) ? sequence + "/camera.yaml" : sequence + ".yaml";
}

void MakeCameraYaml(const Options& options) {
  const bool own = options.output.empty();
  const std::string path = own ? OwnCameraFile(options.sequence.path) : options.output;
  RequireEnding(path, EndsWith(path, ".yaml"), ".yaml");
  if (own && std::filesystem::exists(path)) {
    throw InputError(path +
                     " exists and is the camera of the sequence: set another file with --output");
  }
  const auto source = OpenSequence(options.sequence);
  const SequenceInfo& info = source->info();
  WriteCameraYaml(info.camera, path, ReadDepthField(options.sequence, info.format));
  std::printf(
      "%s: %s%s\n", path.c_str(), info.assumed.c_str(),
      info.camera_is_guessed ? "; replace the guessed values by the values of your camera" : "");
}

void ConvertCloud(const Options& options) {
  const bool pcd = EndsWith(options.output, ".pcd");
  RequireEnding(options.output, pcd || EndsWith(options.output, ".ply"), ".pcd or .ply");
  const PointCloud cloud = ReadPointCloud(options.cloud);
  if (pcd) {
    WritePcd(cloud, options.output);
  } else {
    WritePly(cloud, options.output);
  }
  std::printf("%s: %zu points\n", options.output.c_str(), cloud.points.size());
}

void ConvertTrajectory(const Options& options) {
  const Trajectory trajectory = ReadTumTrajectory(options.trajectory);
  WriteKittiTrajectory(trajectory, options.output);
  std::printf("%s: %zu poses\n", options.output.c_str(), trajectory.size());
}

int Run(const Options& options) {
  const int inputs =
      !options.sequence.path.empty() + !options.cloud.empty() + !options.trajectory.empty();
  if (inputs != 1)
    throw InputError(Concat(inputs, " of --sequence, --cloud and --trajectory are set, must be 1"));
  if (options.make_camera_yaml && options.sequence.path.empty())
    throw InputError("--make_camera_yaml requires --sequence");
  if (options.make_camera_yaml) {
    MakeCameraYaml(options);
    return kDone;
  }
  RequireFlag("output", options.output);
  if (!options.sequence.path.empty()) ConvertSequence(options);
  if (!options.cloud.empty()) ConvertCloud(options);
  if (!options.trajectory.empty()) ConvertTrajectory(options);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv,
                                 "converts a sequence to .klg (with its camera as .klg.yaml), a "
                                 "map or cloud to PCD or PLY, or a trajectory to KITTI poses; "
                                 "writes the camera of a sequence as camera.yaml",
                                 surfit::tools::Run);
}
