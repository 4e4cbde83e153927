// What a sensor does to its images, and what surfit_slam makes of it, against the exact truth.
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "testing/matchers.h"
#include "testing/run_program.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// A simulated Kinect's walk through a room, at 320 x 240 pixels.
void SimulateRoom(const std::string& folder, int seed, std::vector<std::string> sensor) {
  sensor.insert(sensor.begin(), {"--output=" + folder, "--frames=150", "--downsample=2",
                                 "--seed=" + std::to_string(seed), "--surface_grid_m=0.05"});
  Succeeded(RunProgram("surfit_simulate", sensor));
}

nlohmann::json SummaryOf(const std::string& sequence, const std::string& output,
                         std::vector<std::string> flags) {
  flags.insert(flags.begin(), {"--sequence=" + sequence, "--output=" + output, "--nopictures"});
  Succeeded(RunProgram("surfit_slam", flags));
  return nlohmann::json::parse(ReadBytes(output + "/summary.json"));
}

TEST(SlamSensor, AFifthOfTheErrorIsLeftOfARollingShutterThatIsKnown) {
  for (const int seed : {4, 11}) {
    const TempFolder folder;
    SimulateRoom(folder / "in", seed, {"--readout_s=0.033", "--known=readout_s"});
    const auto ate_mm = [&](const std::string& name, const std::string& flag) -> double {
      return 1000 * SummaryOf(folder / "in", folder / name, {"--nocalibrate", flag})["ate_rmse_m"]
                        .get<double>();
    };
    const double ignored = ate_mm("ignored", "--readout_s=0"), known = ate_mm("known", "--stride=1");
    std::printf("seed %d: ATE %.2f -> %.2f mm\n", seed, ignored, known);
    EXPECT_LT(known, ignored / 5) << seed;
  }
}

}  // namespace
}  // namespace surfit::testing
