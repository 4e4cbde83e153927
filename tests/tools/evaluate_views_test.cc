#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/evaluate/view_evaluation.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

class EvaluateViewsTool : public SlamTool {
 protected:
  // A copy of the room. The colour images of these frames are red.
  std::string RoomWithRed(const std::vector<int>& frames) const {
    const std::string copy = CopyOfRoom();
    const std::vector<std::string> rows = Lines(copy + "/associations.txt");
    for (const int frame : frames) {
      std::istringstream row(rows[frame]);
      std::string stamp, color;
      row >> stamp >> color;
      cv::Mat image = cv::imread(copy + "/" + color);
      image = cv::Scalar(0, 0, 255);
      cv::imwrite(copy + "/" + color, image);
    }
    return copy;
  }
  static ProgramResult Judge(const std::string& run, std::vector<std::string> flags = {}) {
    flags.insert(flags.begin(), {"--what=views", "--run=" + run});
    return RunProgram("surfit_evaluate", flags);
  }
  static nlohmann::json Views(const std::string& folder) {
    return nlohmann::json::parse(ReadBytes(folder + "/views.json"));
  }
};

TEST_F(EvaluateViewsTool, HeldOutFramesAreNotFused) {
  const std::vector<std::string> flags = {"--hold_out=5", "--nocalibrate"};
  Succeeded(Slam(Room(), Output(), flags));
  EXPECT_THAT(Summary(Output())["held_out_frames"], ElementsAre(4, 9, 14, 19));
  EXPECT_EQ(Summary(Output())["frames_tracked"], kFrames);
  for (const char* frame : {"4,", "9,", "14,", "19,"}) {
    EXPECT_THAT(Lines(Output() + "/frames.csv"),
                ::testing::Contains(::testing::AllOf(::testing::StartsWith(frame),
                                                     ::testing::HasSubstr(",tracked,0,"))));
  }
  Succeeded(Slam(RoomWithRed({4, 9, 14, 19}), Output("red"), flags));
  EXPECT_EQ(ReadBytes(Output() + "/map.ply"), ReadBytes(Output("red") + "/map.ply"));
  Succeeded(Slam(own_.path() + "/copy", Output("fused"), {"--nocalibrate"}));
  EXPECT_NE(ReadBytes(Output() + "/map.ply"), ReadBytes(Output("fused") + "/map.ply"));
}

TEST_F(EvaluateViewsTool, EvaluatesOnlyHeldOutFrames) {
  Succeeded(Slam(Room(), Output(), {"--hold_out=5"}));
  const ProgramResult result = Succeeded(Judge(Output(), {"--every=1"}));
  EXPECT_THAT(result.out, Names(4));
  const std::vector<std::string> rows = Lines(Output() + "/views.csv");
  ASSERT_EQ(rows.size(), 5u);
  for (int i = 0; i < 4; ++i) EXPECT_THAT(rows[i + 1], StartsWith(std::to_string(5 * i + 4) + ","));
  const nlohmann::json views = Views(Output());
  EXPECT_EQ(views["frames"], 4);
  EXPECT_EQ(views["held_out"], true);
  // The simulated room has no exposure model: views are similar and almost complete.
  EXPECT_GT(views["psnr_covered_db"], 18);
  EXPECT_GE(views["psnr_covered_db"], views["psnr_db"]);
  EXPECT_GT(views["psnr_covered_by_gain_db"], views["psnr_covered_db"]);
  EXPECT_GT(views["ssim_covered"], 0.6);
  EXPECT_GT(views["coverage"], 0.9);
  EXPECT_LT(views["depth_error_median_m"], 0.01);
  EXPECT_GE(views["depth_error_mean_m"], views["depth_error_median_m"]);
}

TEST_F(EvaluateViewsTool, EvaluatesEveryNthFrameIntoASeparateFolder) {
  Succeeded(Slam(Room(), Output()));
  Succeeded(Judge(Output(), {"--every=8", "--output=" + Output("judged")}));
  EXPECT_EQ(Views(Output("judged"))["held_out"], false);
  EXPECT_EQ(Views(Output("judged"))["frames"], 3);
  EXPECT_FALSE(std::filesystem::exists(Output() + "/views.json"));
  EXPECT_TRUE(std::filesystem::exists(Output("judged") + "/view_pictures/02.png"));
  EXPECT_FALSE(std::filesystem::exists(Output("judged") + "/view_pictures/03.png"));
  const cv::Mat picture = cv::imread(Output("judged") + "/view_pictures/00.png");
  EXPECT_EQ(picture.cols, 3 * 160);
  EXPECT_EQ(picture.rows, 120 + 28);
  // The number of threads changes nothing. A new run removes earlier evaluations from its folder.
  Succeeded(Judge(Output(), {"--every=8", "--threads=1", "--nopictures"}));
  EXPECT_EQ(Views(Output()), Views(Output("judged")));
  EXPECT_FALSE(std::filesystem::exists(Output() + "/view_pictures/00.png"));
  ViewEvaluationOptions options;
  options.sequence.path = Room();
  options.run = Output();
  options.output = Output("two");
  options.every = 8;
  options.pictures = 2;
  EXPECT_EQ(EvaluateViews(options, [](int) {}).views.size(), 3u);
  EXPECT_TRUE(std::filesystem::exists(Output("two") + "/view_pictures/01.png"));
  EXPECT_FALSE(std::filesystem::exists(Output("two") + "/view_pictures/02.png"));
  Succeeded(Slam(Room(), Output()));
  EXPECT_FALSE(std::filesystem::exists(Output() + "/views.json"));
}

