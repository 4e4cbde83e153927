#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "io/files/text.h"
#include "io/images/image_files.h"
#include "io/sequences/folder.h"
#include "io/sequences/recording.h"
#include "io/stamps/ground_truth.h"
#include "io/stamps/image_names.h"
#include "io/stamps/time_words.h"
#include "surfit/core/error.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {
namespace {

FrameStamps BothAt(double stamp_s) { return {stamp_s, stamp_s}; }

std::vector<std::string> ImageNames(const std::string& folder) {
  std::vector<std::string> names = NamesIn(folder);
  names.erase(std::remove_if(names.begin(), names.end(),
                             [](const std::string& name) { return !IsImageName(name); }),
              names.end());
  return names;
}

// Images of a folder by number. If two images have the same number, calls `twice` with a message
// and keeps the image with the shorter name.
using NumberedImages = std::map<long, NamedImage>;
NumberedImages ListNumbered(const std::string& folder, const DuplicateCallback& twice) {
  NumberedImages images;
  for (const NamedImage& image : NumberImages(ImageNames(folder))) {
    const auto [it, is_new] = images.emplace(image.number, image);
    if (is_new) continue;
    twice(Concat(folder, ": ", it->second.name, " and ", image.name, " are both number ",
                 image.number, ", must be one image per number"));
    if (image.name.size() < it->second.name.size()) it->second = image;
  }
  return images;
}

void ThrowTwice(const std::string& error) { throw InputError(error); }

struct StampedImages {
  Times times;  // ascending
  std::vector<std::string> paths;
};

// Sorts by timestamp. Throws InputError if two images have the same timestamp.
StampedImages SortedByTime(const std::string& folder, const std::vector<std::string>& names,
                           const Times& times) {
  std::map<double, std::string> sorted;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [it, is_new] = sorted.emplace(times.stamps_s[i], names[i]);
    ThrowIf(!is_new, folder, ": ", it->second, " and ", names[i],
            " have the same timestamp, must be one image per time");
  }
  StampedImages images;
  images.times.decimals = times.decimals;
  for (const auto& [stamp_s, name] : sorted) {
    images.times.stamps_s.push_back(stamp_s);
    images.paths.push_back(Concat(folder, "/", name));
  }
  return images;
}

// Images of a folder by the timestamps in their names: decimal numbers, or integers with the
// intervals of a camera in ms, us or ns. Empty for other names.
StampedImages ListStamped(const std::string& folder, std::vector<std::string>* warnings) {
  const std::vector<std::string> names = ImageNames(folder);
  std::vector<std::string> words, numbered;
  for (const std::string& name : names) {
    if (auto word = TimeInName(name)) words.push_back(std::move(*word));
  }
  if (!names.empty() && words.size() == names.size() &&
      std::set<std::string>(words.begin(), words.end()).size() > words.size() / 2) {
    return SortedByTime(folder, names, ParseTimes(words, folder, warnings));
  }
  words.clear();
  std::vector<double> numbers;
  for (const NamedImage& image : NumberImages(names)) {
    words.push_back(std::to_string(image.number));
    numbers.push_back(static_cast<double>(image.number));
    numbered.push_back(image.name);
  }
  if (DetectTimeUnit(numbers).value_or(0) == 0) return {};
  return SortedByTime(folder, numbered, ParseTimes(words, folder, warnings));
}

std::vector<FrameFiles> PairStamped(const StampedImages& depth, const StampedImages& color,
                                    int* unpaired_images) {
  std::vector<FrameFiles> frames;
  const std::vector<double>&color_s = color.times.stamps_s, &depth_s = depth.times.stamps_s;
  for (const auto [c, d] : MatchStamps(color_s, depth_s, kMaxBetweenImages_s))
    frames.push_back({{depth_s[d], color_s[c]}, depth.paths[d], color.paths[c]});
  *unpaired_images = static_cast<int>(color_s.size() + depth_s.size() - 2 * frames.size());
  return frames;
}

void RequirePairs(const std::vector<FrameFiles>& frames, const std::string& color_folder) {
  if (!frames.empty()) return;
  throw InputError("no image name in ", color_folder, " is within ", kMaxBetweenImages_s,
                   " s of a depth image name (names are timestamps)");
}

// Frames of a folder whose image names are times.
SequenceFiles PairByNames(const StampedImages& depth, const std::string& color_folder) {
  SequenceFiles files;
  files.has_clock = true;
  if (color_folder.empty()) {
    for (std::size_t i = 0; i < depth.paths.size(); ++i)
      files.frames.push_back({BothAt(depth.times.stamps_s[i]), depth.paths[i], ""});
    return files;
  }
  const StampedImages color = ListStamped(color_folder, &files.warnings);
  files.frames = PairStamped(depth, color, &files.unpaired_images);
  RequirePairs(files.frames, color_folder);
  return files;
}

