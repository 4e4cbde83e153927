// Compares SLAM of Surfit with RGB-D odometry of OpenCV (RgbdICPOdometry) and Open3D, and with
// dense SLAM of Open3D.
// Only systems that were found at configure time are included.
//
//   slam_peers [sequence] [frames]
//
// All systems get the same frames at full resolution, two threads and their default options. Each
// system runs in a separate process, to measure its peak memory. The time is wall time and CPU time
// per frame, from the images of the library to the pose. Reading and conversion are not included.
// In this time, Surfit and dense SLAM of Open3D also build a map. The other systems are
// frame-to-frame odometry. The error is the ATE of Surfit's evaluation.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "benchmarks/peers/peer.h"
#include "surfit/core/error.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/sequence.h"

namespace surfit::testing {
namespace {

constexpr int kThreads = 2;

struct System {
  const char* name;
  MakeSlamPeer make;
};

struct Outcome {
  int frames = 0, lost = 0;
  double ate_m = -1;  // unknown
  double median_ms = 0, p95_ms = 0;
  double cpu_ms = 0;  // mean CPU time of all threads
  long peak_kib = 0;
};

Outcome Follow(const SequenceOptions& options, MakeSlamPeer make) {
  const auto source = OpenSequence(options);
  const auto peer = make(source->info().pinhole, kThreads);
  Outcome outcome;
  Trajectory trajectory;
  std::vector<double> stamps_s, times_ms;
  double cpu_s = 0;
  while (const auto result = source->Next()) {
    if (!result->frame) throw InputError(result->error);
    if (result->frame->color.empty()) throw InputError(options.path + " has no colour");
    peer->SetFrame(*result->frame);
    const std::clock_t cpu_start = std::clock();
    const auto start = std::chrono::steady_clock::now();
    const std::optional<Rigid3d> pose = peer->Track();
    times_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
    cpu_s += static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    stamps_s.push_back(result->stamp_s);
    ++outcome.frames;
    if (pose) {
      trajectory.push_back({result->stamp_s, *pose});
    } else {
      ++outcome.lost;
    }
  }
  const auto evaluation = EvaluateTrajectory(source->info().ground_truth, trajectory, stamps_s, {});
  if (evaluation.ate) outcome.ate_m = evaluation.ate->translation_m.rmse;
  outcome.cpu_ms = 1000 * cpu_s / outcome.frames;
  std::sort(times_ms.begin(), times_ms.end());
  outcome.median_ms = times_ms[times_ms.size() / 2];
  outcome.p95_ms = times_ms[times_ms.size() * 95 / 100];
  return outcome;
}

// Runs the system in a child process. Throws if it fails, after the child has printed the error.
Outcome FollowApart(const SequenceOptions& options, const System& system) {
  int ends[2];
  if (pipe(ends) != 0) throw InputError("cannot create a pipe");
  const pid_t child = fork();
  if (child < 0) throw InputError("cannot create a process");
  if (child == 0) {
    try {
      const Outcome outcome = Follow(options, system.make);
      _exit(write(ends[1], &outcome, sizeof(outcome)) == sizeof(outcome) ? 0 : 1);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "error: %s\n", error.what());
      _exit(1);
    }
  }
  close(ends[1]);
  Outcome outcome;
  const bool is_whole = read(ends[0], &outcome, sizeof(outcome)) == sizeof(outcome);
  close(ends[0]);
  rusage usage{};
  wait4(child, nullptr, 0, &usage);
  if (!is_whole) throw InputError(Concat(system.name, " did not come to an end"));
  outcome.peak_kib = usage.ru_maxrss;
  return outcome;
}

void Run(const SequenceOptions& options) {
  const std::vector<System> systems = {
      {"Surfit", MakeSurfitSlamPeer},
#ifdef SURFIT_HAS_OPENCV_RGBD
      {"OpenCV", MakeOpencvSlamPeer},
#endif
#ifdef SURFIT_HAS_OPEN3D
      {"Open3D", MakeOpen3dSlamPeer},
      {"Open3D, frame to model", MakeOpen3dModelPeer},
#endif
  };
  std::printf("%-22s %7s %6s %10s %10s %10s %9s %10s %9s %10s\n", "system", "frames", "lost",
              "ATE [mm]", "median ms", "p95 ms", "/ Surfit", "CPU ms", "/ Surfit", "peak MiB");
  std::optional<Outcome> surfit;
  for (const System& system : systems) {
    const Outcome o = FollowApart(options, system);
    if (!surfit) surfit = o;
    std::printf("%-22s %7d %6d %10.1f %10.1f %10.1f %9.2f %10.1f %9.2f %10ld\n", system.name,
                o.frames, o.lost, 1000 * o.ate_m, o.median_ms, o.p95_ms,
                o.median_ms / surfit->median_ms, o.cpu_ms, o.cpu_ms / surfit->cpu_ms,
                o.peak_kib / 1024);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace surfit::testing

int main(int argc, char** argv) {
  try {
    surfit::SequenceOptions options;
    options.path = argc > 1 ? argv[1] : SURFIT_DATA_DIR "/icl_office_kinect";
    options.last = (argc > 2 ? std::atoi(argv[2]) : 100) - 1;
    surfit::testing::Run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}
