// The options of this module.
#include "surfit/core/options.h"

#include <cmath>

#include "registration/icp/icp_level.h"
#include "surfit/core/error.h"
#include "surfit/registration/far_registration.h"
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
  v.Add(floor_sigma_m, "floor_sigma_m",
        "standard deviation of a residual that map, normals and calibration add to the depth noise",
        Positive(), AsFlag());
  v.AddPart(kernel, "kernel", "robust kernel of the residuals");
  v.Add(estimate_scale, "estimate_scale",
        "measure the robust kernel's width in sigmas estimated from the residuals (MAD), not in "
        "those of the noise model",
        AsFlag());
  v.Add(photometric_weight, "photometric_weight",
        "weight of intensity residuals beside those of surfaces", ZeroIs("surfaces only"),
        AsFlag());
  v.Add(intensity_sigma, "intensity_sigma",
        "standard deviation of intensity residuals; intensities are 0 to 1", Positive(), AsFlag());
  v.AddPart(intensity_kernel, "intensity_kernel", "robust kernel of intensity residuals",
            NoFlags());
}

void HeldOptions::Visit(OptionVisitor& v) {
  v.Add(min_eigenvalue, "min_eigenvalue",
        "the pose does not move along directions that the data constrain less: the smallest "
        "eigenvalue, without unit",
        AtLeast(0), Below(1), AsFlag());
  v.Add(min_information_ratio, "min_information_ratio",
        "nor along those whose information is less than this many times what noise of the normals "
        "alone would give",
        ZeroIs("off"), AsFlag());
}

void AssociationGates::Visit(OptionVisitor& v) {
  v.Add(max_distance_m, "max_distance_m",
        "points farther apart are not paired, on the finest level", ZeroIs("off"), AsFlag());
  v.Add(max_normal_angle_rad, "max_normal_angle_rad",
        "points whose normals differ by more are not paired", ZeroIs("off"), Below(M_PI / 2),
        AsFlag());
}

void IcpOptions::Visit(OptionVisitor& v) {
  v.Group("registration");
  v.Add(solver, "solver", "pose solver (svd for point_to_point only)", OneOf(PoseSolverNames()),
        Everyday());
  v.Add(linear_solver, "linear_solver", "linear solver of ceres_per_point",
        OneOf(LinearSolverNames()), AsFlag());
  v.Add(residual, "residual", "residual to minimise", OneOf(ResidualTypeNames()), Everyday());
  v.Add(association, "association", "how points are paired", OneOf(AssociationNames()), AsFlag());
  v.Add(middle_levels, "middle_levels",
        "register on all levels, not just the coarsest and the finest");
  v.Add(max_iterations, "max_iterations", "ICP iterations on each level at most", Between(1, 1000),
        AsFlag());
  v.AddPart(gates, "gates", "which points may be paired, on the finest level");
  v.Add(gate_growth, "gate_growth", "the distance gate grows by this factor on each coarser level",
        AtLeast(1));
  v.Add(kernel_growth, "kernel_growth", "and the robust kernel's width by this factor", AtLeast(1));
  v.AddPart(error_model, "error_model", "what residuals are worth, on the finest level");
  v.Add(min_source_rows, "min_source_rows",
        "on the finest level register every n-th image row only, with the largest n that leaves "
        "this many",
        ZeroIs("all"), AsFlag());
  v.Add(min_coarse_step_px, "min_coarse_step_px",
        "a coarser level also ends where points move by less of its pixels", AtLeast(0));
  v.Add(min_relative_rmse_change, "min_relative_rmse_change",
        "a level ends where the RMSE changes by less, relatively", AtLeast(0), AsFlag());
  v.Add(min_increment, "min_increment", "a level ends where a step is smaller, in rad and m",
        AtLeast(0));
  v.Add(stop_at_rmse_increase, "stop_at_rmse_increase",
        "a level ends where the RMSE rises and the inliers do not, at the pose before");
  v.Add(min_inliers, "min_inliers",
        "registration fails with fewer inliers, or half as many on each coarser level", AtLeast(6),
        AsFlag());
  v.Add(min_inlier_share, "min_inlier_share", "or with a smaller share of the valid source points",
        Share());
  v.AddPart(held, "held", "which directions of motion count as constrained");
  v.Add(max_free_space_share, "max_free_space_share",
        "registration fails where a larger share of points lies in space that the other view saw "
        "through; 1 = off",
        Share(), AsFlag());
  // Throws where names or combinations are impossible.
  v.Check([this] { MakePoseSolver(SolverOptions(*this, error_model)); });
}