// Times in the names of numbered images; empty if a name has no time.
StampedImages TimesBesideNumbers(const std::string& folder, const NumberedImages& images) {
  std::vector<std::string> names, words;
  for (const auto& [number, image] : images) {
    if (image.time.empty()) return {};
    names.push_back(image.name);
    words.push_back(image.time);
  }
  std::vector<std::string> known_unit;
  return SortedByTime(folder, names, ParseTimes(words, folder, &known_unit));
}

// Longest time between depth and colour images of the same number.
double LongestBetween(const NumberedImages& depth, const StampedImages& depth_times,
                      const NumberedImages& color, const StampedImages& color_times) {
  std::map<long, double> depth_s;
  std::size_t i = 0;
  for (const auto& [number, image] : depth) depth_s[number] = depth_times.times.stamps_s[i++];
  double longest_s = 0;
  i = 0;
  for (const auto& [number, image] : color) {
    const double color_s = color_times.times.stamps_s[i++];
    const auto it = depth_s.find(number);
    if (it != depth_s.end()) longest_s = std::max(longest_s, std::abs(color_s - it->second));
  }
  return longest_s;
}

// Pairs images with a number and a time in their names by time, if images of the same number have
// different times. Recorders number the images of each stream, and can lose images of one stream.
// std::nullopt if times of equal numbers agree. Also std::nullopt if the names have no times.
std::optional<SequenceFiles> PairByTimesBesideNumbers(const std::string& depth_folder,
                                                      const std::string& color_folder) {
  if (color_folder.empty()) return std::nullopt;
  const NumberedImages depth = ListNumbered(depth_folder, ThrowTwice),
                       color = ListNumbered(color_folder, ThrowTwice);
  const StampedImages depth_times = TimesBesideNumbers(depth_folder, depth),
                      color_times = TimesBesideNumbers(color_folder, color);
  if (depth_times.paths.empty() || color_times.paths.empty()) return std::nullopt;
  const double longest_s = LongestBetween(depth, depth_times, color, color_times);
  if (longest_s <= kMaxBetweenImages_s) return std::nullopt;
  SequenceFiles files;
  files.has_clock = true;
  files.frames = PairStamped(depth_times, color_times, &files.unpaired_images);
  RequirePairs(files.frames, color_folder);
  files.warnings.push_back(
      Concat(depth_folder, " and ", color_folder, ": images of the same number are up to ",
             longest_s, " s apart by the times in their names, images are paired by time (",
             files.unpaired_images, " have no partner)"));
  return files;
}

// File name of the image with this number. For a missing image: the name in `others` with the file
// extension of `images`.
std::string NameOf(long number, const NumberedImages& images, const NumberedImages& others) {
  const auto it = images.find(number);
  if (it != images.end()) return it->second.name;
  const std::string& other = others.at(number).name;
  const std::string& some = images.empty() ? other : images.begin()->second.name;
  return other.substr(0, other.rfind('.')) + some.substr(some.rfind('.'));
}

struct NumberedPose {
  long number = 0;
  ParsedRigid parsed;
};

// Uses FramesOfPoses().
Trajectory AssignPoses(std::vector<NumberedPose> poses, const std::vector<long>& frame_numbers,
                       const std::string& path, SequenceFiles* files) {
  std::stable_sort(poses.begin(), poses.end(), [](const NumberedPose& a, const NumberedPose& b) {
    return a.number < b.number;
  });
  std::vector<long> numbers;
  numbers.reserve(poses.size());
  for (const NumberedPose& pose : poses) numbers.push_back(pose.number);
  const std::vector<int> frame_of_pose = FramesOfPoses(numbers, frame_numbers);
  GroundTruthPoses truth(path);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (frame_of_pose[i] < 0) {
      truth.AddWithoutFrame();
    } else {
      truth.Add(files->frames[frame_of_pose[i]].stamps.depth_s, poses[i].parsed);
    }
  }
  return truth.Take(&files->warnings);
}

// Reads blocks of five lines: the frame number (first number of its line) and a 4 x 4 pose. If all
// blocks have the same number, their positions are the numbers.
std::vector<NumberedPose> ReadLog(const std::string& path) {
  const auto rows = ReadTextRows(path);
  std::vector<NumberedPose> poses;
  std::set<long> numbers;
  for (std::size_t i = 0; i < rows.size(); i += 5) {
    const double number = ParseNumber(rows[i].columns[0], rows[i].place);
    ThrowIf(number != std::floor(number) || std::abs(number) > 1e15, rows[i].place,
            ": the frame number is ", rows[i].columns[0], ", must be an integer");
    poses.push_back({static_cast<long>(number), ParseRigid(rows, i + 1, path)});
    numbers.insert(poses.back().number);
  }
  if (numbers.size() == 1)
    for (std::size_t i = 0; i < poses.size(); ++i) poses[i].number = static_cast<long>(i);
  return poses;
}

