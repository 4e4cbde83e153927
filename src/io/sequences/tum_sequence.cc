#include <algorithm>
#include <filesystem>

#include "io/files/text.h"
#include "io/sequences/folder.h"
#include "io/sequences/recording.h"
#include "surfit/core/error.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/trajectory_files.h"

namespace surfit {
namespace {

// Rejects files outside the folder, because lists may be untrusted.
StampedFile ParseStampedFile(const TextRow& row, int column, const std::string& folder) {
  const std::string& name = row.columns[column + 1];
  const std::filesystem::path normal = std::filesystem::path(name).lexically_normal();
  ThrowIf(normal.is_absolute() || *normal.begin() == "..", row.place, ": '", name,
          "' is outside the folder of the sequence");
  return {ParseNumber(row.columns[column], row.place), FollowTextLink(folder, name)};
}

void RequireColumns(const TextRow& row, std::size_t count, const char* meaning) {
  ThrowIf(row.columns.size() != count, row.place, " has ", row.columns.size(),
          " columns, must have ", count, ": ", meaning);
}

std::vector<double> Stamps(const std::vector<StampedFile>& files) {
  std::vector<double> stamps_s;
  stamps_s.reserve(files.size());
  for (const StampedFile& file : files) stamps_s.push_back(file.stamp_s);
  return stamps_s;
}

std::vector<FrameFiles> PairByTime(const std::string& folder, int* unpaired_images) {
  const auto depth = ReadStampedFiles(folder, "depth.txt");
  std::vector<FrameFiles> frames;
  if (!HasFile(folder + "/rgb.txt")) {
    for (const StampedFile& file : depth)
      frames.push_back({{file.stamp_s, file.stamp_s}, file.path, ""});
    return frames;
  }
  const auto color = ReadStampedFiles(folder, "rgb.txt");
  for (const auto [c, d] : MatchStamps(Stamps(color), Stamps(depth), kMaxBetweenImages_s))
    frames.push_back({{depth[d].stamp_s, color[c].stamp_s}, depth[d].path, color[c].path});
  ThrowIf(frames.empty() && !depth.empty() && !color.empty(), folder,
          ": no timestamp in rgb.txt is within ", kMaxBetweenImages_s,
          " s of a timestamp in depth.txt");
  *unpaired_images = static_cast<int>(color.size() + depth.size() - 2 * frames.size());
  return frames;
}

// Reads associations.txt. The colour columns are first (TUM) or second (ICL-NUIM). Depth files have
// "depth" in their path.
std::vector<FrameFiles> ReadAssociations(const std::string& folder) {
  std::vector<FrameFiles> frames;
  ForEachTextRow(folder + "/associations.txt", [&](const TextRow& row) {
    RequireColumns(row, 4, "timestamp and file of colour, timestamp and file of depth");
    const bool depth_first = row.columns[1].find("depth") != std::string::npos;
    const StampedFile depth = ParseStampedFile(row, depth_first ? 0 : 2, folder);
    const StampedFile color = ParseStampedFile(row, depth_first ? 2 : 0, folder);
    frames.push_back({{depth.stamp_s, color.stamp_s}, depth.path, color.path});
  });
  return frames;
}

Trajectory ReadGroundTruth(const std::string& folder) {
  if (HasFile(folder + "/groundtruth.txt")) return ReadTumTrajectory(folder + "/groundtruth.txt");
  for (const std::string& name : NamesIn(folder)) {
    const std::string path = Concat(folder, "/", name);
    if (EndsWith(name, ".gt.freiburg") && HasFile(path)) return ReadTumTrajectory(path);
  }
  return {};
}

}  // namespace

std::vector<StampedFile> ReadStampedFiles(const std::string& folder, const std::string& name) {
  std::vector<StampedFile> files;
  ForEachTextRow(Concat(folder, "/", name), [&](const TextRow& row) {
    RequireColumns(row, 2, "timestamp and file");
    files.push_back(ParseStampedFile(row, 0, folder));
  });
  std::stable_sort(files.begin(), files.end(), [](const StampedFile& a, const StampedFile& b) {
    return a.stamp_s < b.stamp_s;
  });
  return files;
}

SequenceFiles ListTumSequence(const std::string& folder) {
  SequenceFiles files;
  files.frames = HasFile(folder + "/associations.txt") ? ReadAssociations(folder)
                                                       : PairByTime(folder, &files.unpaired_images);
  std::stable_sort(
      files.frames.begin(), files.frames.end(),
      [](const FrameFiles& a, const FrameFiles& b) { return a.stamps.depth_s < b.stamps.depth_s; });
  files.has_clock = true;
  files.ground_truth = ReadGroundTruth(folder);
  return files;
}

SequenceFiles ListIclNuimSequence(const std::string& folder) {
  if (HasFile(folder + "/associations.txt") || HasFile(folder + "/depth.txt"))
    return ListTumSequence(folder);
  return {ListNumberedFrames(folder + "/depth", folder + "/rgb"), ReadGroundTruth(folder),
          /*has_clock=*/false};
}

}  // namespace surfit
