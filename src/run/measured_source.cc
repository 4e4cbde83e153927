#include "run/measured_source.h"

#include <glog/logging.h>

#include <string>
#include <vector>

#include "calibration/calibrator.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

std::string WarningOf(const NoiseReport& noise, const SlamRunOptions& options) {
  const std::string fact =
      Concat("the depth noise of the first ", noise.frames, " frames is ", *noise.measured,
             " 1/m, and inverse_depth_sigma is ", noise.start, " 1/m: ");
  if (noise.is_applied)
    return Concat(fact, "the run uses ", noise.used, " 1/m; --inverse_depth_sigma fixes the noise");
  const bool is_option = options.sequence.inverse_depth_sigma.has_value();
  return Concat(fact, is_option ? "the option is used" : "the runs of a session keep their sensor",
                "; poses may be less accurate");
}

}  // namespace

void MeasuredSource::ReadFirstFrames() {
  try {
    while (first_.size() < MeasuredNoise::kFrames) {
      std::optional<ReadResult> result = source_->Next();
      if (!result) break;
      first_.push_back(*std::move(result));
    }
  } catch (...) {
    error_ = std::current_exception();
  }
}

NoiseReport MeasuredSource::Measure(const SlamRunOptions& options) {
  const DepthNoise& start = info().camera.noise;
  NoiseReport noise;
  noise.start = noise.used = start.inverse_depth_sigma;
  if (options.OffersFrames() || IsLive(options.sequence)) return noise;
  ReadFirstFrames();
  std::vector<Image<float>> depths_m;
  for (const ReadResult& result : first_) {
    if (result.frame) depths_m.push_back(result.frame->depth_m);
  }
  noise.frames = static_cast<int>(depths_m.size());
  const std::optional<MeasuredNoise> measured = MeasureNoise(depths_m, info().pinhole);
  if (!measured) return noise;
  noise.measured = measured->inverse_depth_sigma;
  noise.pairs = measured->pairs;
  noise.samples = measured->samples;
  if (!measured->Contradicts(start)) return noise;
  noise.is_applied = !options.sequence.inverse_depth_sigma && options.session.empty();
  if (noise.is_applied) noise.used = measured->Noise().inverse_depth_sigma;
  LOG(WARNING) << WarningOf(noise, options);
  return noise;
}

std::optional<ReadResult> MeasuredSource::Next() {
  if (first_.empty()) {
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    return source_->Next();
  }
  std::optional<ReadResult> result = std::move(first_.front());
  first_.pop_front();
  return result;
}

}  // namespace surfit
