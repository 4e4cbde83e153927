#include <algorithm>
#include <filesystem>
#include <utility>

#include "io/files/text.h"
#include "io/sequences/folder.h"
#include "io/sequences/recording.h"
#include "io/stamps/ground_truth.h"
#include "io/stamps/time_words.h"
#include "surfit/core/error.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {
namespace {

// Rejects files outside the folder, because lists may be untrusted.
std::string ListedPath(const TextRow& row, std::size_t column, const std::string& folder) {
  const std::string& name = row.columns[column];
  const std::filesystem::path normal = std::filesystem::path(name).lexically_normal();
  ThrowIf(normal.is_absolute() || *normal.begin() == "..", row.place, ": '", name,
          "' is outside the folder of the sequence");
  return FollowTextLink(folder, name);
}

void RequireColumns(const TextRow& row, std::size_t count, const char* meaning) {
  ThrowIf(row.columns.size() != count, row.place, " has ", row.columns.size(),
          " columns, must have ", count, ": ", meaning);
}

std::string TimeWord(const TextRow& row, std::size_t column) {
  ParseNumber(row.columns[column], row.place);
  return row.columns[column];
}

// List of images. Each part is sorted by timestamp.
struct ImageList {
  Times times;
  std::vector<std::string> paths;
  std::vector<std::size_t> starts;  // first images of the parts, see FindClockStarts()

