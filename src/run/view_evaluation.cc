#include "surfit/run/view_evaluation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "run/output_files.h"
#include "run/output_folder.h"
#include "run/rolled_view.h"
#include "run/view_files.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/evaluation/error_statistics.h"
#include "surfit/evaluation/image_error.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/frame_source.h"
#include "surfit/io/point_cloud.h"
#include "surfit/mapping/blended_view.h"

namespace surfit {
namespace {

constexpr int kReadAhead = 4;

// What a run has left of itself.
struct RecordedRun {
  SurfelMap map;
  Trajectory trajectory;
  std::map<int, Rigid3d> world_from_camera;     // by the frame's index
  std::optional<DepthCalibration> calibration;  // that the run found
  double color_latency_s = 0;                   // likewise, beyond the given one
  std::set<int> held_out;                       // frames
};

void ReadPoses(const std::string& path, RecordedRun* run) {
  const Json json = ReadJson(path);
  try {
    for (const Json& row : json.at("poses")) {
      const auto number = [&](int i) { return row.at(i).get<double>(); };
      const Eigen::Quaterniond rotation(number(8), number(5), number(6), number(7));
      const Rigid3d pose(rotation.normalized(), {number(2), number(3), number(4)});
      run->trajectory.push_back({number(1), pose});
      run->world_from_camera[row.at(0).get<int>()] = pose;
    }
    run->color_latency_s = json.value("color_latency_s", 0.);
    const Json& found = json.at("calibration");
    if (!found.is_null()) {
      run->calibration.emplace();
      run->calibration->camera = CameraFromJson(json.at("camera"));
      found.at("inverse_depth_field").get_to(run->calibration->field.coefficients);
      run->calibration->readout_s = found.at("readout_s");
    }
  } catch (const Json::exception& error) {
    throw InputError(Concat(path, ": incomplete: ", error.what()));
  }
}

RecordedRun ReadRecordedRun(const std::string& folder) {
  RecordedRun run;
  ReadPoses(folder + "/poses.json", &run);
  const Json summary = ReadJson(folder + "/summary.json");
  for (const Json& frame : summary.value("held_out_frames", Json::array())) {
    if (frame.is_number_integer()) run.held_out.insert(frame.get<int>());
  }
  run.map.Append(ReadSurfelPly(folder + "/map.ply"));
  return run;
}

PixelMask MaskOf(const Image<Rgb8>& color) {
  PixelMask mask(color.width(), color.height());
  std::transform(color.begin(), color.end(), mask.begin(),
                 [](Rgb8 pixel) { return static_cast<std::uint8_t>(pixel != Rgb8()); });
  return mask;
}

void CompareColor(const Image<Rgb8>& frame, const BlendedView& drawn, ViewError* error) {
  const PixelMask all = MaskOf(frame);
  PixelMask covered = all;
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (!(drawn.depth_m[i] > 0)) covered[i] = 0;
  }
  error->psnr_db = Psnr(drawn.color, frame, all);
  error->psnr_covered_db = Psnr(drawn.color, frame, covered);
  const Image<float> similarity = StructuralSimilarity(drawn.color, frame);
  error->ssim = MeanOf(similarity, all);
  error->ssim_covered = MeanOf(similarity, covered);
  const auto pixels = static_cast<double>(std::max<std::size_t>(1, CountOf(all)));
  error->coverage = static_cast<double>(CountOf(covered)) / pixels;
}

void CompareDepth(const Image<float>& frame_m, const Image<float>& drawn_m, ViewError* error) {
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < frame_m.size(); ++i) {
    if (frame_m[i] > 0 && drawn_m[i] > 0) errors_m.push_back(std::abs(frame_m[i] - drawn_m[i]));
  }
  if (errors_m.empty()) return;
  const ErrorStatistics statistics = Summarize(std::move(errors_m));
  error->depth_error_median_m = statistics.median;
  error->depth_error_mean_m = statistics.mean;
}

