// Reads recordings of Stray Scanner. Its "Data Specification" describes the files:
//   rgb.mp4              colour, for example 1920 x 1440
//   depth/NNNNNN.png     16-bit counts of mm, for example 256 x 192; older versions: NNNNNN.npy
//   confidence/NNNNNN.png  0 (low), 1, 2 (high)
//   odometry.csv         timestamp in s, number and pose per frame; since 2026 also fx, fy, cx, cy
//   camera_matrix.csv    3 x 3 intrinsics of the last frame
// The number of a row is the number of its images, and of its frame in the video. Intrinsics are
// those of the video. Poses have the camera axes x right, y down, z forward.
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "io/phones/csv_rows.h"
#include "io/phones/phone_recording.h"
#include "io/sequences/confidence.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::array kLensColumns = {"fx", "fy", "cx", "cy"};
constexpr std::array kPoseColumns = {"x", "y", "z", "qx", "qy", "qz", "qw"};
constexpr ImageSize kUsualVideo = {1920, 1440};

PinholeCamera ReadCameraMatrix(const std::string& path, ImageSize size) {
  const std::vector<double> m = ReadCsvMatrix(path, 3, 3);
  for (const std::size_t zero : {1, 3, 6, 7})
    ThrowIf(m[zero] != 0, path, ": element ", zero / 3 + 1, ", ", zero % 3 + 1, " is ", m[zero],
            ", must be 0: the rows are fx 0 cx, 0 fy cy and 0 0 1");
  ThrowIf(m[8] != 1, path, ": element 3, 3 is ", m[8], ", must be 1");
  return LensOf(size, {m[0], m[4], m[2], m[5]}, path);
}

ParsedRigid PoseOf(const CsvTable& table, std::size_t row) {
  try {
    std::array<double, 7> numbers;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] = table.Number(row, kPoseColumns[i]);
    return {RigidFromNumbers(numbers.data()), ""};
  } catch (const InputError& error) {
    return {std::nullopt, error.what()};
  }
}

long NumberOf(const CsvTable& table, std::size_t row) {
  constexpr double kMost = 1e9;
  const double number = table.Number(row, "frame");
  ThrowIf(number != std::floor(number) || number < 0 || number > kMost, table.places[row],
          ": frame is ", number, ", must be an integer of at least 0");
  return static_cast<long>(number);
}

std::map<long, std::string> ImagesByNumber(const std::string& folder) {
  std::map<long, std::string> images;
  for (const FrameFiles& frame : ListNumberedFrames(folder, ""))
    images[static_cast<long>(frame.stamps.depth_s)] = frame.depth_path;
  return images;
}

// An app that is closed while it records leaves an incomplete last line.
void DropIncompleteRow(CsvTable* table, std::vector<std::string>* warnings) {
  if (table->rows.empty() || table->rows.back().size() > table->columns.at("qw")) return;
  warnings->push_back(table->places.back() + " is incomplete, its frame is left out");
  table->rows.pop_back();
  table->places.pop_back();
}

void OpenStrayVideo(const std::string& path, PhoneFiles* files) {
  try {
    files->video = std::make_shared<VideoFile>(path);
  } catch (const InputError& error) {
    files->warnings.push_back(Concat(error.what(),
                                     ": colour is not used, and the intrinsics are taken for ",
                                     kUsualVideo.width, " x ", kUsualVideo.height, " pixels"));
  }
}

// Position of each frame in the video. The video has all numbered frames, or only those of the
// rows.
std::map<long, int> VideoFrames(const VideoFile& video, const std::set<long>& numbers) {
  const long total = video.hidden_frames() + video.frame_count();
  const bool has_rows_only =
      *numbers.rbegin() >= total && static_cast<long>(numbers.size()) <= total;
  std::map<long, int> frames;
  for (const long number : numbers)
    frames[number] = has_rows_only ? static_cast<int>(frames.size()) : static_cast<int>(number);
  return frames;
}

}  // namespace

PhoneFiles ListStrayScanner(const std::string& folder, bool confidence) {
  const std::string path = folder + "/odometry.csv", matrix_path = folder + "/camera_matrix.csv";
  std::vector<std::string> required = {"timestamp", "frame"};
  required.insert(required.end(), kPoseColumns.begin(), kPoseColumns.end());
  CsvTable table = ReadCsv(path, required);
  PhoneFiles files;
  DropIncompleteRow(&table, &files.warnings);
  OpenStrayVideo(folder + "/rgb.mp4", &files);
  const ImageSize size = files.video ? files.video->size() : kUsualVideo;
  const bool has_lenses = std::all_of(kLensColumns.begin(), kLensColumns.end(),
                                      [&](const char* column) { return table.Has(column); });
  files.camera_from = has_lenses ? path : matrix_path;
  PinholeCamera shared_lens;
  if (!has_lenses) shared_lens = ReadCameraMatrix(matrix_path, size);
  std::map<long, std::string> depth = ImagesByNumber(folder + "/depth");
  std::map<long, PhoneFrame> frames;
  std::set<long> numbers;
  std::size_t twice = 0, without_depth = 0;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const long number = NumberOf(table, row);
    const double stamp_s = table.Number(row, "timestamp");
    PinholeCamera lens = shared_lens;
    if (has_lenses) {
      std::array<double, 4> values;
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = table.Number(row, kLensColumns[i]);
      lens = LensOf(size, values, table.places[row]);
    }
    if (!numbers.insert(number).second) {
      ++twice;
      continue;
    }
    files.poses.Add(stamp_s, PoseOf(table, row));
    const auto image = depth.find(number);
    if (image == depth.end()) {
      ++without_depth;
      continue;
    }
    PhoneFrame frame;
    frame.files.stamps = {stamp_s, stamp_s};
    frame.files.depth_path = image->second;
    frame.color_camera = lens;
    frames.emplace(number, std::move(frame));
  }
  std::map<long, int> video_frames;
  if (files.video && !numbers.empty()) video_frames = VideoFrames(*files.video, numbers);
  for (auto& [number, frame] : frames) {
    if (files.video) frame.video_frame = video_frames.at(number);
    files.frames.push_back(std::move(frame));
  }
  const std::size_t unused = depth.size() - frames.size();
  files.unpaired_images = static_cast<int>(unused);
  WarnOfCount(twice, path, "rows repeat the number of an earlier frame and are left out",
              &files.warnings);
  WarnOfCount(without_depth, path, "rows have no image in depth/ and are left out",
              &files.warnings);
  WarnOfCount(unused, folder + "/depth", "images have no row in odometry.csv and are left out",
              &files.warnings);
  ThrowIf(files.frames.empty(), path, ": no row has an image in depth/");
  if (confidence) AddPhoneConfidence(ConfidenceFolder(folder), &files);
  return files;
}

}  // namespace surfit
