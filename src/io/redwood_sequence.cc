#include "io/folder.h"
#include "io/matrix_text.h"
#include "io/numbered_frames.h"
#include "io/sequence_files.h"

namespace surfit {
namespace {

// Blocks of one line of numbers, the first of which is the frame's, and a 4 x 4 pose.
Trajectory ReadLog(const std::string& path, double frames_per_second) {
  const auto rows = ReadTextRows(path);
  Trajectory poses;
  for (std::size_t i = 0; i < rows.size(); i += 5) {
    const double position = ParseNumber(rows[i].columns[0], rows[i].place);
    poses.push_back({position / frames_per_second, ParseRigid(rows, i + 1, path)});
  }
  return poses;
}

}  // namespace

SequenceFiles ListRedwoodSequence(const std::string& folder, double frames_per_second) {
  SequenceFiles files;
  files.frames = ListNumberedFrames(folder + "/depth", FindColorFolder(folder));
  for (std::size_t i = 0; i < files.frames.size(); ++i)
    files.frames[i].stamp_s = static_cast<double>(i) / frames_per_second;
  if (IsFile(folder + "/trajectory.log"))
    files.ground_truth = ReadLog(folder + "/trajectory.log", frames_per_second);
  return files;
}

}  // namespace surfit