void FitCriteria::Visit(OptionVisitor& v) {
  v.Add(min_overlap_share, "min_overlap_share", "of points on the other view's surface", Share());
  v.Add(max_free_space_share, "max_free_space_share", "of points in front of that surface",
        Share());
  v.Add(needs_color, "needs_color", "both views must show colours");
  v.Add(min_value_correlation, "min_value_correlation", "of the images", Between(-1, 1));
  v.Add(min_detail_correlation, "min_detail_correlation", "of their edges and texture",
        Between(-1, 1));
  v.Add(min_inlier_share, "min_inlier_share", "of the points that overlap", Share());
  v.Add(max_rmse_m, "max_rmse_m", "of the residuals", Positive());
  v.Add(max_sigma_m, "max_sigma_m", "of the translation in its least certain direction",
        Positive());
  v.Add(max_sigma_rad, "max_sigma_rad", "of the rotation in its least certain direction",
        Positive());
  v.Add(min_lead, "min_lead", "over any other pose, as a share", Share());
  v.Add(max_disagreement_m, "max_disagreement_m", "between forward and backward registration",
        Positive());
  v.Add(max_disagreement_rad, "max_disagreement_rad", "between forward and backward registration",
        Positive());
}

void InitializeOptions::Visit(OptionVisitor& v) {
  v.Group("registration");
  v.Add(
      method, "method",
      "where registration starts; so3: the rotation that makes small images most alike; features: "
      "poses that image features, shapes and brightness propose. All but identity are verified",
      OneOf(InitializeMethods()), AsFlag("start"), Everyday());
  v.Add(iteration_growth, "iteration_growth",
        "from afar ICP has this many times its max_iterations", AtLeast(1));
  v.Add(free_space_growth, "free_space_growth",
        "from afar max_free_space_share is this many times as large", AtLeast(1));
  v.AddPart(fit, "fit", "what a fit from afar must show to be believed", NoFlags());
}

void CloudNormalOptions::Visit(OptionVisitor& v) {
  v.Group("clouds");
  v.Add(radius_m, "radius_m", "normals come from neighbours at least this far around",
        ZeroIs("by the cloud's spacing"), AsFlag("normal_radius_m"));
  v.Add(max_growth, "max_growth", "the radius grows by this factor at most", Between(1, 1000));
  v.Add(min_neighbors, "min_neighbors", "points that a normal needs, its own included", AtLeast(4));
  v.Add(max_thickness, "max_thickness",
        "neighbours must be flatter: thickness of their plane by its width", Positive());
  v.Add(max_normal_sigma_rad, "max_normal_sigma_rad", "standard deviation of a normal at most",
        Positive());
}

void CloudSensor::Visit(OptionVisitor& v) {
  v.Group("clouds");
  PointText viewpoint_text(&viewpoint);
  v.AddText(viewpoint_text, Option("viewpoint", "normals face this point", InUnit("m")));
  v.AddPart(noise, "noise", "of distances from the viewpoint");
}

void RegisterCloudsOptions::Visit(OptionVisitor& v) {
  v.Group("clouds");
  v.AddPart(icp, "icp", "what is about images is not used",
            WithoutFlags({"photometric_weight", "intensity_sigma", "min_source_rows",
                          "max_free_space_share"}));
  v.Add(reciprocal, "reciprocal",
        "on the finest level, pair only points that are each other's nearest", Everyday());
  v.Add(levels, "levels",
        "levels of coarse to fine, each of a quarter of the next one's source points",
        Between(1, 10), AsFlag());
  v.Check([this] {
    if (icp.association == "kd_tree") return;
    throw InputError("association is '", icp.association, "', must be 'kd_tree' for clouds");
  });
}

}  // namespace surfit