bool IsFrameFile(const std::string& name, const std::string& ending) {
  return name.compare(0, 6, "frame-") == 0 && EndsWith(name, ending) && NumberInName(name);
}

// Reads lines with a row-major 4 x 4 matrix. The number of a line is its position, from 0.
std::vector<NumberedPose> ReadMatrixLines(const std::string& path) {
  std::vector<NumberedPose> poses;
  for (const TextRow& row : ReadTextRows(path)) {
    ThrowIf(row.columns.size() != 16, row.place, " has ", row.columns.size(),
            " columns, must have 16");
    poses.push_back({static_cast<long>(poses.size()), ParseRigid(row.columns, row.place)});
  }
  return poses;
}

std::vector<long> DepthNumbers(const std::vector<FrameFiles>& frames) {
  std::vector<std::string> names;
  names.reserve(frames.size());
  for (const FrameFiles& frame : frames)
    names.push_back(frame.depth_path.substr(frame.depth_path.rfind('/') + 1));
  std::map<std::string, long> by_name;
  for (const NamedImage& image : NumberImages(names)) by_name[image.name] = image.number;
  std::vector<long> numbers;
  numbers.reserve(names.size());
  for (const std::string& name : names) numbers.push_back(by_name[name]);
  return numbers;
}

}  // namespace

std::string FindColorFolder(const std::string& folder) {
  for (const char* name : {"/color", "/rgb", "/image", "/images"}) {
    if (IsFolder(folder + name)) return folder + name;
  }
  return "";
}

std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder) {
  return ListNumberedFrames(depth_folder, color_folder, ThrowTwice);
}

std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder,
                                           const DuplicateCallback& twice) {
  const auto depth = ListNumbered(depth_folder, twice);
  const auto color = color_folder.empty() ? depth : ListNumbered(color_folder, twice);
  std::map<long, FrameFiles> frames;
  for (const auto& [number, image] : color) frames[number];
  for (const auto& [number, image] : depth) frames[number];
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
  const std::string depth_folder = folder + "/depth", color_folder = FindColorFolder(folder);
  const std::string log_path = folder + "/trajectory.log", tum_path = folder + "/groundtruth.txt";
  std::vector<std::string> warnings;
  const StampedImages stamped = ListStamped(depth_folder, &warnings);
  std::vector<long> numbers;
  if (!stamped.paths.empty()) {
    files = PairByNames(stamped, color_folder);
    for (std::size_t i = 0; i < files.frames.size(); ++i) numbers.push_back(static_cast<long>(i));
    files.warnings.insert(files.warnings.begin(), warnings.begin(), warnings.end());
    if (HasFile(tum_path)) {
      files.ground_truth = ReadGroundTruth(tum_path, stamped.times, &files.warnings);
      return files;
    }
  } else if (auto timed = PairByTimesBesideNumbers(depth_folder, color_folder)) {
    files = std::move(*timed);
    numbers = DepthNumbers(files.frames);
  } else {
    files.frames = ListNumberedFrames(depth_folder, color_folder);
    for (FrameFiles& frame : files.frames) {
      numbers.push_back(static_cast<long>(frame.stamps.depth_s));
      frame.stamps = BothAt(static_cast<double>(numbers.back() - numbers[0]) / frames_per_second);
    }
  }
  if (HasFile(log_path))
    files.ground_truth = AssignPoses(ReadLog(log_path), numbers, log_path, &files);
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
  GroundTruthPoses truth(folder);
  for (const auto& [number, stem] : stems) {
    const double stamp_s = static_cast<double>(number) / frames_per_second;
    const std::string color_path = color_ending.empty() ? "" : stem + color_ending;
    files.frames.push_back({BothAt(stamp_s), stem + ".depth.png", color_path});
    const std::string pose_path = stem + ".pose.txt";
    if (!HasFile(pose_path)) continue;
    truth.Add(stamp_s, ParseRigid(ReadTextRows(pose_path), 0, pose_path));
  }
  files.ground_truth = truth.Take(&files.warnings);
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
  const std::string path = folder + "/traj.txt";
  files.ground_truth =
      AssignPoses(ReadMatrixLines(path), {numbers.begin(), numbers.end()}, path, &files);
  return files;
}

}  // namespace surfit
