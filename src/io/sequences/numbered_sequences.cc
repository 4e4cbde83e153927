#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <set>
#include <utility>

#include "io/files/text.h"
#include "io/images/image_files.h"
#include "io/sequences/folder.h"
#include "io/sequences/recording.h"
#include "surfit/core/error.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/trajectory_files.h"

namespace surfit {
namespace {

FrameStamps BothAt(double stamp_s) { return {stamp_s, stamp_s}; }

// Images of a folder by number. If two images have the same number, calls `twice` with a message
// and keeps the image with the shorter name.
std::map<long, std::string> NumberedImages(const std::string& folder,
                                           const DuplicateCallback& twice) {
  std::map<long, std::string> images;
  for (const std::string& name : NamesIn(folder)) {
    const auto number = NumberInName(name);
    if (!number || !IsImageName(name)) continue;
    const auto [it, is_new] = images.emplace(*number, name);
    if (is_new) continue;
    twice(Concat(folder, ": ", it->second, " and ", name, " are both number ", *number,
                 ", must be one image per number"));
    if (name.size() < it->second.size()) it->second = name;
  }
  return images;
}

// Images of a folder by the timestamps in their names; empty unless all names are timestamps.
std::map<double, std::string> StampedImages(const std::string& folder) {
  std::map<double, std::string> images;
  for (const std::string& name : NamesIn(folder)) {
    if (!IsImageName(name)) continue;
    const auto stamp_s = StampInName(name);
    if (!stamp_s) return {};
    images[*stamp_s] = Concat(folder, "/", name);
  }
  return images;
}

std::vector<double> Stamps(const std::map<double, std::string>& images) {
  std::vector<double> stamps_s;
  stamps_s.reserve(images.size());
  for (const auto& [stamp_s, path] : images) stamps_s.push_back(stamp_s);
  return stamps_s;
}

// Pairs depth and colour images by timestamp. `color_folder` empty: frames without colour.
std::vector<FrameFiles> PairStamped(const std::map<double, std::string>& depth,
                                    const std::string& color_folder, int* unpaired_images) {
  std::vector<FrameFiles> frames;
  if (color_folder.empty()) {
    for (const auto& [stamp_s, path] : depth) frames.push_back({BothAt(stamp_s), path, ""});
    return frames;
  }
  const auto color = StampedImages(color_folder);
  const std::vector<double> color_s = Stamps(color), depth_s = Stamps(depth);
  for (const auto [c, d] : MatchStamps(color_s, depth_s, kMaxBetweenImages_s)) {
    frames.push_back({{depth_s[d], color_s[c]}, depth.at(depth_s[d]), color.at(color_s[c])});
  }
  *unpaired_images = static_cast<int>(color.size() + depth.size() - 2 * frames.size());
  if (!frames.empty()) return frames;
  throw InputError("no image name in ", color_folder, " is within ", kMaxBetweenImages_s,
                   " s of a depth image name (names are timestamps)");
}

// File name of the image with this number. A missing image gets the expected name: stem of the
// image in the other folder, extension of this folder.
std::string NameOf(long number, const std::map<long, std::string>& images,
                   const std::map<long, std::string>& others) {
  const auto it = images.find(number);
  if (it != images.end()) return it->second;
  const std::string& other = others.at(number);
  const std::string& some = images.empty() ? other : images.begin()->second;
  return other.substr(0, other.rfind('.')) + some.substr(some.rfind('.'));
}

// Reads blocks of five lines: the frame position (first number of its line) and a 4 x 4 pose.
Trajectory ReadLog(const std::string& path, double frames_per_second) {
  const auto rows = ReadTextRows(path);
  Trajectory poses;
  for (std::size_t i = 0; i < rows.size(); i += 5) {
    const double position = ParseNumber(rows[i].columns[0], rows[i].place);
    poses.push_back({position / frames_per_second, ParseRigid(rows, i + 1, path)});
  }
  return poses;
}

bool IsFrameFile(const std::string& name, const std::string& ending) {
  return name.compare(0, 6, "frame-") == 0 && EndsWith(name, ending) && NumberInName(name);
}

// Parses a line with a row-major 4 x 4 matrix.
Rigid3d ParseLine(const TextRow& row) {
  ThrowIf(row.columns.size() != 16, row.place, " has ", row.columns.size(),
          " columns, must have 16");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = ParseNumber(row.columns[i], row.place);
  return RigidFromMatrix(matrix, row.place);
}

}  // namespace

std::string FindColorFolder(const std::string& folder) {
  for (const char* name : {"/color", "/rgb", "/image"}) {
    if (IsFolder(folder + name)) return folder + name;
  }
  return "";
}

std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder) {
  return ListNumberedFrames(depth_folder, color_folder,
                            [](const std::string& error) { throw InputError(error); });
}

