#include "surfit/core/options.h"

#include <cmath>

#include "registration/icp/icp_level.h"
#include "surfit/core/error.h"
#include "surfit/registration/global_registration.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"
#include "surfit/registration/register_clouds.h"

namespace surfit {
namespace {

class PointText final : public OptionText {
 public:
  explicit PointText(Eigen::Vector3d* point) : point_(point) {}
  std::string Get() const override {
    return OptionToText(std::vector<double>(point_->data(), point_->data() + 3));
  }
  void Set(const std::string& text) override {
    *point_ = Eigen::Vector3d(NumbersFromText(text, 3).data());
  }
  const std::type_info& type() const override { return typeid(*point_); }
  void* field() override { return point_; }

 private:
  Eigen::Vector3d* point_;
};

}  // namespace

void ErrorModel::Visit(OptionVisitor& v) {
  v.Add(
      floor_sigma_m, "floor_sigma_m",
      "standard deviation of the errors of map, normals and calibration, added to the depth noise",
      Positive());
  v.AddPart(kernel, "kernel", "robust kernel of the residuals");
  v.Add(photometric_weight, "photometric_weight", "weight of photometric residuals",
        ZeroIs("geometric residuals only"), AsFlag());
  v.Add(intensity_sigma, "intensity_sigma",
        "standard deviation of photometric residuals, for intensities from 0 to 1", Positive());
  v.AddPart(intensity_kernel, "intensity_kernel", "robust kernel of photometric residuals",
            NoFlags());
}

void ObservabilityOptions::Visit(OptionVisitor& v) {
  v.Add(min_eigenvalue, "min_eigenvalue",
        "minimum eigenvalue of an observable direction, unitless; the pose does not move along "
        "other directions",
        AtLeast(0), Below(1));
  v.Add(
      min_information_ratio, "min_information_ratio",
      "minimum ratio of the information along an observable direction to the spurious information "
      "from noise of the normals",
      ZeroIs("off"));
}

void AssociationGates::Visit(OptionVisitor& v) {
  v.Add(max_distance_m, "max_distance_m",
        "maximum distance of corresponding points on the finest level",
        ZeroIs("off; surfit_register: from the point spacing"), AsFlag());
  v.Add(max_normal_angle_rad, "max_normal_angle_rad",
        "maximum angle between the normals of corresponding points", ZeroIs("off"), Below(M_PI / 2),
        AsFlag());
}

void IcpOptions::Visit(OptionVisitor& v) {
  v.Group("registration");
  v.Add(solver, "solver", "pose solver (svd for point_to_point only)", OneOf(PoseSolverNames()),
        Everyday());
  v.Add(linear_solver, "linear_solver", "linear solver of ceres_per_point",
        OneOf(LinearSolverNames()));
  v.Add(residual, "residual", "residual to minimise", OneOf(ResidualTypeNames()), Everyday());
  v.Add(association, "association", "method of data association", OneOf(AssociationNames()),
        AsFlag());
  v.Add(middle_levels, "middle_levels",
        "register on all levels, not only on the coarsest and the finest");
  v.Add(max_iterations, "max_iterations", "maximum number of ICP iterations per level",
        Between(1, 1000));
  v.AddPart(gates, "gates", "association gates on the finest level");
  v.Add(gate_growth, "gate_growth", "factor of the distance gate per coarser level", AtLeast(1));
  v.Add(kernel_growth, "kernel_growth", "factor of the robust kernel width per coarser level",
        AtLeast(1));
  v.AddPart(error_model, "error_model", "error model and robust kernel on the finest level");
  v.Add(min_source_rows, "min_source_rows",
        "minimum number of image rows of a level; every n-th row is used, with the largest n for "
        "this number",
        ZeroIs("all"));
  v.Add(min_coarse_step_px, "min_coarse_step_px",
        "step size at which a coarser level ends, in pixels of the level", AtLeast(0));
  v.Add(min_relative_rmse_change, "min_relative_rmse_change",
        "relative change of the RMSE at which a level ends", AtLeast(0));
  v.Add(min_increment, "min_increment", "step size at which a level ends, rad and m", AtLeast(0));
  v.Add(stop_at_rmse_increase, "stop_at_rmse_increase",
        "end a level at the previous pose if the RMSE rises and the number of inliers does not");
  v.Add(min_inliers, "min_inliers",
        "minimum number of correspondences on the finest level, halved on each coarser level",
        AtLeast(6));
  v.Add(min_inlier_ratio, "min_inlier_ratio",
        "minimum ratio of correspondences to valid source points", Share());
  v.AddPart(observability, "observability", "thresholds for observable directions");
  v.Add(max_free_space_violation_ratio, "max_free_space_violation_ratio",
        "maximum ratio of points that violate the free space of the other view; 1 = off", Share());
  // Throws InputError for unknown names and invalid combinations.
  v.Check([this] { MakePoseSolver(SolverOptions(*this, error_model)); });
}

void FitCriteria::Visit(OptionVisitor& v) {
  v.Add(min_overlap_ratio, "min_overlap_ratio",
        "minimum ratio of points on the surface of the other view", Share());
  v.Add(max_free_space_violation_ratio, "max_free_space_violation_ratio",
        "maximum ratio of points in front of the surface of the other view", Share());
  v.Add(needs_color, "needs_color", "require colours in both views");
  v.Add(min_value_correlation, "min_value_correlation", "minimum correlation of the brightness",
        Between(-1, 1));
  v.Add(min_detail_correlation, "min_detail_correlation",
        "minimum correlation of edges and texture", Between(-1, 1));
  v.Add(min_inlier_ratio, "min_inlier_ratio", "minimum ratio of inliers to overlapping points",
        Share());
  v.Add(max_rmse_m, "max_rmse_m", "maximum RMSE of the residuals", Positive());
  v.Add(max_sigma_m, "max_sigma_m",
        "maximum standard deviation of the translation in any direction", Positive());
  v.Add(max_sigma_rad, "max_sigma_rad",
        "maximum standard deviation of the rotation in any direction", Positive());
  v.Add(min_score_margin, "min_score_margin",
        "minimum score margin over other poses, relative to the best score", Share());
  v.Add(max_disagreement_m, "max_disagreement_m",
        "maximum translation between forward and backward registration", Positive());
  v.Add(max_disagreement_rad, "max_disagreement_rad",
        "maximum rotation between forward and backward registration", Positive());
}

void InitializeOptions::Visit(OptionVisitor& v) {
  v.Group("registration");
  v.Add(
      method, "method",
      "initial pose of registration; features: poses from image features, geometry and brightness, "
      "with verification of the result",
      OneOf(InitializeMethods()), AsFlag("start"), Everyday());
  v.AddPart(fit, "fit", "acceptance criteria of global registration", NoFlags());
}

void CloudNormalOptions::Visit(OptionVisitor& v) {
  v.Group("clouds");
  v.Add(radius_m, "radius_m", "minimum radius of the neighbourhood of a normal",
        ZeroIs("from the point spacing"));
  v.Add(max_growth, "max_growth", "maximum growth factor of the radius", Between(1, 1000));
  v.Add(min_neighbors, "min_neighbors", "minimum number of points for a normal, including its own",
        AtLeast(4));
  v.Add(max_thickness, "max_thickness",
        "maximum ratio of thickness to width of the neighbourhood of a normal", Positive());
  v.Add(max_normal_sigma_rad, "max_normal_sigma_rad", "maximum standard deviation of a normal",
        Positive());
}

void CloudSensor::Visit(OptionVisitor& v) {
  v.Group("clouds");
  PointText viewpoint_text(&viewpoint);
  v.AddText(viewpoint_text,
            Option("viewpoint", "position of the sensor, which all normals face", InUnit("m")));
  v.AddPart(noise, "noise", "noise of the distances from the viewpoint");
}

void CloudCriteria::Visit(OptionVisitor& v) {
  v.Add(min_overlap_ratio, "min_overlap_ratio",
        "minimum ratio of points on the surface of the other cloud", Share());
  v.Add(min_inlier_ratio, "min_inlier_ratio",
        "minimum ratio of points on the surface of the other cloud to points near it", Share());
  v.Add(max_free_space_violation_ratio, "max_free_space_violation_ratio",
        "maximum ratio of points in the free space of the other cloud", Share());
  v.Add(min_score_margin, "min_score_margin",
        "minimum score margin over other poses, relative to the best score", Share());
  v.Add(max_disagreement_spacings, "max_disagreement_spacings",
        "maximum distance of points after forward and backward registration, and after "
        "registration from displaced poses, in point spacings",
        Positive());
  v.Add(max_sigma_spacings, "max_sigma_spacings",
        "standard deviation of points above which a direction is verified from displaced poses, in "
        "point spacings",
        Positive());
}

void CloudStartOptions::Visit(OptionVisitor& v) {
  v.Group("registration");
  v.Add(method, "method",
        "initial pose; file: start_pose; global: matches of local shapes; auto: start_pose or "
        "identity, then global if that result is not accepted",
        OneOf(CloudStartNames()), AsFlag("start"), Everyday());
  v.AddPart(criteria, "criteria", "acceptance criteria", NoFlags());
}

void RegisterCloudsOptions::Visit(OptionVisitor& v) {
  v.Group("clouds");
  v.AddPart(icp, "icp", "ICP options; image options are not used",
            WithoutFlags({"photometric_weight"}));
  v.Add(reciprocal, "reciprocal", "accept only mutual nearest neighbours on the finest level");
  v.Add(levels, "levels",
        "number of levels; each has a quarter of the source points of the next finer one, but at "
        "least 1000",
        Between(1, 10));
  v.Check([this] {
    if (icp.association == "kd_tree") return;
    throw InputError("association is '", icp.association, "', must be 'kd_tree' for clouds");
  });
}

}  // namespace surfit
