// The outcome of a registration.
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/registration/far_registration.h"
#include "surfit/registration/icp.h"

namespace surfit::python {
namespace {

void BindIteration(py::module_& module) {
  BindReport<IcpIteration>(module, "IcpIteration",
                           "The state of a level before a step or, its last one, after all.")
      .def_readonly(FIELD(IcpIteration, level), "0 is the finest")
      .def_readonly(FIELD(IcpIteration, average_loss), "m^2, weighted mean of |r|^2")
      .def_readonly(FIELD(IcpIteration, cost), "1/2 sum of rho(s)")
      .def_readonly(FIELD(IcpIteration, inlier_count), "pairs within 3 sigmas");
}

}  // namespace

void BindIcpResult(py::module_& module) {
  BindIteration(module);
  BindReport<IcpResult>(
      module, "IcpResult",
      "The outcome of a registration. Unless it succeeded, the pose must not be used.")
      .def_property_readonly("succeeded", &IcpResult::Succeeded, "whether the pose may be used")
      .def_property_readonly(
          "termination", [](const IcpResult& result) { return ToString(result.termination); },
          "converged, rmse_increased, max_iterations; or the failure: too_few_inliers, "
          "singular_system, free_space_filled")
      .def_readonly(FIELD(IcpResult, target_from_source), "4 x 4, metres")
      .def_readonly(FIELD(IcpResult, iterations), "in their order, coarse to fine")
      .def_readonly(FIELD(IcpResult, step_count), "over all levels")
      .def_readonly(FIELD(IcpResult, inlier_count), "pairs within 3 sigmas")
      .def_readonly(FIELD(IcpResult, inlier_share), "of the valid source points")
      .def_readonly(FIELD(IcpResult, rmse_m), "root of the weighted mean of |r|^2")
      .def_readonly(FIELD(IcpResult, intensity_count), "points whose intensities have a say")
      .def_readonly(FIELD(IcpResult, information),
                    "6 x 6, of the left increment (rotation, translation), 1/rad^2, 1/m^2")
      .def_readonly(FIELD(IcpResult, trusted_information),
                    "the same without what noise feigns, 1/rad^2, 1/m^2")
      .def_readonly(FIELD(IcpResult, covariance),
                    "6 x 6, rad^2, m^2; None where directions are free")
      .def_readonly(FIELD(IcpResult, eigenvalues),
                    "ascending, from 0 (a direction that the data does not hold) to 1")
      .def_readonly(FIELD(IcpResult, free_directions),
                    "left increments (rad, m) that the data does not hold")
      .def_readonly(FIELD(IcpResult, free_space_share),
                    "of points in space that the other view saw through; 0 unless limited");

  BindReport<FarVerdict>(
      module, "AlignResult",
      "A registration of frames and what speaks for it; numbers are 0 where they were not looked "
      "at. Unless it was accepted, the pose must not be used.")
      .def_property_readonly("accepted", &FarVerdict::accepted, "whether the pose may be used")
      .def_property_readonly(
          "reason", [](const FarVerdict& verdict) { return ToString(verdict.reason); },
          "accepted; or what spoke against it: not_registered, degenerate, little_overlap, "
          "poor_fit, free_space_filled, looks_different, ambiguous, inconsistent")
      .def_readonly(FIELD(FarVerdict, target_from_source), "4 x 4, metres")
      .def_readonly(FIELD(FarVerdict, icp), "the registration")
      .def_readonly(FIELD(FarVerdict, start), "4 x 4: where ICP started")
      .def_readonly(FIELD(FarVerdict, overlap_share),
                    "of points on the other view's surface; as all below, 0 from the identity")
      .def_readonly(FIELD(FarVerdict, value_correlation), "of brightness there")
      .def_readonly(FIELD(FarVerdict, detail_correlation), "of its edges and texture")
      .def_readonly(FIELD(FarVerdict, lead), "over any other pose, as a share of this one's score");
}

}  // namespace surfit::python
