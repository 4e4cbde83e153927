// Reads recordings of ARKitScenes (Baruch et al., NeurIPS 2021; "Data" in the documentation of the
// data set). Names of images and cameras are VIDEO_TIME, with the time in s:
//   lowres_depth/*.png             16-bit counts of mm
//   lowres_wide/*.png              colour
//   confidence/*.png               0 (low), 1, 2 (high)
//   lowres_wide_intrinsics/*.pincam  width height fx fy cx cy
//   lowres_wide.traj               per line: time, rotation vector and translation of the transform
//                                  from the world to the camera (x right, y down, z forward)
// Images are not recorded at all times, and poses at fewer times. Times of cameras are rounded, so
// they can differ by 1 ms.
#include <array>

#include "io/phones/phone_recording.h"
#include "io/sequences/confidence.h"
#include "io/sequences/folder.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr double kRounding_s = 0.0021;  // frames are 16.7 ms apart

struct TimedFiles {
  std::vector<double> stamps_s;  // ascending
  std::vector<std::string> paths;
  std::size_t without_time = 0;
};

TimedFiles ListTimedFiles(const std::string& folder, const std::string& ending) {
  std::vector<StampedFile> files;
  TimedFiles timed;
  for (const std::string& name : NamesIn(folder)) {
    if (!EndsWith(name, ending)) continue;
    const auto stamp_s = StampInName(name);
    timed.without_time += !stamp_s;
    if (stamp_s) files.push_back({*stamp_s, Concat(folder, "/", name)});
  }
  std::stable_sort(files.begin(), files.end(), [](const StampedFile& a, const StampedFile& b) {
    return a.stamp_s < b.stamp_s;
  });
  for (StampedFile& file : files) {
    if (!timed.stamps_s.empty() && file.stamp_s == timed.stamps_s.back()) {
      throw InputError(folder, ": ", file.path, " and ", timed.paths.back(),
                       " have the same time, must be one per time");
    }
    timed.stamps_s.push_back(file.stamp_s);
    timed.paths.push_back(std::move(file.path));
  }
  return timed;
}

PinholeCamera ReadPincam(const std::string& path) {
  constexpr std::array kFields = {"width", "height", "fx", "fy", "cx", "cy"};
  const std::vector<TextRow> rows = ReadTextRows(path);
  ThrowIf(rows.size() != 1, path, " has ", rows.size(), " lines, must have 1");
  const std::vector<std::string>& words = rows[0].columns;
  ThrowIf(words.size() != kFields.size(), rows[0].place, " has ", words.size(),
          " columns, must have 6: width height fx fy cx cy");
  std::array<double, kFields.size()> numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = ParseNumber(words[i], Concat(rows[0].place, ": ", kFields[i]));
  for (const int side : {0, 1})
    ThrowIf(!(numbers[side] >= 1 && numbers[side] <= 16384), rows[0].place, ": ", kFields[side],
            " is ", numbers[side], ", must be 1 to 16384");
  return LensOf({static_cast<int>(numbers[0]), static_cast<int>(numbers[1])},
                {numbers[2], numbers[3], numbers[4], numbers[5]}, path);
}

void ReadTraj(const std::string& path, DevicePoses* poses) {
  for (const TextRow& row : ReadTextRows(path)) {
    ThrowIf(row.columns.size() != 7, row.place, " has ", row.columns.size(),
            " columns, must have 7: time, rotation vector, translation");
    const double stamp_s = ParseNumber(row.columns[0], row.place);
    std::array<double, 6> n;
    for (std::size_t i = 0; i < n.size(); ++i)
      n[i] = WithContext(row.place, [&] { return AnyNumber(row.columns[i + 1]); });
    const Eigen::Vector3d vector(n[0], n[1], n[2]), translation(n[3], n[4], n[5]);
    if (!vector.allFinite() || !translation.allFinite()) {
      poses->Add(stamp_s, {std::nullopt, row.place + ": a number is not finite"});
      continue;
    }
    const double angle = vector.norm();
    const Eigen::Vector3d axis =
        angle > 0 ? Eigen::Vector3d(vector / angle) : Eigen::Vector3d::UnitX();
    const Rigid3d camera_from_world(Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)),
                                    translation);
    poses->Add(stamp_s, {camera_from_world.Inverse(), ""});
  }
}

}  // namespace

PhoneFiles ListArkitScenes(const std::string& folder, bool confidence) {
  const std::string depth_folder = folder + "/lowres_depth", color_folder = folder + "/lowres_wide",
                    lens_folder = folder + "/lowres_wide_intrinsics",
                    traj = folder + "/lowres_wide.traj";
  const TimedFiles depth = ListTimedFiles(depth_folder, ".png"),
                   color = ListTimedFiles(color_folder, ".png"),
                   lenses = ListTimedFiles(lens_folder, ".pincam");
  ThrowIf(depth.paths.empty(), depth_folder, " has no image VIDEO_TIME.png");
  ThrowIf(lenses.paths.empty(), lens_folder, " has no file VIDEO_TIME.pincam");
  PhoneFiles files;
  files.camera_from = lens_folder;
  for (std::size_t i = 0; i < depth.paths.size(); ++i) {
    PhoneFrame frame;
    frame.files.stamps = {depth.stamps_s[i], depth.stamps_s[i]};
    frame.files.depth_path = depth.paths[i];
    files.frames.push_back(std::move(frame));
  }
  const auto with_color = MatchStamps(color.stamps_s, depth.stamps_s, kRounding_s);
  for (const auto [c, d] : with_color) {
    files.frames[d].files.color_path = color.paths[c];
    files.frames[d].files.stamps.color_s = color.stamps_s[c];
  }
  const auto with_lens = MatchStamps(lenses.stamps_s, depth.stamps_s, kRounding_s);
  std::vector<bool> has_lens(depth.paths.size());
  for (const auto [l, d] : with_lens) {
    files.frames[d].color_camera = ReadPincam(lenses.paths[l]);
    files.frames[d].camera_place = lenses.paths[l];
    has_lens[d] = true;
  }
  ThrowIf(with_lens.empty(), lens_folder, ": no name has the time of an image in lowres_depth/");
  // Other frames have the lens of the frame before, which is similar.
  PinholeCamera last = files.frames[with_lens.front().second].color_camera;
  for (std::size_t i = 0; i < files.frames.size(); ++i) {
    if (!has_lens[i]) files.frames[i].color_camera = last;
    last = files.frames[i].color_camera;
  }
  const std::size_t colored = with_color.size(), count = depth.paths.size();
  files.unpaired_images = static_cast<int>(count - colored + color.paths.size() - colored);
  if (!color.paths.empty())
    WarnOfCount(count - colored, depth_folder, "images have no image in lowres_wide/",
                &files.warnings);
  WarnOfCount(color.paths.size() - colored, color_folder, "images have no depth and are left out",
              &files.warnings);
  WarnOfCount(
      count - with_lens.size(), depth_folder,
      "images have no file in lowres_wide_intrinsics/: the lens of the frame before is used",
      &files.warnings);
  WarnOfCount(depth.without_time + color.without_time + lenses.without_time, folder,
              "files have no time in their names and are left out", &files.warnings);
  if (HasFile(traj)) ReadTraj(traj, &files.poses);
  if (confidence) AddPhoneConfidence(ConfidenceFolder(folder), &files);
  return files;
}

}  // namespace surfit
