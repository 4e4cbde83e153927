#include "apps/export/color_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "finishing/color_registration.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

double SharpnessOf(const Image<Rgb8>& image) {
  const auto grey = [&](int u, int v) {
    const Rgb8 c = image(u, v);
    return c.r + 2 * c.g + c.b;
  };
  const double sum = ParallelSum(1, image.height() - 1, kRowsPerBlock, 0., [&](int begin, int end) {
    std::int64_t part = 0;
    for (int v = begin; v < end; ++v) {
      for (int u = 1; u < image.width() - 1; ++u) {
        const std::int64_t by_u = grey(u + 1, v) - grey(u - 1, v);
        const std::int64_t by_v = grey(u, v + 1) - grey(u, v - 1);
        part += by_u * by_u + by_v * by_v;
      }
    }
    return static_cast<double>(part);
  });
  return sum / static_cast<double>(image.size());
}

// Pose at a time close to a pose of the trajectory; std::nullopt if that is too far away.
std::optional<Rigid3d> PoseNear(const RecordedRun& run, const StampedPose& frame, double stamp_s) {
  constexpr double kMaxExtrapolation_s = 0.1, kSameTime_s = 1e-9;
  if (std::abs(stamp_s - frame.stamp_s) > kMaxExtrapolation_s) return {};
  if (auto pose = InterpolatePose(run.trajectory, stamp_s, kMaxExtrapolation_s, kSameTime_s)) {
    return pose;
  }
  return ExtrapolatePose(frame.world_from_camera, MotionAt(run.trajectory, frame.stamp_s),
                         stamp_s - frame.stamp_s);
}

}  // namespace

std::string ColorImage::Name() const {
  std::array<char, 40> name;
  std::snprintf(name.data(), name.size(), "%06d.png", index);
  return name.data();
}

ColorCamera GivenColorCamera(const SequenceInfo& info, const RecordedRun& run) {
  const RgbdCamera given = info.mirrored ? Mirrored(info.camera) : info.camera;
  ColorCamera color;
  color.readout_s = run.found.calibration ? run.found.calibration->readout_s : given.readout_s;
  if (!given.color_is_registered) {
    color.lens = given.color;
    color.color_from_depth = given.color_from_depth;
    return color;
  }
  color.lens = given.depth;
  if (run.found.calibration) {
    const PinholeCamera& found = run.found.calibration->camera;
    const double downsample = color.lens.fx / info.pinhole.fx;
    color.lens.fx = found.fx * downsample;
    color.lens.fy = found.fy * downsample;
    color.lens.cx = found.cx * downsample;
    color.lens.cy = found.cy * downsample;
  }
  return color;
}

std::vector<ColorImage> ListColorImages(const SequenceOptions& sequence, const RecordedRun& run,
                                        const std::function<void(int)>& progress,
                                        UnusedFrames* unused) {
  const RawSequence opened = OpenRawSequence(sequence);
  std::map<int, StampedPose> poses;
  std::size_t at = 0;
  for (const auto& [index, pose] : run.world_from_camera) {
    poses[index] = {run.trajectory[at++].stamp_s, pose};
  }
  std::vector<ColorImage> images;
  Image<Rgb8> previous;
  while (std::optional<RawFrame> raw = opened.frames->Next()) {
    const auto frame = poses.find(raw->head.index);
    if (frame == poses.end()) continue;
    progress(static_cast<int>(images.size()));
    Image<Rgb8> color;
    try {
      if (!raw->head.error.empty()) throw InputError(raw->head.error);
      FrameImages read = opened.frames->Read();
      RequireSizeOf(opened.info.camera, read);
      color = std::move(read.color);
    } catch (const InputError&) {
      ++unused->unreadable;
      continue;
    }
    if (color.empty()) {
      ++unused->without_color;
      continue;
    }
    if (color == previous) {
      ++unused->repeated;
      continue;
    }
    const double stamp_s =
        CaptureTimes(raw->stamps, opened.info.camera).color_s - run.found.color_latency_s;
    const std::optional<Rigid3d> pose = PoseNear(run, frame->second, stamp_s);
    if (pose) {
      images.push_back({raw->head.index, stamp_s, *pose,
                        MotionAt(run.trajectory, frame->second.stamp_s), SharpnessOf(color)});
    } else {
      ++unused->without_pose_at_time;
    }
    previous = std::move(color);
  }
  return images;
}

std::vector<ColorImage> ChooseImages(const std::vector<ColorImage>& images, int most) {
  const std::size_t count = images.size();
  if (most == 0 || count <= static_cast<std::size_t>(most)) return images;
  // Image motion of a point at this depth, in focal lengths.
  constexpr double kUsualDepth_m = 1.5;
  std::vector<double> path(count, 0);
  for (std::size_t i = 1; i < count; ++i) {
    const Rigid3d step = images[i - 1].world_from_depth.Inverse() * images[i].world_from_depth;
    path[i] = path[i - 1] + step.translation.norm() / kUsualDepth_m + RotationAngle(step.rotation);
  }
  // Each frame adds a tenth of the mean motion, so that a camera at rest gets images too.
  const double by_frame = 0.1 * path.back() / static_cast<double>(count) + 1e-9;
  for (std::size_t i = 0; i < count; ++i) path[i] += by_frame * static_cast<double>(i);
  const auto choose = [&](std::size_t parts) {
    std::vector<std::size_t> best(parts, count);
    for (std::size_t i = 0; i < count; ++i) {
      const double share = path[i] / path.back();
      const std::size_t part =
          std::min(parts - 1, static_cast<std::size_t>(share * static_cast<double>(parts)));
      if (best[part] == count || images[i].sharpness > images[best[part]].sharpness) best[part] = i;
    }
    best.erase(std::remove(best.begin(), best.end(), count), best.end());
    return best;
  };
  // Some parts have no image. Searches the largest number of parts with at most `most` images.
  std::vector<std::size_t> chosen = choose(most);
  std::size_t low = most, high = 16 * count;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    std::vector<std::size_t> finer = choose(middle);
    if (finer.size() <= static_cast<std::size_t>(most)) {
      low = middle;
      chosen = std::move(finer);
    } else {
      high = middle;
    }
  }
  std::vector<ColorImage> result;
  result.reserve(chosen.size());
  for (const std::size_t i : chosen) result.push_back(images[i]);
  return result;
}

