// Converts sequences, maps, trajectories and runs to formats of other programs.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <vector>

#include "apps/export/export_run.h"
#include "common/console.h"
#include "common/recorded_flags.h"
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

constexpr const char* kCameraYaml = "camera_yaml";

struct Options {
  ExportOptions run_export;  // with the sequence and the output of all conversions
  std::string to, map, estimate;

  void Visit(OptionVisitor& v) {
    v.AddPart(run_export, "run_export", "export of a run", WithoutFlags({"to"}));
    std::vector<std::string> formats = ExportFormatNames();
    formats.insert(formats.begin(), "");
    formats.emplace_back(kCameraYaml);
    v.Group("export");
    v.Add(to, "to",
          "format for the results of --run; camera_yaml: with --sequence, write its camera as a "
          "template, by default to camera.yaml in the folder of the sequence",
          OneOf(formats), Everyday());
    v.Group("input");
    v.Add(map, SharedOption("map", Everyday()));
    v.Add(estimate, SharedOption("estimate", Everyday()));
  }
};

const SequenceOptions& SequenceOf(const Options& options) { return options.run_export.sequence; }
const std::string& OutputOf(const Options& options) { return options.run_export.output; }

bool EndsWith(const std::string& path, const std::string& ending) {
  return path.size() > ending.size() &&
         path.compare(path.size() - ending.size(), ending.size(), ending) == 0;
}

void RequireEnding(const std::string& output, bool holds, const char* endings) {
  if (!holds) throw InputError(Concat("--output is ", output, ", must end in ", endings));
}

void ConvertSequence(const Options& options) {
  constexpr int kFramesAhead = 4;
  RequireEnding(OutputOf(options), EndsWith(OutputOf(options), ".klg"), ".klg");
  const auto source = ReadAhead(OpenSequence(SequenceOf(options)), kFramesAhead);
  const KlgSummary summary = WriteKlg(source.get(), OutputOf(options));
  std::printf("%s: %d frames, %d skipped, %lld depths above 65.534 m removed\n",
              OutputOf(options).c_str(), summary.frames_written, summary.frames_skipped,
              static_cast<long long>(summary.depths_out_of_range));
  if (source->info().low_confidence_ratio)
    std::printf("depth of low confidence is written as missing; .klg has no confidence images\n");
}

// Path of the camera.yaml that is used for the sequence by default.
std::string OwnCameraFile(const std::string& sequence) {
  return std::filesystem::is_directory(sequence) ? sequence + "/camera.yaml" : sequence + ".yaml";
}

void MakeCameraYaml(const Options& options) {
  const bool own = OutputOf(options).empty();
  const std::string path = own ? OwnCameraFile(SequenceOf(options).path) : OutputOf(options);
  RequireEnding(path, EndsWith(path, ".yaml"), ".yaml");
  if (own && std::filesystem::exists(path)) {
    throw InputError(path +
                     " exists and is the camera of the sequence: set another file with --output");
  }
  const auto source = OpenSequence(SequenceOf(options));
  const SequenceInfo& info = source->info();
  WriteCameraYaml(info.camera, path, ReadDepthField(SequenceOf(options), info.format));
  std::printf(
      "%s: %s%s\n", path.c_str(), info.assumed.c_str(),
      info.camera_is_guessed ? "; replace the guessed values by the values of your camera" : "");
}

void ConvertCloud(const Options& options) {
  const bool pcd = EndsWith(OutputOf(options), ".pcd");
  RequireEnding(OutputOf(options), pcd || EndsWith(OutputOf(options), ".ply"), ".pcd or .ply");
  const PointCloud cloud = ReadPointCloudAboutOrigin(options.map);
  if (pcd) {
    WritePcd(cloud, OutputOf(options));
  } else {
    WritePly(cloud, OutputOf(options));
  }
  std::printf("%s: %zu points\n", OutputOf(options).c_str(), cloud.points.size());
}

// Number of frames without a pose, by gaps between timestamps of a constant frame rate.
long CountMissing(const Trajectory& trajectory) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    steps_s.push_back(trajectory[i].stamp_s - trajectory[i - 1].stamp_s);
  if (steps_s.empty()) return 0;
  std::vector<double> sorted_s = steps_s;
  const auto middle = sorted_s.begin() + static_cast<std::ptrdiff_t>(sorted_s.size() / 2);
  std::nth_element(sorted_s.begin(), middle, sorted_s.end());
  if (!(*middle > 0)) return 0;
  long missing = 0;
  for (const double step_s : steps_s) missing += std::max(0L, std::lround(step_s / *middle) - 1);
  return missing;
}

void ConvertTrajectory(const Options& options) {
  const Trajectory trajectory = ReadTumTrajectory(options.estimate);
  WriteKittiTrajectory(trajectory, OutputOf(options));
  std::printf("%s: %zu poses\n", OutputOf(options).c_str(), trajectory.size());
  const long missing = CountMissing(trajectory);
  if (missing == 0) return;
  std::fprintf(stderr,
               "warning: about %ld frames have no pose: KITTI poses have no timestamps, so that "
               "line numbers are not frame numbers\n",
               missing);
}

int ConvertRun(const ExportOptions& options) {
  RequireFlag("to", options.to);
  RequireFlag("output", options.output);
  ProgressLine line;
  const ExportSummary summary =
      ExportRun(options, [&](const std::string& text) { line.Show(text, false); });
  line.Show("done", true);
  for (const std::string& warning : summary.warnings) {
    std::cerr << "warning: " << warning << '\n';
  }
  for (const std::string& message : summary.messages) {
    std::printf("%s: %s\n", options.output.c_str(), message.c_str());
  }
  return kDone;
}

// The calibrated camera is in poses.json of the run, so the frames are read with the input camera.
void Prepare(Options* options) {
  const ExportOptions& run_export = options->run_export;
  if (run_export.run.empty()) return;
  ApplyRecordedFlags(run_export.run, TableOf(&options->run_export.sequence), {},
                     RecordedCamera::kGiven);
}

int Run(const Options& options) {
  const bool has_run = !options.run_export.run.empty();
  const bool has_sequence = !SequenceOf(options).path.empty() && !has_run;
  const int inputs = has_sequence + !options.map.empty() + !options.estimate.empty() + has_run;
  if (inputs != 1) {
    throw InputError(
        Concat(inputs, " of --sequence, --map, --estimate and --run are set, must be 1"));
  }
  if (options.to == kCameraYaml) {
    if (!has_sequence) throw InputError("--to=camera_yaml requires --sequence");
    MakeCameraYaml(options);
    return kDone;
  }
  if (has_run) {
    ExportOptions run_export = options.run_export;
    run_export.to = options.to;
    return ConvertRun(run_export);
  }
  if (!options.to.empty()) throw InputError(Concat("--to=", options.to, " requires --run"));
  RequireFlag("output", OutputOf(options));
  if (has_sequence) ConvertSequence(options);
  if (!options.map.empty()) ConvertCloud(options);
  if (!options.estimate.empty()) ConvertTrajectory(options);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "converts a sequence to .klg (with its camera as .klg.yaml), a "
      "map or cloud to PCD or PLY, or a trajectory to KITTI poses; "
      "writes the camera of a sequence as camera.yaml; exports poses "
      "and map of a run for COLMAP, nerfstudio, Gaussian splatting or ROS",
      surfit::tools::Run, surfit::tools::Prepare);
}
