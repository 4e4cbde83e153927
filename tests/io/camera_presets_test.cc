#include "surfit/io/camera_presets.h"

#include "surfit/io/camera_yaml.h"
#include "testing/expect_input_error.h"
#include "testing/shared_data.h"

namespace surfit {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(CameraPreset, EveryNameGivesAValidCamera) {
  EXPECT_EQ(CameraPresetNames().size(), 8u);
  for (const std::string& name : CameraPresetNames()) {
    EXPECT_NO_THROW(CameraPreset(name).Validate(name));
  }
}

TEST(CameraPreset, AnUnknownNameListsTheKnownOnes) {
  testing::ExpectInputError([] { CameraPreset("kinect9"); },
                            AllOf(HasSubstr("'kinect9'"), HasSubstr("tum_fr1, tum_fr2, tum_fr3"),
                                  HasSubstr("icl_nuim, seven_scenes, redwood")));
}

void ExpectSame(const PinholeCamera& a, const PinholeCamera& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.distortion, b.distortion);
}

void ExpectSamePresetAndFile(const std::string& preset_name, const std::string& sequence) {
  SURFIT_REQUIRE_SHARED_DATA(sequence);
  const RgbdCamera preset = CameraPreset(preset_name);
  const RgbdCamera file = ReadCameraYaml(testing::SharedData(sequence) + "/camera.yaml");
  ExpectSame(preset.depth, file.depth);
  EXPECT_EQ(preset.depth_units_per_metre, file.depth_units_per_metre);
  EXPECT_EQ(preset.color_is_registered, file.color_is_registered);
  if (!file.color_is_registered) ExpectSame(preset.color, file.color);
}

TEST(CameraPreset, TumFr1EqualsTheCameraOfRecordedData) {
  ExpectSamePresetAndFile("tum_fr1", "tum_fr1_desk_9");
}

TEST(CameraPreset, SevenScenesEqualsTheCameraOfRecordedData) {
  ExpectSamePresetAndFile("seven_scenes", "seven_scenes_kitchen");
}

TEST(CameraPreset, IclNuimHasItsImageAxisUp) { EXPECT_EQ(CameraPreset("icl_nuim").depth.fy, -480); }

}  // namespace
}  // namespace surfit
