// Measures the frame time and the memory of the process for a growing map.
//
//   map_growth output [millions [max_bytes_per_surfel]]
//
// The camera views the same room all the time, and surfels are added behind it. Writes
// output/map_growth.csv and .png with one row and one point per million surfels. The exit code is 1
// if the memory above one million surfels grows by more than max_bytes_per_surfel.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>
#include <vector>

#include "benchmarks/mapped_room.h"
#include "io/files/output_folder.h"
#include "output/pictures/axes.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit::testing {
namespace {

// Number of frames until each thread has allocated its buffers.
constexpr int kWarmUps = 5;
constexpr const char* kCsv = "map_growth.csv";
constexpr const char* kPicture = "map_growth.png";

struct Growth {
  std::vector<double> surfels, frame_ms, rss_bytes;
};

double RssBytes() {
  std::ifstream file("/proc/self/statm");
  double total_pages = 0, resident_pages = 0;
  if (!(file >> total_pages >> resident_pages)) {
    throw InputError("/proc/self/statm cannot be read: how much memory is used is unknown");
  }
  constexpr double kPageBytes = 4096;
  return resident_pages * kPageBytes;
}

// Median time of rendering a model view and fusing a frame.
double FrameMilliseconds(const MappedRoom& room, SurfelMap* map) {
  constexpr int kFrames = 9;
  static ModelRenderer renderer({});
  static Fusion fusion({});
  std::vector<double> times_ms;
  for (int i = 0; i < kFrames; ++i) {
    const auto start = std::chrono::steady_clock::now();
    renderer.Render(*map, {room.camera, {}}, room.world_from_next);
    fusion.Fuse(room.next, room.next_surface, room.world_from_next, map);
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    times_ms.push_back(elapsed.count());
  }
  std::nth_element(times_ms.begin(), times_ms.begin() + kFrames / 2, times_ms.end());
  return times_ms[kFrames / 2];
}

Growth Grow(int millions) {
  const MappedRoom room;
  SurfelMap map = room.map;
  Growth growth;
  room.GrowElsewhere(1000000, &map);
  for (int i = 0; i < kWarmUps; ++i) FrameMilliseconds(room, &map);
  for (int i = 1; i <= millions; ++i) {
    room.GrowElsewhere(static_cast<std::size_t>(i) * 1000000, &map);
    const double frame_ms = FrameMilliseconds(room, &map);
    growth.surfels.push_back(static_cast<double>(map.size()));
    growth.frame_ms.push_back(frame_ms);
    growth.rss_bytes.push_back(RssBytes());
    std::printf("%4d M surfels: frame %.2f ms, %.1f MB\n", i, frame_ms,
                1e-6 * growth.rss_bytes.back());
  }
  return growth;
}

void WriteCsv(const Growth& growth, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << "surfels,frame_ms,rss_bytes\n";
    for (std::size_t i = 0; i < growth.surfels.size(); ++i) {
      file << Concat(static_cast<std::int64_t>(growth.surfels[i]), ",", growth.frame_ms[i], ",",
                     static_cast<std::int64_t>(growth.rss_bytes[i]), "\n");
    }
  });
}

void DrawOver(const std::vector<double>& surfels, const std::vector<double>& values, double unit,
              const std::string& label, double left, Image<Rgb8>* image) {
  const double most = unit * *std::max_element(values.begin(), values.end());
  const Axes axes{{left, 40, left + 500, 400},
                  {{0, 1e-6 * surfels.back()}, {0, 1.1 * most}},
                  "",
                  "surfels [millions]",
                  label};
  DrawAxes(image, axes);
  std::vector<PixelPoint> line;
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    line.push_back(axes.At(1e-6 * surfels[i], unit * values[i]));
  }
  DrawLine(image, line, {31, 119, 180}, 3);
}

void WritePicture(const Growth& growth, const std::string& path) {
  Image<Rgb8> image(1220, 480, {255, 255, 255});
  DrawOver(growth.surfels, growth.frame_ms, 1, "prediction and fusion of a frame [ms]", 80, &image);
  DrawOver(growth.surfels, growth.rss_bytes, 1e-6, "resident memory [MB]", 690, &image);
  WritePng(image, path);
}

int Run(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: map_growth output [millions [max_bytes_per_surfel]]\n");
    return 1;
  }
  const std::string output = argv[1];
  const int millions = argc > 2 ? std::atoi(argv[2]) : 10;
  if (millions < 2) throw InputError(Concat("millions is ", argv[2], ", must be at least 2"));
  const double max_bytes = argc > 3 ? std::atof(argv[3]) : 1e9;
  const OutputFolder owned(output, {kCsv, kPicture});
  const Growth growth = Grow(millions);
  WriteCsv(growth, output + "/" + kCsv);
  WritePicture(growth, output + "/" + kPicture);
  const double bytes = (growth.rss_bytes.back() - growth.rss_bytes.front()) /
                       (growth.surfels.back() - growth.surfels.front());
  std::printf("%.2f bytes a surfel, the last frame in %.2f of the first one's time\n", bytes,
              growth.frame_ms.back() / growth.frame_ms.front());
  if (bytes <= max_bytes) return 0;
  std::printf("more than %.2f bytes\n", max_bytes);
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
