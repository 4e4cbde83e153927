#include <map>

#include "io/folder.h"
#include "io/matrix_text.h"
#include "io/sequence_files.h"

namespace surfit {
namespace {

// Whether the name is frame-<number><ending>.
bool IsFrameFile(const std::string& name, const std::string& ending) {
  return name.compare(0, 6, "frame-") == 0 && EndsWith(name, ending) && NumberInName(name);
}

}  // namespace

SequenceFiles ListSevenScenesSequence(const std::string& folder, double frames_per_second) {
  std::map<long, std::string> stems;
  std::string color_ending;
  for (const std::string& name : NamesIn(folder)) {
    for (const char* ending : {".color.png", ".color.jpg", ".depth.png"}) {
      if (!IsFrameFile(name, ending)) continue;
      stems[*NumberInName(name)] = folder + "/" + name.substr(0, name.find('.'));
      if (std::string(ending) != ".depth.png") color_ending = ending;
    }
  }
  SequenceFiles files;
  for (const auto& [number, stem] : stems) {
    const double stamp_s = static_cast<double>(number) / frames_per_second;
    const std::string color_path = color_ending.empty() ? "" : stem + color_ending;
    files.frames.push_back({stamp_s, stem + ".depth.png", color_path});
    const std::string pose_path = stem + ".pose.txt";
    if (!IsFile(pose_path)) continue;
    const Rigid3d world_from_camera = ParseRigid(ReadTextRows(pose_path), 0, pose_path);
    files.ground_truth.push_back({stamp_s, world_from_camera});
  }
  return files;
}

}  // namespace surfit
