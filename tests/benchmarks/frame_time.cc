// Measures the frame time relative to a baseline: decoding and memory transfer.
//
//   frame_time sequence output [frames [max_multiple [solver]]]
//
// The baseline decodes the frame with imdecode() of OpenCV (libpng and zlib, libjpeg-turbo) on one
// thread. It does not depend on the decoders of Surfit. Then it copies the bytes that a frame
// touches, once, on all threads:
// - decoded depth and colour, 7 bytes per pixel;
// - vertices and normals of all levels of the frame and of the model view, 24 bytes each;
// - surfels that were merged or added, 40 bytes each, read and written.
// Both times are measured after the run, so that the multiple does not depend on the machine. The
// exit code is 1 if the multiple of six runs is above max_multiple. Other load on the machine only
// increases it.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "surfit/core/parallel.h"
#include "surfit/run/slam_run.h"

namespace surfit::testing {
namespace {

std::size_t BytesOfFrame(const SlamRunSummary& summary) {
  const double frames = std::max(1, summary.frames_total);
  const double pixels = static_cast<double>(summary.input_points) / frames;
  constexpr double kAllLevels = 4. / 3;
  const double surfels = static_cast<double>(summary.updated + summary.added) / frames;
  return static_cast<std::size_t>(pixels * (7 + 2 * 24 * kAllLevels) + 2 * 40 * surfels);
}

// Shortest time of several copies. Half of the bytes are read, and half are written.
double CopyMilliseconds(std::size_t bytes) {
  constexpr int kRepetitions = 20, kChunk = 1 << 18;
  std::vector<char> from(bytes / 2, 1), to(bytes / 2);
  double fastest_ms = 1e9;
  for (int i = 0; i < kRepetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    ParallelFor(0, static_cast<int>(from.size()), kChunk, [&](int begin, int end) {
      std::memcpy(to.data() + begin, from.data() + begin, end - begin);
    });
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    fastest_ms = std::min(fastest_ms, elapsed.count());
  }
  return fastest_ms;
}

std::string BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Shortest time per image of several rounds over the images.
double DecodeMilliseconds(const std::vector<std::string>& paths) {
  constexpr std::size_t kMost = 20;
  constexpr int kRepetitions = 5;
  const std::size_t count = std::min(kMost, paths.size());
  if (count == 0) return 0;
  std::vector<std::string> images;
  for (std::size_t i = 0; i < count; ++i)
    images.push_back(BytesOf(paths[i * paths.size() / count]));
  double fastest_ms = 1e9;
  for (int i = 0; i < kRepetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    for (std::string& image : images) {
      const cv::Mat bytes(1, static_cast<int>(image.size()), CV_8UC1, image.data());
      if (cv::imdecode(bytes, cv::IMREAD_UNCHANGED).empty()) std::abort();
    }
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    fastest_ms = std::min(fastest_ms, elapsed.count() / static_cast<double>(count));
  }
  return fastest_ms;
}

// Decoding time of depth and colour of a frame in a folder of images.
double DecodeMilliseconds(const std::string& sequence) {
  std::vector<std::string> depth, color;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(sequence)) {
    const std::string path = entry.path(), kind = entry.path().extension();
    if (kind != ".png" && kind != ".jpg") continue;
    const bool is_depth = path.find("depth", sequence.size()) != std::string::npos;
    (is_depth ? depth : color).push_back(path);
  }
  std::sort(depth.begin(), depth.end());
  std::sort(color.begin(), color.end());
  return DecodeMilliseconds(depth) + DecodeMilliseconds(color);
}

void Print(const std::string& name, const TimeStatistics& times) {
  std::printf("%-10s mean %7.2f ms, median %7.2f, p95 %7.2f\n", name.c_str(), times.mean_ms,
              times.median_ms, times.p95_ms);
}

double Measure(const SlamRunOptions& options) {
  const SlamRunSummary summary = RunSlam(options, std::atomic<bool>(false), [](const auto&) {});
  const ThreadLimit threads(options.threads);
  const std::size_t bytes = BytesOfFrame(summary);
  const double read_ms = DecodeMilliseconds(options.sequence.path);
  const double copy_ms = CopyMilliseconds(bytes);
  const double multiple = summary.frame.mean_ms / (read_ms + copy_ms);
  std::printf("%d frames, %zu surfels, %d lost\n", summary.frames_total, summary.map_points,
              summary.frames_lost);
  for (const StageStatistics& s : summary.stages) {
    Print(s.name, s.times);
  }
  Print("frame", summary.frame);
  std::printf("decoding %.2f ms + %.1f MB through memory %.2f ms; frame / these: %.2f\n", read_ms,
              1e-6 * static_cast<double>(bytes), copy_ms, multiple);
  return multiple;
}

int Run(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: frame_time sequence output [frames [max_multiple [solver]]]\n");
    return 1;
  }
  SlamRunOptions options;
  options.sequence.path = argv[1];
  options.output = argv[2];
  options.pictures = false;
  options.final_map = false;  // not part of the frame time
  if (argc > 3) options.sequence.last = std::atoi(argv[3]) - 1;
  if (argc > 5) options.slam.icp.solver = argv[5];
  const double max_multiple = argc > 4 ? std::atof(argv[4]) : 1e9;
  constexpr int kAttempts = 6;
  for (int i = 0; i < kAttempts; ++i) {
    if (Measure(options) <= max_multiple) return 0;
    std::printf("more than %.2f\n", max_multiple);
  }
  return 1;
}

}  // namespace
}  // namespace surfit::testing

int main(int argc, char** argv) {
  try {
    return surfit::testing::Run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}