std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder,
                                           const DuplicateCallback& twice) {
  const auto depth = NumberedImages(depth_folder, twice);
  const auto color = color_folder.empty() ? depth : NumberedImages(color_folder, twice);
  std::map<long, FrameFiles> frames;
  for (const auto& [number, name] : color) frames[number];
  for (const auto& [number, name] : depth) frames[number];
  std::vector<FrameFiles> sorted;
  for (auto& [number, frame] : frames) {
    frame.stamps = BothAt(static_cast<double>(number));
    frame.depth_path = depth_folder + "/" + NameOf(number, depth, color);
    if (!color_folder.empty()) frame.color_path = color_folder + "/" + NameOf(number, color, depth);
    sorted.push_back(frame);
  }
  return sorted;
}

SequenceFiles ListRedwoodSequence(const std::string& folder, double frames_per_second) {
  SequenceFiles files;
  const auto stamped = StampedImages(folder + "/depth");
  if (!stamped.empty()) {
    files.frames = PairStamped(stamped, FindColorFolder(folder), &files.unpaired_images);
    files.has_clock = true;
    if (HasFile(folder + "/groundtruth.txt"))
      files.ground_truth = ReadTumTrajectory(folder + "/groundtruth.txt");
    return files;
  }
  files.frames = ListNumberedFrames(folder + "/depth", FindColorFolder(folder));
  for (std::size_t i = 0; i < files.frames.size(); ++i)
    files.frames[i].stamps = BothAt(static_cast<double>(i) / frames_per_second);
  if (HasFile(folder + "/trajectory.log"))
    files.ground_truth = ReadLog(folder + "/trajectory.log", frames_per_second);
  return files;
}

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
    files.frames.push_back({BothAt(stamp_s), stem + ".depth.png", color_path});
    const std::string pose_path = stem + ".pose.txt";
    if (!HasFile(pose_path)) continue;
    const Rigid3d world_from_camera = ParseRigid(ReadTextRows(pose_path), 0, pose_path);
    files.ground_truth.push_back({stamp_s, world_from_camera});
  }
  return files;
}

SequenceFiles ListReplicaSequence(const std::string& folder, double frames_per_second) {
  std::set<long> numbers;
  for (const std::string& name : NamesIn(folder + "/results")) {
    const auto number = NumberInName(name);
    const bool is_image = name.compare(0, 5, "frame") == 0 || name.compare(0, 5, "depth") == 0;
    if (number && is_image) numbers.insert(*number);
  }
  SequenceFiles files;
  for (const long number : numbers) {
    std::array<char, 30> digits;
    std::snprintf(digits.data(), digits.size(), "%06ld", number);
    const std::string results = folder + "/results/";
    files.frames.push_back({BothAt(static_cast<double>(number) / frames_per_second),
                            results + "depth" + digits.data() + ".png",
                            results + "frame" + digits.data() + ".jpg"});
  }
  double index = 0;
  for (const TextRow& row : ReadTextRows(folder + "/traj.txt"))
    files.ground_truth.push_back({index++ / frames_per_second, ParseLine(row)});
  return files;
}

}  // namespace surfit
