// The classes of options. What is a part of another one comes first.
#include "apps/evaluate/view_evaluation.h"
#include "apps/solvers/refine_run.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/mesh/mesh_surfels.h"
#include "surfit/registration/register_clouds.h"
#include "surfit/run/slam_run.h"

namespace surfit::python {
namespace {

void BindRegistrationOptions(py::module_& m) {
  BindOptions<RobustKernel>(m, "RobustKernel", "How large residuals lose their weight.");
  BindOptions<ErrorModel>(
      m, "ErrorModel",
      "What a residual is worth: sigma^2 = floor_sigma_m^2 + (the depth's sigma)^2.");
  BindOptions<AssociationGates>(m, "AssociationGates",
                                "What a pair of points must satisfy beyond being valid.");
  BindOptions<HeldOptions>(
      m, "HeldOptions", "What it takes for a direction of motion to be constrained by the data.");
  BindOptions<IcpOptions>(m, "IcpOptions", "How two surfaces are registered.");
  BindOptions<PreprocessOptions>(m, "PreprocessOptions",
                                 "How a depth image becomes vertex and normal maps.");
  BindOptions<FitCriteria>(m, "FitCriteria", "What a fit must show to be believed.");
  BindOptions<InitializeOptions>(
      m, "InitializeOptions",
      "Where registration starts, and what a fit must show that started from afar.");
  BindOptions<CloudNormalOptions>(m, "CloudNormalOptions",
                                  "How normals come from the points around each point of a cloud.");
  BindOptions<CloudSensor>(m, "CloudSensor", "Where clouds were measured from, and how well.");
  BindOptions<RegisterCloudsOptions>(m, "RegisterCloudsOptions", "How two clouds are registered.");
  m.def("far_icp_options", &FarIcpOptions,
        "The options of ICP for two frames that may lie farther apart than the next frame from the "
        "map.");
}

void BindLoopOptions(py::module_& m) {
  BindOptions<KeyframeOptions>(m, "KeyframeOptions", "When a frame becomes a keyframe.");
  BindOptions<PlaceViewOptions>(m, "PlaceViewOptions", "What is kept of a keyframe.");
  BindOptions<PlaceIndexOptions>(m, "PlaceIndexOptions", "How places are looked up.");
  BindOptions<VerifyLoopOptions>(m, "VerifyLoopOptions", "How a loop is verified.");
  BindOptions<FindLoopsOptions>(m, "FindLoopsOptions", "Which keyframes may be joined.");
  BindOptions<RelocalizeOptions>(m, "RelocalizeOptions", "How a lost camera is found.");
  BindOptions<EdgeNoise>(m, "EdgeNoiseOptions", "Errors that registrations do not know of.");
  BindOptions<PoseGraphOptions>(m, "PoseGraphOptions", "How a pose graph is optimised.");
  BindOptions<LoopOptions>(m, "LoopOptions", "How loops are closed.");
  BindOptions<PriorOptions>(m, "PriorOptions", "What is known of a given calibration.");
  BindOptions<RefinementOptions>(m, "RefinementOptions", "How keyframes are refined.");
  BindOptions<CalibrationOptions>(m, "CalibrationOptions",
                                  "How the depth camera is calibrated while it is tracked.");
}

void BindEvaluationOptions(py::module_& m) {
  BindOptions<MatchOptions>(m, "MatchOptions", "Which poses belong to the same moment.");
  BindOptions<RelativePoseErrorOptions>(m, "RelativePoseErrorOptions",
                                        "The interval over which drift is measured.");
  BindOptions<TrajectoryEvaluationOptions>(m, "TrajectoryEvaluationOptions",
                                           "How a trajectory is compared with the ground truth.");
}

}  // namespace

void BindAllOptions(py::module_& m) {
  BindOptions<PrepareOptions>(m, "PrepareOptions", "How images become frames.");
  BindOptions<SequenceOptions>(m, "SequenceOptions",
                               "Which frames of which sequence to read, and with what camera.");
  BindRegistrationOptions(m);
  BindLoopOptions(m);
  BindEvaluationOptions(m);
  BindOptions<FusionOptions>(m, "FusionOptions", "How frames become surfels.");
  BindOptions<RenderOptions>(m, "RenderOptions", "How the map is drawn for tracking.");
  BindOptions<SlamOptions>(m, "SlamOptions", "How the camera is tracked and the map is made.");
  BindOptions<SlamRunOptions>(m, "SlamRunOptions", "What a run is to do.");
  BindOptions<RefineRunOptions>(m, "RefineRunOptions", "What is refined, and with which frames.");
  BindOptions<ViewEvaluationOptions>(m, "ViewEvaluationOptions",
                                     "Which run is judged by its views, and by which of them.");
  BindOptions<MapErrorOptions>(m, "MapErrorOptions", "How a map is compared with its reference.");
  BindOptions<MeshOptions>(m, "MeshOptions", "How fine a mesh is, how smooth, how far it reaches.");
}

}  // namespace surfit::python