namespace {

// Calls `call` with the position in `images`, the sequence and the raw frame.
template <typename Call>
void ReadFrames(const SequenceOptions& sequence, const std::vector<ColorImage>& images,
                const Call& call) {
  const RawSequence opened = OpenRawSequence(sequence);
  std::size_t next = 0;
  while (next < images.size()) {
    const std::optional<RawFrame> raw = opened.frames->Next();
    if (!raw) break;
    if (raw->head.index != images[next].index) continue;
    ThrowIf(!raw->head.error.empty(), raw->head.error);
    call(next++, opened, *raw);
  }
  ThrowIf(next < images.size(), sequence.path, ": the sequence has changed during the export");
}

}  // namespace

void ReadColorImages(const SequenceOptions& sequence, const std::vector<ColorImage>& images,
                     const std::function<void(std::size_t, const Image<Rgb8>&)>& call) {
  ReadFrames(sequence, images, [&](std::size_t i, const RawSequence& opened, const RawFrame&) {
    call(i, opened.frames->Read().color);
  });
}

void ReadDepthImages(const SequenceOptions& sequence, const std::vector<ColorImage>& images,
                     const std::function<void(std::size_t, const Image<float>&)>& call) {
  ReadFrames(sequence, images, [&](std::size_t i, const RawSequence& opened, const RawFrame& raw) {
    call(i, opened.MakeFrame(raw, opened.frames->Read()).depth_m);
  });
}

namespace {

Image<float> HighPass(const cv::Mat& log_brightness) {
  cv::Mat fine, coarse;
  cv::GaussianBlur(log_brightness, fine, cv::Size(), 1);
  cv::GaussianBlur(log_brightness, coarse, cv::Size(), 4);
  Image<float> result(fine.cols, fine.rows);
  cv::Mat(result.height(), result.width(), CV_32F, result.data()) = fine - coarse;
  return result;
}

cv::Mat LogBrightness(const Image<Rgb8>& color) {
  constexpr float kBlack = 16;  // avoids noise of dark pixels
  cv::Mat brightness(color.height(), color.width(), CV_32F);
  for (int v = 0; v < color.height(); ++v) {
    auto* const row = brightness.ptr<float>(v);
    for (int u = 0; u < color.width(); ++u) {
      const Rgb8 c = color(u, v);
      row[u] = std::log(kBlack + 0.25f * static_cast<float>(c.r + 2 * c.g + c.b));
    }
  }
  return brightness;
}

// Means of blocks. Columns and rows beyond the last complete block are left out, as in
// PinholeCamera::Binned().
cv::Mat Reduced(const cv::Mat& image, int halvings) {
  const int factor = 1 << halvings;
  const cv::Size size(image.cols / factor, image.rows / factor);
  cv::Mat reduced;
  cv::resize(image(cv::Rect(0, 0, size.width * factor, size.height * factor)), reduced, size, 0, 0,
             cv::INTER_AREA);
  return reduced;
}

}  // namespace

std::vector<Image<float>> FilteredBrightness(const Image<Rgb8>& color,
                                             const std::vector<int>& halvings) {
  const cv::Mat brightness = LogBrightness(color);
  std::vector<Image<float>> levels;
  levels.reserve(halvings.size());
  for (const int n : halvings)
    levels.push_back(HighPass(n == 0 ? brightness : Reduced(brightness, n)));
  return levels;
}

std::optional<BrightnessSample> BrightnessAt(const Image<float>& brightness, int halvings,
                                             const Eigen::Vector2d& pixel) {
  constexpr double kBorder_px = 2;
  const double factor = 1 << halvings;
  // Centre of the first block of factor x factor pixels: (factor - 1) / 2.
  const double u = (pixel.x() - 0.5 * (factor - 1)) / factor;
  const double v = (pixel.y() - 0.5 * (factor - 1)) / factor;
  if (!(u >= kBorder_px && v >= kBorder_px && u < brightness.width() - 1 - kBorder_px &&
        v < brightness.height() - 1 - kBorder_px)) {
    return {};
  }
  const int left = static_cast<int>(u), top = static_cast<int>(v);
  const double a = u - left, b = v - top;
  const double p = brightness(left, top), q = brightness(left + 1, top),
               r = brightness(left, top + 1), s = brightness(left + 1, top + 1);
  const double upper = p + a * (q - p), lower = r + a * (s - r);
  return BrightnessSample{upper + b * (lower - upper),
                          {((1 - b) * (q - p) + b * (s - r)) / factor, (lower - upper) / factor}};
}

}  // namespace surfit
