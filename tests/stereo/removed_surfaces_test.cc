// Images of a rendered room, with the depth removed in cubes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <vector>

#include "finishing/stereo/unmeasured_surfaces.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"
#include "testing/pixels.h"
#include "testing/shared_data.h"

namespace surfit::testing {
namespace {

constexpr int kStride = 3;
constexpr double kRemovedRatio = 0.2;
constexpr float kHalfCube_m = 0.4f;
constexpr float kMinContrast = 4;  // standard deviation of the brightness of a textured window

struct PosedFrame {
  RgbdFrame frame;
  Rigid3d world_from_camera;
};

std::vector<PosedFrame> ReadFrames(const FrameSource& source, FrameSource* frames) {
  std::vector<PosedFrame> read;
  while (std::optional<ReadResult> result = frames->Next()) {
    if (!result->frame) continue;
    const auto pose = InterpolatePose(source.info().ground_truth, result->frame->stamp_s);
    if (pose) read.push_back({*std::move(result->frame), *pose});
  }
  return read;
}

// Cubes of the world frame around random measured points.
class RemovedCubes {
 public:
  bool Contain(const Eigen::Vector3f& in_world) const {
    return std::any_of(centres_.begin(), centres_.end(), [&](const Eigen::Vector3f& centre) {
      return ((in_world - centre).array().abs() < kHalfCube_m).all();
    });
  }

  // Adds cubes until they contain the ratio of the measured pixels.
  void Choose(const std::vector<PosedFrame>& frames, const PinholeCamera& camera) {
    std::mt19937 random(1);
    const auto below = [&](std::size_t end) { return random() % end; };
    while (RatioOf(frames, camera) < kRemovedRatio) {
      const PosedFrame& chosen = frames[below(frames.size())];
      const int u = static_cast<int>(below(camera.width)),
                v = static_cast<int>(below(camera.height));
      const float z = chosen.frame.depth_m(u, v);
      if (z > 0) centres_.push_back(PointAt(chosen, camera, u, v));
    }
  }

  static Eigen::Vector3f PointAt(const PosedFrame& frame, const PinholeCamera& camera, int u,
                                 int v) {
    return PosedCamera(camera, frame.world_from_camera)
        .PointInWorld(frame.frame.depth_m(u, v) * camera.Ray(u, v).cast<float>());
  }

 private:
  double RatioOf(const std::vector<PosedFrame>& frames, const PinholeCamera& camera) const {
    int measured = 0, removed = 0;
    for (const PosedFrame& frame : frames) {
      for (int v = 0; v < camera.height; v += 16) {
        for (int u = 0; u < camera.width; u += 16) {
          if (!(frame.frame.depth_m(u, v) > 0)) continue;
          ++measured;
          removed += Contain(PointAt(frame, camera, u, v)) ? 1 : 0;
        }
      }
    }
    return static_cast<double>(removed) / measured;
  }

  std::vector<Eigen::Vector3f> centres_;
};

bool IsTextured(const Image<std::uint8_t>& brightness, int u, int v) {
  if (u < 4 || v < 3 || u >= brightness.width() - 4 || v >= brightness.height() - 3) return false;
  float sum = 0, squares = 0, count = 0;
  for (const auto [x, y] : Pixels(u - 4, u + 5, v - 3, v + 4)) {
    const float value = brightness(x, y);
    sum += value, squares += value * value, ++count;
  }
  return squares / count - sum * sum / (count * count) > kMinContrast * kMinContrast;
}

// Pixels with texture whose depth was removed.
struct Returned {
  int textured = 0;
  int by_stereo = 0;  // the map shows a surfel by stereo
  int accurate = 0;   // these, within 2 cm
  int close = 0;      // these, within 3 % of their depth
};

// Bounds: 0.8 times the measured ratios of 96, 39 and 87 %. The median depth is 3.7 m.
TEST(RemovedSurfaces, ReturnWhereTheyHaveTexture) {
  SURFIT_REQUIRE_SHARED_DATA("icl_office");
  SequenceOptions options;
  options.path = SharedData("icl_office");
  options.stride = kStride;
  const std::unique_ptr<FrameSource> source = OpenSequence(options);
  std::vector<PosedFrame> frames = ReadFrames(*source, source.get());
  ASSERT_GT(frames.size(), 60u);
  const DepthSensor sensor = source->info().sensor();
  RemovedCubes cubes;
  cubes.Choose(frames, sensor.camera);

  std::vector<StereoKeyframe> keyframes, complete;
  SurfelMap map;
  Fusion fusion({});
  for (PosedFrame& posed : frames) {
    const Rigid3d& pose = posed.world_from_camera;
    complete.push_back(
        MakeStereoKeyframe(posed.frame, posed.frame.depth_m, sensor, {}, pose, pose));
    Image<float> kept_m = posed.frame.depth_m;
    for (const auto [u, v] : PixelsOf(kept_m)) {
      if (kept_m(u, v) > 0 && cubes.Contain(RemovedCubes::PointAt(posed, sensor.camera, u, v))) {
        kept_m(u, v) = 0;
      }
    }
    posed.frame.depth_m = kept_m;
    keyframes.push_back(MakeStereoKeyframe(posed.frame, kept_m, sensor, {}, pose, pose));
    const FramePyramid pyramid = PreprocessDepth(kept_m, sensor, {});
    fusion.Fuse(posed.frame, pyramid.levels.front(), pose, &map);
  }
  const auto found = FindUnmeasuredSurfaces(keyframes, map, sensor, {}, false);
  ASSERT_TRUE(found);
  map.Append(found->surfels);

  Returned returned;
  ModelRenderer renderer{RenderOptions()};
  for (std::size_t i = 0; i < keyframes.size(); i += 6) {
    DepthSensor small = sensor;
    small.camera = keyframes[i].camera;
    const ModelView view = renderer.Render(map, small, keyframes[i].world_from_camera);
    const Image<std::uint8_t> brightness = Brightness(keyframes[i].color);
    for (const auto [u, v] : PixelsOf(brightness)) {
      const float truth_m = complete[i].measured_m(u, v);
      if (!(truth_m > 0) || keyframes[i].measured_m(u, v) > 0) continue;
      if (!IsTextured(brightness, u, v)) continue;
      ++returned.textured;
      const std::int32_t id = view.surfel_index(u, v);
      if (id == ModelView::kNoSurfel || !map[id].from_stereo) continue;
      ++returned.by_stereo;
      const float error_m = std::abs(view.surface.vertex.z(u, v) - truth_m);
      returned.accurate += error_m < 0.02f ? 1 : 0;
      returned.close += error_m < 0.03f * truth_m ? 1 : 0;
    }
  }
  std::printf("textured pixels without depth: %d, returned %d, within 2 cm %d, within 3 %% %d\n",
              returned.textured, returned.by_stereo, returned.accurate, returned.close);
  EXPECT_GT(returned.textured, 20000);
  EXPECT_GT(returned.by_stereo, 0.85 * returned.textured);
  EXPECT_GT(returned.accurate, 0.3 * returned.by_stereo);
  EXPECT_GT(returned.close, 0.7 * returned.by_stereo);
}

}  // namespace
}  // namespace surfit::testing