  std::size_t end(std::size_t part) const {
    return part + 1 < starts.size() ? starts[part + 1] : paths.size();
  }
  std::vector<double> StampsOf(std::size_t part) const {
    const auto at = [&](std::size_t i) {
      return times.stamps_s.begin() + static_cast<std::ptrdiff_t>(i);
    };
    return {at(starts[part]), at(end(part))};
  }
};

// Indices of timestamps, sorted within each part.
std::vector<std::size_t> SortedParts(const std::vector<double>& stamps_s,
                                     const std::vector<std::size_t>& starts) {
  std::vector<std::size_t> order(stamps_s.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(starts[k]);
    const auto end = k + 1 < starts.size()
                         ? order.begin() + static_cast<std::ptrdiff_t>(starts[k + 1])
                         : order.end();
    std::stable_sort(begin, end,
                     [&](std::size_t a, std::size_t b) { return stamps_s[a] < stamps_s[b]; });
  }
  return order;
}

// Reads rgb.txt or depth.txt.
ImageList ReadImageList(const std::string& folder, const std::string& name,
                        std::vector<std::string>* warnings) {
  std::vector<std::string> words, paths;
  ForEachTextRow(Concat(folder, "/", name), [&](const TextRow& row) {
    RequireColumns(row, 2, "timestamp and file");
    words.push_back(TimeWord(row, 0));
    paths.push_back(ListedPath(row, 1, folder));
  });
  const Times times = ParseTimes(words, Concat(folder, "/", name), warnings);
  ImageList list;
  list.times.decimals = times.decimals;
  list.starts = FindClockStarts(times.stamps_s);
  for (const std::size_t i : SortedParts(times.stamps_s, list.starts)) {
    list.times.stamps_s.push_back(times.stamps_s[i]);
    list.paths.push_back(paths[i]);
  }
  return list;
}

// Pairs rgb.txt and depth.txt by time, each part of depth.txt with the same part of rgb.txt.
SequenceFiles PairByTime(const std::string& folder, Times* times) {
  SequenceFiles files;
  const ImageList depth = ReadImageList(folder, "depth.txt", &files.warnings);
  *times = depth.times;
  const std::vector<double>& depth_s = depth.times.stamps_s;
  if (!HasFile(folder + "/rgb.txt")) {
    for (std::size_t i = 0; i < depth.paths.size(); ++i)
      files.frames.push_back({{depth_s[i], depth_s[i]}, depth.paths[i], ""});
    return files;
  }
  const ImageList color = ReadImageList(folder, "rgb.txt", &files.warnings);
  ThrowIf(depth.starts.size() != color.starts.size(), folder, ": the clock of depth.txt starts ",
          depth.starts.size(), " times and that of rgb.txt ", color.starts.size(),
          " times, must be equal: make one folder per recording");
  for (std::size_t k = 0; k < depth.starts.size(); ++k) {
    for (const auto [c, d] :
         MatchStamps(color.StampsOf(k), depth.StampsOf(k), kMaxBetweenImages_s)) {
      const std::size_t at_color = color.starts[k] + c, at_depth = depth.starts[k] + d;
      files.frames.push_back({{depth_s[at_depth], color.times.stamps_s[at_color]},
                              depth.paths[at_depth],
                              color.paths[at_color]});
    }
  }
  ThrowIf(files.frames.empty() && !depth.paths.empty() && !color.paths.empty(), folder,
          ": no timestamp in rgb.txt is within ", kMaxBetweenImages_s,
          " s of a timestamp in depth.txt");
  files.unpaired_images =
      static_cast<int>(color.paths.size() + depth.paths.size() - 2 * files.frames.size());
  return files;
}

// Reads associations.txt. Colour is first (TUM) or second (ICL-NUIM). Depth has "depth" in its
// path.
SequenceFiles ReadAssociations(const std::string& folder, Times* times) {
  const std::string path = folder + "/associations.txt";
  std::vector<std::string> depth_words, color_words;
  SequenceFiles files;
  ForEachTextRow(path, [&](const TextRow& row) {
    RequireColumns(row, 4, "timestamp and file of colour, timestamp and file of depth");
    const bool depth_first = row.columns[1].find("depth") != std::string::npos;
    const std::size_t depth = depth_first ? 0 : 2, color = depth_first ? 2 : 0;
    depth_words.push_back(TimeWord(row, depth));
    color_words.push_back(TimeWord(row, color));
    files.frames.push_back(
        {{}, ListedPath(row, depth + 1, folder), ListedPath(row, color + 1, folder)});
  });
  *times = ParseTimes(depth_words, path + ", depth", &files.warnings);
  const Times color_times = ParseTimes(color_words, path + ", colour", &files.warnings);
  for (std::size_t i = 0; i < files.frames.size(); ++i)
    files.frames[i].stamps = {times->stamps_s[i], color_times.stamps_s[i]};
  std::vector<FrameFiles> sorted;
  for (const std::size_t i : SortedParts(times->stamps_s, FindClockStarts(times->stamps_s)))
    sorted.push_back(files.frames[i]);
  files.frames = std::move(sorted);
  return files;
}

Trajectory FindGroundTruth(const std::string& folder, const Times& times,
                           std::vector<std::string>* warnings) {
  const std::string tum = folder + "/groundtruth.txt";
  if (HasFile(tum)) return ReadGroundTruth(tum, times, warnings);
  for (const std::string& name : NamesIn(folder)) {
    const std::string path = Concat(folder, "/", name);
    if (EndsWith(name, ".gt.freiburg") && HasFile(path))
      return ReadGroundTruth(path, times, warnings);
  }
  return {};
}

}  // namespace

std::vector<StampedFile> ReadStampedFiles(const std::string& folder, const std::string& name,
                                          std::vector<std::string>* warnings) {
  const ImageList list = ReadImageList(folder, name, warnings);
  std::vector<StampedFile> files;
  for (std::size_t i = 0; i < list.paths.size(); ++i)
    files.push_back({list.times.stamps_s[i], list.paths[i]});
  return files;
}

SequenceFiles ListTumSequence(const std::string& folder) {
  Times times;
  SequenceFiles files = HasFile(folder + "/associations.txt") ? ReadAssociations(folder, &times)
                                                              : PairByTime(folder, &times);
  files.has_clock = true;
  files.ground_truth = FindGroundTruth(folder, times, &files.warnings);
  return files;
}

SequenceFiles ListIclNuimSequence(const std::string& folder) {
  if (HasFile(folder + "/associations.txt") || HasFile(folder + "/depth.txt"))
    return ListTumSequence(folder);
  SequenceFiles files;
  files.frames = ListNumberedFrames(folder + "/depth", folder + "/rgb");
  files.ground_truth = FindGroundTruth(folder, {}, &files.warnings);
  return files;
}

}  // namespace surfit
