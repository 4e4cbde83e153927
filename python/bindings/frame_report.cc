// What became of one frame.
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/slam/slam.h"

namespace surfit::python {
namespace {

void BindFusionReport(py::module_& module) {
  BindReport<FusionReport>(module, "FusionReport", "What the fusion of one frame did.")
      .def_readonly(FIELD(FusionReport, input_points), "pixels with depth and normal")
      .def_readonly(FIELD(FusionReport, merged_points), "of those, that met a surfel")
      .def_readonly(FIELD(FusionReport, covered_points),
                    "points without one that a new surfel of a pixel beside stands for")
      .def_readonly(FIELD(FusionReport, merged), "surfels updated")
      .def_readonly(FIELD(FusionReport, added), "surfels")
      .def_readonly(FIELD(FusionReport, refused), "surfels that max_map_points left no place for")
      .def_readonly(FIELD(FusionReport, removed), "surfels");
}

void BindStageTimes(py::module_& module) {
  BindReport<StageTimes>(module, "StageTimes", "Wall time spent in each stage, milliseconds.")
      .def_readonly("preprocess_ms", &StageTimes::prepare_ms, "depth filter, normals, pyramid")
      .def_readonly(FIELD(StageTimes, predict_ms),
                    "drawing the map, for this frame or ahead for the next")
      .def_readonly(FIELD(StageTimes, track_ms), "registration")
      .def_readonly(FIELD(StageTimes, fuse_ms), "fusion")
      .def_readonly(FIELD(StageTimes, correct_ms), "of the map, by loops");
}

std::optional<Rigid3d> PoseOfReport(const FrameReport& report) {
  if (!report.HasPose()) return std::nullopt;
  return report.world_from_camera;
}

}  // namespace

void BindFrameReport(py::module_& module) {
  BindFusionReport(module);
  BindStageTimes(module);
  BindReport<FrameReport>(module, "FrameReport", "What became of one frame.")
      .def_readonly(FIELD(FrameReport, index), "the frame's")
      .def_readonly(FIELD(FrameReport, stamp_s), "the frame's")
      .def_property_readonly(
          "state", [](const FrameReport& report) { return ToString(report.state); },
          "first, tracked, degenerate (some directions as predicted), frozen (depth repeats the "
          "last frame's), given (fused at a given pose), relocalised (found by a keyframe), "
          "new_map (the first of a map apart), or lost: no pose, nothing fused")
      .def_property_readonly("world_from_camera", &PoseOfReport, "4 x 4, metres; None if lost")
      .def_readonly(FIELD(FrameReport, has_own_view), "the map was drawn for it")
      .def_readonly(FIELD(FrameReport, is_held_out),
                    "it is left out of the map (SlamOptions.hold_out)")
      .def_readonly(FIELD(FrameReport, is_fused), "into the map")
      .def_readonly(FIELD(FrameReport, found_again), "tracked after a jump")
      .def_readonly(FIELD(FrameReport, icp), "of a tracked or lost frame")
      .def_readonly(FIELD(FrameReport, fusion), "what it did to the map")
      .def_readonly(FIELD(FrameReport, times), "of the stages");
}

}  // namespace surfit::python
