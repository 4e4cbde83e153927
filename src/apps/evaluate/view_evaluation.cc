#include "apps/evaluate/view_evaluation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "apps/evaluate/image_error.h"
#include "apps/evaluate/rolling_shutter_view.h"
#include "apps/evaluate/view_files.h"
#include "finishing/color_registration.h"
#include "io/files/output_folder.h"
#include "mapping/rendering/blended_view.h"
#include "output/recorded_run.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/evaluation/error_statistics.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

constexpr int kReadAhead = 4;
constexpr int kRegisteredColumns = 320;  // approximate image width for colour registration

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
  error->psnr_covered_by_gain_db = PsnrByGain(drawn.color, frame, covered);
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

ViewError MeanOf(const std::vector<EvaluatedView>& views) {
  ViewError mean;
  for (const auto field :
       {&ViewError::psnr_covered_db, &ViewError::ssim_covered, &ViewError::psnr_db,
        &ViewError::ssim, &ViewError::psnr_covered_by_gain_db, &ViewError::psnr_registered_db,
        &ViewError::ssim_registered, &ViewError::coverage, &ViewError::depth_error_median_m,
        &ViewError::depth_error_mean_m}) {
    for (const EvaluatedView& view : views) mean.*field += view.error.*field;
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
    map_.Append(ReadSurfelPly(options.run + "/map.ply"));
    result_.held_out = !run_.held_out.empty();
    RequireCameraOfFrames(run_, options.run, source_->info().pinhole);
  }

  ViewEvaluation Evaluate(const std::function<void(int)>& progress) {
    WorstViews worst(options_.pictures);
    while (std::optional<ReadResult> read = source_->Next()) {
      const auto pose = run_.world_from_camera.find(read->index);
      if (!read->frame || pose == run_.world_from_camera.end() || !IsNext(read->index)) continue;
      if (read->frame->color.empty()) {
        ++result_.without_color;
        continue;
      }
      run_.found.Correct(&*read->frame);
      worst.Offer(Compare(*read->frame, pose->second));
      progress(static_cast<int>(result_.views.size()));
    }
    if (result_.views.empty()) {
      throw InputError(Concat(options_.run, ": no frame has both colour and a pose"));
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

  ComparedView Compare(const RgbdFrame& frame, const Rigid3d& world_from_camera) {
    const DepthSensor sensor = run_.found.Of(source_->info().sensor());
    const CameraMotion motion = MotionAt(run_.trajectory, frame.stamp_s);
    const BlendedView drawn =
        DrawBlended(map_, {WithRollMargin(sensor.camera), sensor.noise}, world_from_camera);
    const double offset_s = frame.color_stamp_s - frame.stamp_s;
    const BlendedView of_color = Rolled(drawn, sensor.camera, motion, {offset_s, sensor.readout_s});
    const BlendedView of_depth = Rolled(drawn, sensor.camera, motion, {0, sensor.readout_s});
    EvaluatedView view;
    view.frame = frame.index;
    CompareColor(frame.color, of_color, &view.error);
    CompareDepth(frame.depth_m, of_depth.depth_m, &view.error);
    CompareRegistered(frame, sensor, motion, ExtrapolatePose(world_from_camera, motion, offset_s),
                      &view.error);
    result_.views.push_back(view);
    return {view, frame.color, of_color.color};
  }

  void CompareRegistered(const RgbdFrame& frame, const DepthSensor& sensor,
                         const CameraMotion& motion, const Rigid3d& expected,
                         ViewError* error) const {
    DepthSensor coarse = sensor;
    coarse.camera = sensor.camera.Binned(std::max(1, sensor.camera.width / kRegisteredColumns));
    const RegisteredColors by_color =
        RegisterColors(frame.color, DrawBlended(map_, coarse, expected), coarse, motion, expected,
                       {expected}, expected);
    const BlendedView drawn =
        DrawBlended(map_, {WithRollMargin(sensor.camera), sensor.noise}, by_color.world_from_color);
    ViewError registered;
    CompareColor(frame.color, Rolled(drawn, sensor.camera, motion, {0, sensor.readout_s}),
                 &registered);
    error->psnr_registered_db = registered.psnr_covered_db;
    error->ssim_registered = registered.ssim_covered;
  }

  const ViewEvaluationOptions& options_;
  const std::string folder_;
  const RecordedRun run_;
  SurfelMap map_;
  const std::unique_ptr<FrameSource> source_;
  const OutputFolder owned_;
  int posed_count_ = 0;
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
