// SLAM over a sequence: use_slam SEQUENCE OUTPUT_FOLDER. The output folder must exist.
#include <cstdio>
#include <exception>
#include <string>

#include "surfit/core/parallel.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/slam/slam.h"

int main(int argc, char** argv) try {
  if (argc != 3) return std::puts("usage: use_slam SEQUENCE OUTPUT_FOLDER"), 1;
  const std::string output = argv[2];
  const surfit::ThreadLimit limit(2);
  surfit::SequenceOptions sequence;
  sequence.path = argv[1];
  const auto source = surfit::ReadAhead(surfit::OpenSequence(sequence), /*capacity=*/4);
  surfit::Slam slam(source->info().sensor(), surfit::SlamOptions(), surfit::Rigid3d());
  surfit::TumTrajectoryWriter trajectory(output + "/trajectory.txt");
  while (const auto result = source->Next()) {
    if (!result->frame) continue;  // unreadable frame: result->error has the reason
    const surfit::FrameReport report = slam.Process(*result->frame);
    std::printf("%d %s\n", report.index, surfit::ToString(report.state).c_str());
    if (report.state == surfit::FrameState::kLost) continue;
    trajectory.Append({report.stamp_s, report.world_from_camera});
  }
  surfit::WriteSurfelPly(slam.map(), output + "/map.ply");
  std::printf("%zu surfels\n", slam.map().size());
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
