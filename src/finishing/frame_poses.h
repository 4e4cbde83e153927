#pragma once

#include <optional>
#include <vector>

#include "finishing/posed_sequence.h"
#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Prepared frame of a sequence with its pose of the run.
struct FinalFrame {
  const RgbdFrame& frame;            // corrected by EstimatedSensor::Correct()
  const Image<float>& depth_m;       // without rolling shutter
  const CameraMotion& motion;        // at RgbdFrame::stamp_s
  const Rigid3d& world_from_camera;  // at RgbdFrame::stamp_s
};

struct FinalPose {
  Rigid3d world_from_camera;               // at RgbdFrame::stamp_s
  Rigid3d world_from_color;                // at RgbdFrame::color_stamp_s
  double cost_before = 0, cost_after = 0;  // of RegisteredColors; 0: not registered by colour
};

// Final poses of the frames of a sequence. A frame is registered to the final map twice:
//   1. by depth, with RegisterWithPrior() at a quarter of the resolution. The prior is the pose of
//      the run, with standard deviations of 5 mm and 5 mrad.
//   2. by colour, with RegisterColors(). The prior is the pose of step 1, with the covariance of
//      CovarianceByBlocks(). Its standard deviations are tripled, because the errors of depth
//      images have common causes.
// The map averages the errors of many frames, and colour constrains rotations better than depth.
class FramePoses {
 public:
  // Keeps the references. `sensor`: estimated sensor of the frames.
  FramePoses(const PosedSequence& known, const DepthSensor& sensor, const SurfelMap& map);

  // Registers a frame with colours. Keeps the pose of the run if the result contradicts it: the
  // squared change in standard deviations exceeds 38, the chi-square limit of 1e-6. If depth leaves
  // a direction unobservable, step 2 begins at the pose of the run, with standard deviations of 1
  // cm and 10 mrad. If the image lacks texture, the costs are 0.
  FinalPose Register(const FinalFrame& frame);

 private:
  struct DepthPose {
    Rigid3d world_from_camera;
    Matrix6d information;
  };

  std::optional<DepthPose> RegisterDepth(const FinalFrame& frame, const ModelView& view) const;

  const PosedSequence& known_;
  const SurfelMap& map_;
  const IcpOptions icp_;
  DepthSensor coarse_;   // of the rendered view
  DepthSensor sampled_;  // of the sampled depth
  int step_ = 1;         // of samples, px
  ModelRenderer renderer_{RenderOptions()};
};

// Trajectory with final poses. `poses`: final poses by position in the trajectory; std::nullopt:
// not registered. These frames move with their neighbours (CorrectTrajectory()). Returns the given
// trajectory if the sum of the costs of all frames decreases by less than 1 %. Then the poses of
// the run are nearly exact, as in simulations without noise.
Trajectory WithFinalPoses(const Trajectory& trajectory,
                          const std::vector<std::optional<FinalPose>>& poses);

}  // namespace surfit
