// Converts sequences, maps and trajectories to what other programs read.

#include <gflags/gflags.h>

#include <cstdio>

#include "common/sequence_flags.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/io/kitti_trajectory.h"
#include "surfit/io/klg_writer.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/read_ahead.h"
#include "surfit/io/tum_trajectory.h"

namespace {

const surfit::SequenceOptions kSequence;
const surfit::KlgOptions kKlg;

}  // namespace

DEFINE_string(cloud, "", "instead of a sequence: a map or point cloud (PLY or PCD)");
DEFINE_string(trajectory, "", "instead of a sequence: a trajectory in TUM format");
DEFINE_string(output, "",
              "the file to write: .klg of a sequence; .pcd or .ply of a cloud; of a trajectory the "
              "poses in KITTI's format");
DEFINE_int32(first, kSequence.first, "index of the first frame to read");
DEFINE_int32(last, kSequence.last, "index of the last frame to read, inclusive; -1 = to the end");
DEFINE_int32(stride, kSequence.stride, "read every stride-th frame");
DEFINE_bool(compress_depth, kKlg.compress_depth, "whether .klg holds depth compressed, or raw");
DEFINE_int32(jpeg_quality, kKlg.jpeg_quality, "of colour in .klg, 1 to 100; 0 = raw");

DECLARE_string(sequence);

namespace surfit::tools {
namespace {

bool EndsWith(const std::string& path, const std::string& ending) {
  return path.size() > ending.size() &&
         path.compare(path.size() - ending.size(), ending.size(), ending) == 0;
}

void RequireEnding(bool holds, const char* endings) {
  if (!holds) throw InputError(Concat("--output is ", FLAGS_output, ", must end in ", endings));
}

void ConvertSequence() {
  constexpr int kFramesAhead = 4;
  RequireEnding(EndsWith(FLAGS_output, ".klg"), ".klg");
  SequenceOptions options = SequenceOptionsFromFlags();
  options.first = FLAGS_first;
  options.last = FLAGS_last;
  options.stride = FLAGS_stride;
  const auto source = ReadAhead(OpenSequence(options), kFramesAhead);
  const KlgSummary summary =
      WriteKlg(source.get(), FLAGS_output, {FLAGS_compress_depth, FLAGS_jpeg_quality});
  std::printf("%s: %d frames, %d skipped, %lld depths beyond 65.534 m left out\n",
              FLAGS_output.c_str(), summary.frames_written, summary.frames_skipped,
              static_cast<long long>(summary.depths_beyond));
}

void ConvertCloud() {
  const bool pcd = EndsWith(FLAGS_output, ".pcd");
  RequireEnding(pcd || EndsWith(FLAGS_output, ".ply"), ".pcd or .ply");
  const PointCloud cloud = ReadPointCloud(FLAGS_cloud);
  if (pcd) {
    WritePcd(cloud, FLAGS_output);
  } else {
    WritePly(cloud, FLAGS_output);
  }
  std::printf("%s: %zu points\n", FLAGS_output.c_str(), cloud.points.size());
}

void ConvertTrajectory() {
  const Trajectory trajectory = ReadTumTrajectory(FLAGS_trajectory);
  WriteKittiTrajectory(trajectory, FLAGS_output);
  std::printf("%s: %zu poses\n", FLAGS_output.c_str(), trajectory.size());
}

int Run() {
  RequireFlag("output", FLAGS_output);
  const int inputs = !FLAGS_sequence.empty() + !FLAGS_cloud.empty() + !FLAGS_trajectory.empty();
  if (inputs != 1)
    throw InputError(Concat(inputs, " of --sequence, --cloud and --trajectory are set, must be 1"));
  if (!FLAGS_sequence.empty()) ConvertSequence();
  if (!FLAGS_cloud.empty()) ConvertCloud();
  if (!FLAGS_trajectory.empty()) ConvertTrajectory();
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv,
                                 "converts a sequence to .klg (with its camera as .klg.yaml), a "
                                 "map or cloud to PCD or PLY, or "
                                 "a trajectory to KITTI's poses",
                                 surfit::tools::Run);
}
