#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/registration/global_registration.h"
#include "surfit/registration/icp.h"

namespace surfit::python {
namespace {

void BindIteration(py::module_& module) {
  BindReport<IcpIteration>(module, "IcpIteration",
                           "State of a pyramid level before a step. The last entry of a level is "
                           "the state after all steps.")
      .def_readonly(FIELD(IcpIteration, level), "pyramid level; 0: finest")
      .def_readonly(FIELD(IcpIteration, average_loss), "weighted mean of |r|^2, m^2")
      .def_readonly(FIELD(IcpIteration, cost), "1/2 sum of rho(s)")
      .def_readonly(FIELD(IcpIteration, inlier_count), "correspondences within 3 sigma");
}

}  // namespace

void BindIcpResult(py::module_& module) {
  BindIteration(module);
  using Result = IcpResult;
  BindReport<Result>(
      module, "IcpResult",
      "Result of a registration. The pose is valid only if the registration succeeded.")
      .def_property_readonly("succeeded", &Result::Succeeded, "True if the pose is valid")
      .def_property_readonly(
          "termination", [](const Result& result) { return ToString(result.termination); },
          "converged, rmse_increased, max_iterations; or the failure: too_few_inliers, "
          "singular_system, free_space_violation")
      .def_readonly(FIELD(Result, target_from_source), "4 x 4, metres")
      .def_readonly(FIELD(Result, iterations), "states of all levels, coarse to fine")
      .def_readonly(FIELD(Result, step_count), "number of steps over all levels")
      .def_readonly(FIELD(Result, inlier_count), "correspondences within 3 sigma")
      .def_readonly(FIELD(Result, inlier_ratio), "inliers divided by valid source points")
      .def_readonly(FIELD(Result, rmse_m), "root of the weighted mean of |r|^2, m")
      .def_readonly(FIELD(Result, intensity_count), "points with photometric residuals")
      .def_readonly(FIELD(Result, information),
                    "6 x 6, for the left perturbation (rotation, translation), 1/rad^2, 1/m^2")
      .def_readonly(FIELD(Result, trusted_information),
                    "information without the spurious information of normal noise, 1/rad^2, 1/m^2")
      .def_readonly(FIELD(Result, covariance),
                    "6 x 6, rad^2, m^2; None with unobservable directions")
      .def_readonly(FIELD(Result, eigenvalues), "ascending, from 0 (unobservable direction) to 1")
      .def_readonly(FIELD(Result, degenerate_directions),
                    "unobservable left perturbations (rad, m)")
      .def_readonly(FIELD(Result, free_space_violation_ratio),
                    "ratio of points with free-space violations; 0 unless limited");

  using Verdict = GlobalRegistrationResult;
  BindReport<Verdict>(
      module, "AlignResult",
      "Registration of two frames with its verification. Values that were not computed are 0. The "
      "pose is valid only if the registration was accepted.")
      .def_property_readonly("accepted", &Verdict::accepted, "True if the pose is valid")
      .def_property_readonly(
          "reason", [](const Verdict& verdict) { return ToString(verdict.reason); },
          "accepted, or the reason of the rejection: not_registered, degenerate, little_overlap, "
          "poor_fit, free_space_violation, looks_different, ambiguous, inconsistent")
      .def_readonly(FIELD(Verdict, target_from_source), "4 x 4, metres")
      .def_readonly(FIELD(Verdict, icp), "result of ICP")
      .def_readonly(FIELD(Verdict, start), "initial pose of ICP, 4 x 4")
      .def_readonly(FIELD(Verdict, overlap_ratio),
                    "ratio of points on the surface of the other view; this and the next values "
                    "are 0 for the method identity")
      .def_readonly(FIELD(Verdict, value_correlation), "correlation of brightness in the overlap")
      .def_readonly(FIELD(Verdict, detail_correlation),
                    "correlation of edges and texture in the overlap")
      .def_readonly(FIELD(Verdict, score_margin),
                    "score margin to all other poses, relative to the score");
}

}  // namespace surfit::python
