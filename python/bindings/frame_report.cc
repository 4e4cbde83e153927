#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/slam/slam.h"

namespace surfit::python {
namespace {

void BindFusionReport(py::module_& module) {
  BindReport<FusionReport>(module, "FusionReport", "Result of the fusion of a frame.")
      .def_readonly(FIELD(FusionReport, input_points), "pixels with depth and normal")
      .def_readonly(FIELD(FusionReport, merged_points), "input points merged with a surfel")
      .def_readonly(FIELD(FusionReport, covered_points),
                    "input points covered by a new surfel of a neighbouring pixel")
      .def_readonly(FIELD(FusionReport, merged), "updated surfels")
      .def_readonly(FIELD(FusionReport, added), "added surfels")
      .def_readonly(FIELD(FusionReport, refused), "surfels rejected because of max_map_points")
      .def_readonly(FIELD(FusionReport, removed), "removed surfels");
}

void BindStageTimes(py::module_& module) {
  BindReport<StageTimes>(module, "StageTimes", "Wall time per stage, ms.")
      .def_readonly("preprocess_ms", &StageTimes::preprocess_ms, "depth filter, normals, pyramid")
      .def_readonly(FIELD(StageTimes, predict_ms),
                    "rendering of the map, for this frame or in advance for the next frame")
      .def_readonly(FIELD(StageTimes, track_ms), "registration")
      .def_readonly(FIELD(StageTimes, fuse_ms), "fusion")
      .def_readonly(FIELD(StageTimes, correct_ms), "map correction");
}

std::optional<Rigid3d> PoseOfReport(const FrameReport& report) {
  if (!report.HasPose()) return std::nullopt;
  return report.world_from_camera;
}

}  // namespace

void BindFrameReport(py::module_& module) {
  BindFusionReport(module);
  BindStageTimes(module);
  BindReport<FrameReport>(module, "FrameReport", "Result of a frame.")
      .def_readonly(FIELD(FrameReport, index), "frame index")
      .def_readonly(FIELD(FrameReport, stamp_s), "capture time of depth, s")
      .def_property_readonly(
          "state", [](const FrameReport& report) { return ToString(report.state); },
          "first, tracked, degenerate (unobservable directions keep the prediction), frozen "
          "(duplicate depth), given (input pose), relocalised, new_map (first frame of a submap), "
          "or lost (no pose)")
      .def_property_readonly("world_from_camera", &PoseOfReport, "4 x 4, metres; None if lost")
      .def_readonly(FIELD(FrameReport, has_own_view), "True if the map was rendered for this frame")
      .def_readonly(FIELD(FrameReport, is_held_out),
                    "True if the frame is excluded from the map (SlamOptions.hold_out)")
      .def_readonly(FIELD(FrameReport, is_fused), "True if the frame was fused")
      .def_readonly(FIELD(FrameReport, found_by_search),
                    "True if the frame was tracked after a jump")
      .def_readonly(FIELD(FrameReport, icp), "registration of a tracked or lost frame")
      .def_property_readonly(
          "keyframe",
          [](const FrameReport& report) {
            return report.keyframe < 0 ? std::nullopt : std::optional<int>(report.keyframe);
          },
          "index of the last keyframe before this frame; None without keyframe")
      .def_readonly(FIELD(FrameReport, keyframe_from_camera),
                    "4 x 4, metres; identity without keyframe")
      .def_readonly(FIELD(FrameReport, covariance),
                    "6 x 6 of keyframe_from_camera, for the left perturbation (rotation, "
                    "translation), rad^2, m^2; None if unknown")
      .def_readonly(FIELD(FrameReport, fusion), "result of the fusion")
      .def_readonly(FIELD(FrameReport, times), "times of the stages");
}

}  // namespace surfit::python
