// Classes of options. Parts are bound before the classes that contain them.
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
  BindOptions<RobustKernel>(m, "RobustKernel", "Robust kernel of residuals.");
  BindOptions<ErrorModel>(m, "ErrorModel",
                          "Weight of residuals: sigma^2 = floor_sigma_m^2 + (sigma of depth)^2.");
  BindOptions<AssociationGates>(m, "AssociationGates", "Thresholds of correspondences.");
  BindOptions<ObservabilityOptions>(m, "ObservabilityOptions",
                                    "Thresholds of observable directions of motion.");
  BindOptions<IcpOptions>(m, "IcpOptions", "Options of ICP.");
  BindOptions<PreprocessOptions>(m, "PreprocessOptions",
                                 "Depth filter, and computation of vertex and normal maps.");
  BindOptions<FitCriteria>(m, "FitCriteria", "Acceptance criteria of a registration.");
  BindOptions<InitializeOptions>(m, "InitializeOptions",
                                 "Initial pose of a registration, and its acceptance criteria.");
  BindOptions<CloudNormalOptions>(m, "CloudNormalOptions", "Normal estimation in point clouds.");
  BindOptions<CloudSensor>(m, "CloudSensor", "Sensor position and noise of point clouds.");
  BindOptions<RegisterCloudsOptions>(m, "RegisterCloudsOptions", "Registration of two clouds.");
  m.def("far_icp_options", &GlobalIcpOptions,
        "Options of ICP for two frames with a larger distance than consecutive frames.");
}

void BindLoopOptions(py::module_& m) {
  BindOptions<KeyframeOptions>(m, "KeyframeOptions", "Selection of keyframes.");
  BindOptions<PlaceViewOptions>(m, "PlaceViewOptions", "Data stored per keyframe.");
  BindOptions<PlaceIndexOptions>(m, "PlaceIndexOptions", "Place recognition.");
  BindOptions<VerifyLoopOptions>(m, "VerifyLoopOptions", "Verification of loop candidates.");
  BindOptions<FindLoopsOptions>(m, "FindLoopsOptions", "Search for loop candidates.");
  BindOptions<RelocalizeOptions>(m, "RelocalizeOptions", "Relocalisation.");
  BindOptions<EdgeNoise>(m, "EdgeNoiseOptions", "Uncertainty added to pose graph edges.");
  BindOptions<PoseGraphOptions>(m, "PoseGraphOptions", "Pose graph optimisation.");
  BindOptions<LoopOptions>(m, "LoopOptions", "Loop closure.");
  BindOptions<PriorOptions>(m, "PriorOptions", "Prior of the input calibration.");
  BindOptions<RefinementOptions>(m, "RefinementOptions", "Joint refinement of keyframes.");
  BindOptions<CalibrationOptions>(m, "CalibrationOptions",
                                  "Calibration of the depth camera during tracking.");
}

void BindEvaluationOptions(py::module_& m) {
  BindOptions<MatchOptions>(m, "MatchOptions", "Association of poses by time.");
  BindOptions<RelativePoseErrorOptions>(m, "RelativePoseErrorOptions",
                                        "Interval of the relative pose error.");
  BindOptions<TrajectoryEvaluationOptions>(m, "TrajectoryEvaluationOptions",
                                           "Evaluation of a trajectory.");
}

}  // namespace

void BindAllOptions(py::module_& m) {
  BindOptions<RectifyOptions>(m, "RectifyOptions", "Preparation of images.");
  BindOptions<SequenceOptions>(m, "SequenceOptions",
                               "Input sequence, with its frames and its camera.");
  BindRegistrationOptions(m);
  BindLoopOptions(m);
  BindEvaluationOptions(m);
  BindOptions<FusionOptions>(m, "FusionOptions", "Fusion of frames into surfels.");
  BindOptions<RenderOptions>(m, "RenderOptions", "Rendering of the map for tracking.");
  BindOptions<SlamOptions>(m, "SlamOptions", "Tracking and mapping.");
  BindOptions<SlamRunOptions>(m, "SlamRunOptions", "Options of run_slam().");
  BindOptions<RefineRunOptions>(m, "RefineRunOptions", "Options of refine_run().");
  BindOptions<ViewEvaluationOptions>(m, "ViewEvaluationOptions", "Options of evaluate_views().");
  BindOptions<MapErrorOptions>(m, "MapErrorOptions", "Options of evaluate_map().");
  BindOptions<MeshOptions>(m, "MeshOptions", "Resolution, smoothness and extent of a mesh.");
}

}  // namespace surfit::python
