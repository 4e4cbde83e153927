// The Visit() table of each options struct lists every field.
#include <gtest/gtest.h>

#include <set>

#include "apps/doctor/check_recording.h"
#include "apps/evaluate/revisits.h"
#include "apps/evaluate/view_evaluation.h"
#include "apps/scan/batch.h"
#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "apps/solvers/compare_solvers.h"
#include "apps/solvers/refine_run.h"
#include "apps/solvers/register_run.h"
#include "core/field_count.h"
#include "io/sequences/klg_writer.h"
#include "io/sequences/record.h"
#include "output/report/write_report.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/mesh/mesh_surfels.h"
#include "surfit/run/slam_run.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"

namespace surfit::testing {
namespace {

// Names of the fields of one struct, without the fields of its parts.
class FieldNames final : public OptionVisitor {
 public:
  std::multiset<std::string> names;

 private:
  void Visit(const Option& option, const OptionValue&) override { names.insert(option.name); }
  bool Enter(const Option& part, const std::type_info&, void*) override {
    names.insert(part.name);
    return false;
  }
};

template <typename Options>
void ExpectAll(std::size_t fields) {
  Options options;
  FieldNames visitor;
  options.Visit(visitor);
  EXPECT_EQ(visitor.names.size(), fields) << typeid(Options).name();
  for (const std::string& name : visitor.names) {
    EXPECT_EQ(visitor.names.count(name), 1u) << typeid(Options).name() << "::" << name;
  }
}

template <typename Options>
class OptionTables : public ::testing::Test {};

using AllOptions = ::testing::Types<
    RobustKernel, ErrorModel, AssociationGates, ObservabilityOptions, IcpOptions, PreprocessOptions,
    RectifyOptions, FitCriteria, InitializeOptions, CloudNormalOptions, CloudSensor,
    RegisterCloudsOptions, FusionOptions, RenderOptions, KeyframeOptions, PlaceViewOptions,
    PlaceIndexOptions, VerifyLoopOptions, FindLoopsOptions, RelocalizeOptions, EdgeNoise,
    PoseGraphOptions, LoopOptions, SlamOptions, CalibrationPrior, RefinementOptions, MatchOptions,
    RelativePoseErrorOptions, TrajectoryEvaluationOptions, MapErrorOptions, RecordOptions,
    KinectOptions, StereoOptions, RangeNoise, TofOptions, LidarOptions, ColorOptions, PathOptions,
    ReportOptions, SlamRunOptions, AlignRunOptions, RecordingCheckOptions, RegisterRunOptions,
    RefineRunOptions, RevisitOptions, ViewEvaluationOptions, MeshOptions, CompareOptions,
    ScanPlanOptions, CandidatesOptions, LinkOptions, GraphOptions, TileOptions, ScanReportOptions,
    BatchOptions>;
TYPED_TEST_SUITE(OptionTables, AllOptions);

// FieldCount() counts a base as one field.
template <typename Options>
std::size_t FieldsOf() {
  return FieldCount<Options>();
}

template <>
std::size_t FieldsOf<SlamOptions>() {
  return FieldCount<SlamOptions>() - 1 + FieldCount<TrackingOptions>();
}

TYPED_TEST(OptionTables, NameEveryFieldOnce) { ExpectAll<TypeParam>(FieldsOf<TypeParam>()); }

// FieldCount() does not support optional fields.
TEST(SequenceTable, NamesEveryField) {
  auto [path, format, camera, intrinsics, distortion, depth_units_per_metre, inverse_depth_sigma,
        color_intrinsics, color_distortion, color_from_depth, frames_per_second, latency_s,
        color_latency_s, readout_s, confidence, imu, depth_topic, color_topic, device_width,
        device_height, device_fps, device_registration, device_lock_exposure, openni2_library,
        first, last, stride, rectify] = SequenceOptions();
  ExpectAll<SequenceOptions>(28 + 2);  // the texts `device` and `topics` have seven fields
}

TEST(PriorTable, NamesEveryField) {
  [[maybe_unused]] auto [focal_relative_sigma, aspect_relative_sigma, center_px,
                         inverse_depth_sigma, readout_s] = PriorOptions();
  ExpectAll<PriorOptions>(5);
}

TEST(PriorOptions, UseTheSensorForMissingValues) {
  const CalibrationPrior sensor = {0.03, 0.004, 7, 0.05, 0.06};
  PriorOptions options;
  options.aspect_relative_sigma = 0;
  options.center_px = 2.5;
  const CalibrationPrior prior = options.Over(sensor);
  EXPECT_EQ(prior.focal_relative_sigma, 0.03);
  EXPECT_EQ(prior.aspect_relative_sigma, 0);
  EXPECT_EQ(prior.center_px, 2.5);
  EXPECT_EQ(prior.inverse_depth_sigma, 0.05);
  EXPECT_EQ(prior.latency_s, 0.06);
  options.Complete(sensor);
  EXPECT_EQ(options.focal_relative_sigma, 0.03);
  EXPECT_EQ(options.aspect_relative_sigma, 0);
  EXPECT_EQ(options.center_px, 2.5);
  EXPECT_EQ(options.inverse_depth_sigma, 0.05);
  options.focal_relative_sigma = -0.1;
  EXPECT_THROW(Validate(options), InputError);
}

TEST(DefaultOptions, AreValid) {
  Validate(SlamOptions());
  Validate(RefinementOptions());
  Validate(RegisterCloudsOptions());
  Validate(InitializeOptions());
}

}  // namespace
}  // namespace surfit::testing