// The calibration of the run changes the projection and the measured depth.
TEST_F(EvaluateViewsTool, UsesTheCalibrationOfTheRun) {
  Succeeded(Slam(Room(), Output(), {"--hold_out=5", "--nocalibrate"}));
  const std::string path = Output() + "/poses.json";
  nlohmann::json poses = nlohmann::json::parse(ReadBytes(path));
  EXPECT_EQ(poses["calibration"], nullptr);
  Succeeded(Judge(Output()));
  const nlohmann::json as_given = Views(Output());
  poses["calibration"] = poses["camera"];
  poses["calibration"]["readout_s"] = 0;
  poses["calibration"]["inverse_depth_field"] = {-0.02, 0, 0, 0, 0, 0};
  std::ofstream(path) << poses;
  Succeeded(Judge(Output()));
  const nlohmann::json farther = Views(Output());
  EXPECT_EQ(farther["psnr_db"], as_given["psnr_db"]);
  // -0.02 1/m is 20 mm at 1 m and 80 mm at 2 m.
  EXPECT_GT(farther["depth_error_median_m"], 0.02);
  EXPECT_LT(farther["depth_error_median_m"], 0.3);
  // camera.yaml of the run repeats the same field. It must not be applied twice.
  std::ofstream(Output() + "/camera.yaml")
      << ReadBytes(Room() + "/camera.yaml") << "inverse_depth_field: [-0.02, 0., 0., 0., 0., 0.]\n";
  Succeeded(Judge(Output()));
  EXPECT_EQ(Views(Output()), farther);
  poses["calibration"]["inverse_depth_field"][0] = 0;
  poses["camera"]["cx"] = 12 + poses["camera"]["cx"].get<double>();
  std::ofstream(path) << poses;
  Succeeded(Judge(Output()));
  EXPECT_LT(Views(Output())["psnr_covered_db"], as_given["psnr_covered_db"].get<double>() - 3);
}

// A colour latency of 0.25 s belongs to a different pose. A file without this key (from before its
// estimation) means the input latency.
TEST_F(EvaluateViewsTool, UsesTheColorLatencyOfTheRun) {
  Succeeded(Slam(Room(), Output(), {"--hold_out=5", "--nocalibrate"}));
  const std::string path = Output() + "/poses.json";
  nlohmann::json poses = nlohmann::json::parse(ReadBytes(path));
  EXPECT_EQ(poses["color_latency_s"], 0);
  Succeeded(Judge(Output()));
  const nlohmann::json as_given = Views(Output());
  poses.erase("color_latency_s");
  std::ofstream(path) << poses;
  Succeeded(Judge(Output()));
  EXPECT_EQ(Views(Output()), as_given);
  // Registration of the colours corrects a small error.
  poses["color_latency_s"] = 0.02;
  std::ofstream(path) << poses;
  Succeeded(Judge(Output()));
  const double lost_db =
      as_given["psnr_covered_db"].get<double>() - Views(Output())["psnr_covered_db"].get<double>();
  EXPECT_GT(lost_db, 0.2);
  EXPECT_GT(Views(Output())["psnr_registered_db"],
            as_given["psnr_registered_db"].get<double>() - lost_db / 2);
  poses["color_latency_s"] = 0.25;
  std::ofstream(path) << poses;
  Succeeded(Judge(Output()));
  EXPECT_LT(Views(Output())["psnr_covered_db"], as_given["psnr_covered_db"].get<double>() - 1);
  EXPECT_EQ(Views(Output())["depth_error_median_m"], as_given["depth_error_median_m"]);
}

// Red frames differ from every view. Black frames are unsuitable: pixels (0, 0, 0) are not
// compared.
TEST_F(EvaluateViewsTool, SortsTheWorstViewFirst) {
  Succeeded(Slam(RoomWithRed({14}), Output(), {"--hold_out=5"}));
  Succeeded(Judge(Output()));
  const std::vector<std::string> rows = Lines(Output() + "/views.csv");
  const auto psnr = [&](int row) { return std::stod(rows[row].substr(rows[row].find(',') + 1)); };
  for (const int other : {1, 2, 4}) EXPECT_LT(psnr(3), psnr(other) - 3);
  const cv::Mat worst = cv::imread(Output() + "/view_pictures/00.png");
  EXPECT_EQ(worst.at<cv::Vec3b>(100, 80), cv::Vec3b(0, 0, 255));
}

TEST_F(EvaluateViewsTool, RejectsBadInput) {
  ExpectRefused(RunProgram("surfit_evaluate", {"--what=views"}), "--run");
  ExpectRefused(Judge(Output("none")), "none/summary.json");
  Succeeded(Slam(Room(), Output(), {"--last=3"}));
  ExpectRefused(Judge(Output(), {"--every=0"}), "--every", 0);
  std::filesystem::remove(Output() + "/map.ply");
  ExpectRefused(Judge(Output()), "map.ply");
  ExpectRefused(Slam(Room(), Output(), {"--hold_out=1"}), "hold_out", 1);
}

}  // namespace
}  // namespace surfit::testing