ViewError MeanOf(const std::vector<JudgedView>& views) {
  ViewError mean;
  for (const auto field : {&ViewError::psnr_covered_db, &ViewError::ssim_covered,
                           &ViewError::psnr_db, &ViewError::ssim, &ViewError::coverage,
                           &ViewError::depth_error_median_m, &ViewError::depth_error_mean_m}) {
    for (const JudgedView& view : views) mean.*field += view.error.*field;
    mean.*field /= static_cast<double>(views.size());
  }
  return mean;
}

class Judge {
 public:
  explicit Judge(const ViewEvaluationOptions& options)
      : options_(options),
        folder_(options.output.empty() ? options.run : options.output),
        run_(ReadRecordedRun(options.run)),
        source_(ReadAhead(OpenSequence(options.sequence), kReadAhead)),
        owned_(folder_, ViewFileNames()) {
    result_.held_out = !run_.held_out.empty();
    RequireCameraOfFrames();
  }

  ViewEvaluation Evaluate(const std::function<void(int)>& progress) {
    WorstViews worst(options_.pictures);
    while (const std::optional<ReadResult> read = source_->Next()) {
      const auto pose = run_.world_from_camera.find(read->index);
      if (!read->frame || pose == run_.world_from_camera.end() || !IsNext(read->index)) continue;
      if (read->frame->color.empty()) {
        ++result_.without_color;
        continue;
      }
      worst.Offer(Compare(*read->frame, pose->second));
      progress(static_cast<int>(result_.views.size()));
    }
    if (result_.views.empty()) {
      throw InputError(Concat(options_.run, ": no frame with colour and a pose to be judged by"));
    }
    result_.mean = MeanOf(result_.views);
    result_.worst_view = worst.Write(folder_);
    WriteViewFiles(result_, folder_);
    return result_;
  }

 private:
  bool IsNext(int frame) {
    if (result_.held_out) return run_.held_out.count(frame) > 0;
    return posed_count_++ % options_.every == 0;
  }

  void RequireCameraOfFrames() const {
    if (!run_.calibration) return;
    const PinholeCamera &found = run_.calibration->camera, &frames = source_->info().pinhole;
    if (found.width == frames.width && found.height == frames.height) return;
    throw InputError(Concat(options_.run, "/poses.json: the camera has ", found.width, " x ",
                            found.height, " pixels, must have ", frames.width, " x ", frames.height,
                            " as the frames"));
  }

  // As the run saw frames in the end.
  DepthSensor Sensor() const {
    DepthSensor sensor = source_->info().sensor();
    if (run_.calibration) {
      sensor.camera = run_.calibration->camera;
      sensor.readout_s = run_.calibration->readout_s;
    }
    return sensor;
  }
  Image<float> Measured(Image<float> depth_m) const {
    if (run_.calibration) {
      CorrectDepth(run_.calibration->camera, run_.calibration->field, &depth_m);
    }
    return depth_m;
  }

  ComparedView Compare(const RgbdFrame& frame, const Rigid3d& world_from_camera) {
    const DepthSensor sensor = Sensor();
    const CameraMotion motion = MotionAt(run_.trajectory, frame.stamp_s);
    const BlendedView drawn =
        DrawBlended(run_.map, {WithRollMargin(sensor.camera), sensor.noise}, world_from_camera);
    const double offset_s = frame.color_stamp_s - run_.color_latency_s - frame.stamp_s;
    const BlendedView of_color = Rolled(drawn, sensor.camera, motion, {offset_s, sensor.readout_s});
    const BlendedView of_depth = Rolled(drawn, sensor.camera, motion, {0, sensor.readout_s});
    JudgedView view;
    view.frame = frame.index;
    CompareColor(frame.color, of_color, &view.error);
    CompareDepth(Measured(frame.depth_m), of_depth.depth_m, &view.error);
    result_.views.push_back(view);
    return {view, frame.color, of_color.color};
  }

  const ViewEvaluationOptions& options_;
  const std::string folder_;
  const RecordedRun run_;
  const std::unique_ptr<FrameSource> source_;
  const OutputFolder owned_;
  int posed_count_ = 0;  // frames that have one
  ViewEvaluation result_;
};

}  // namespace

ViewEvaluation EvaluateViews(const ViewEvaluationOptions& options,
                             const std::function<void(int views)>& progress) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  return Judge(options).Evaluate(progress);
}

}  // namespace surfit
