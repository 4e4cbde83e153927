// Compares point-to-plane ICP with nearest neighbours in Surfit, PCL and Open3D.
// Only libraries that were found at configure time are included.
//
//   registration_peers [folder of sequences] [repetitions]
//
// Pairs: frame 50 to frame 10 of seven_scenes_kitchen, and ten pairs of icl_office_kinect at a
// distance of ten frames, at full resolution. All libraries get the same points with normals of the
// Surfit preprocessing, start at the identity, and use correspondences up to 0.1 m. They register
// with their default criteria and with common criteria (peer.h). The time includes search trees,
// but not the conversion to the types of the library. Repetitions alternate between the libraries.
// A time is the median over repetitions, summed over the pairs. The error is the pose error to
// ground truth, averaged over the pairs. PCL uses one thread, and Open3D the threads of OpenMP.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "benchmarks/peers/peer.h"
#include "surfit/core/error.h"
#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"

namespace surfit::testing {
namespace {

struct View {
  PeerCloud cloud;
  Rigid3d world_from_camera;
};

View ReadView(const std::string& path, int index) {
  SequenceOptions options;
  options.path = path;
  options.first = options.last = index;
  const auto source = OpenSequence(options);
  const auto result = source->Next();
  if (!result || !result->frame) throw InputError(Concat(path, ": cannot read frame ", index));
  const auto pose = InterpolatePose(source->info().ground_truth, result->stamp_s);
  if (!pose) throw InputError(Concat(path, ": no ground truth for frame ", index));
  PreprocessOptions preprocess;
  preprocess.pyramid_levels = 1;
  const FramePyramid pyramid =
      PreprocessDepth(result->frame->depth_m, source->info().sensor(), preprocess);
  const FrameLevel& level = pyramid.levels.front();
  View view{{}, *pose};
  for (int v = 0; v < level.vertex.height(); ++v) {
    for (int u = 0; u < level.vertex.width(); ++u) {
      if (!(level.vertex.z(u, v) > 0) || level.normal(u, v).isZero(0)) continue;
      view.cloud.points.push_back(level.vertex(u, v));
      view.cloud.normals.push_back(level.normal(u, v));
    }
  }
  return view;
}

struct Pair {
  View source, target;
};

struct Scene {
  std::string name;
  std::vector<Pair> pairs;
};

std::vector<Scene> ReadScenes(const std::string& folder) {
  const std::string kitchen = folder + "/seven_scenes_kitchen";
  const std::string office = folder + "/icl_office_kinect";
  std::vector<Scene> scenes = {{"seven_scenes_kitchen 50 -> 10", {}},
                               {"icl_office_kinect, ten pairs", {}}};
  scenes[0].pairs.push_back({ReadView(kitchen, 50), ReadView(kitchen, 10)});
  for (int i = 0; i < 10; ++i) {
    scenes[1].pairs.push_back({ReadView(office, 10 * i + 10), ReadView(office, 10 * i)});
  }
  return scenes;
}

struct Outcome {
  double time_ms = 0, translation_error_m = 0, rotation_error_deg = 0;
};

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::vector<Outcome> Compare(const Scene& scene, const PeerRules& rules, int repetitions,
                             const std::vector<std::unique_ptr<Peer>>& peers) {
  std::vector<Outcome> outcomes(peers.size());
  for (const Pair& pair : scene.pairs) {
    const Rigid3d truth = pair.target.world_from_camera.Inverse() * pair.source.world_from_camera;
    for (const auto& peer : peers) peer->SetClouds(pair.source.cloud, pair.target.cloud);
    std::vector<std::vector<double>> times_ms(peers.size());
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      for (std::size_t k = 0; k < peers.size(); ++k) {
        const auto start = std::chrono::steady_clock::now();
        const Eigen::Matrix4d pose = peers[k]->Register(rules);
        const std::chrono::duration<double, std::milli> time =
            std::chrono::steady_clock::now() - start;
        times_ms[k].push_back(time.count());
        if (repetition > 0) continue;
        const Eigen::Matrix4d error = truth.Inverse().Matrix() * pose;
        const double share = 1. / static_cast<double>(scene.pairs.size());
        outcomes[k].translation_error_m += share * error.topRightCorner<3, 1>().norm();
        const Eigen::Quaterniond turn(Eigen::Matrix3d(error.topLeftCorner<3, 3>()));
        outcomes[k].rotation_error_deg += share * RotationAngle(turn.normalized()) * 180 / M_PI;
      }
    }
    for (std::size_t k = 0; k < peers.size(); ++k) outcomes[k].time_ms += Median(times_ms[k]);
  }
  return outcomes;
}

void Run(const std::string& folder, int repetitions) {
  std::vector<std::unique_ptr<Peer>> peers;
  peers.push_back(MakeSurfitPeer());
#ifdef SURFIT_HAS_PCL
  peers.push_back(MakePclPeer());
#endif
#ifdef SURFIT_HAS_OPEN3D
  peers.push_back(MakeOpen3dPeer());
#endif
  std::printf("%-30s %-8s %7s  %-8s %10s %10s %9s %9s\n", "frames", "criteria", "threads",
              "library", "time [ms]", "/ Surfit", "[mm]", "[deg]");
  for (const Scene& scene : ReadScenes(folder)) {
    for (const bool own_criteria : {true, false}) {
      for (const int threads : {1, 2}) {
        PeerRules rules;
        rules.threads = threads;
        rules.own_criteria = own_criteria;
        const std::vector<Outcome> outcomes = Compare(scene, rules, repetitions, peers);
        for (std::size_t k = 0; k < peers.size(); ++k) {
          const Outcome& o = outcomes[k];
          std::printf("%-30s %-8s %7d  %-8s %10.1f %10.2f %9.2f %9.3f\n", scene.name.c_str(),
                      own_criteria ? "own" : "common", threads, peers[k]->name().c_str(), o.time_ms,
                      o.time_ms / outcomes[0].time_ms, 1000 * o.translation_error_m,
                      o.rotation_error_deg);
        }
        std::fflush(stdout);
      }
    }
  }
}

}  // namespace
}  // namespace surfit::testing

int main(int argc, char** argv) {
  try {
    surfit::testing::Run(argc > 1 ? argv[1] : SURFIT_DATA_DIR, argc > 2 ? std::atoi(argv[2]) : 5);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}
