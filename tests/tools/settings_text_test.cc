#include "common/settings_text.h"

#include <gmock/gmock.h>

#include <cmath>
#include <optional>

#include "surfit/core/error.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using tools::PairText;
using tools::SettingsHelp;
using tools::SettingsText;

struct Lamp {
  double tilt_rad = 0;
  std::vector<double> colors;

  void Visit(OptionVisitor& v) {
    v.Add(tilt_rad, "tilt_rad", "tilt of the lamp", Between(0, 2 * std::atan(1)), AsFlag());
    v.Add(colors, "colors", "red,green,blue", AsFlag());
    v.Check([this] { ThrowIf(colors.size() == 2, "colors has 2 numbers, must have 1 or 3"); });
  }
};

struct Desk {
  float width_m = 1.5f;
  int drawers = 3;
  std::size_t number = 7;
  bool sold = false;
  std::string wood = "oak";
  std::optional<std::array<double, 2>> place;
  int screws = 40;
  Lamp lamp;

  void Visit(OptionVisitor& v) {
    v.Add(width_m, "width_m", "width of the desk", Positive(), Below(4), AsFlag());
    v.Add(drawers, "drawers", "number of drawers", Between(1, 5), AsFlag());
    v.Add(number, "number", "number of the desk", AsFlag());
    v.Add(sold, "sold", "the desk is sold", AsFlag());
    v.Add(wood, "wood", "material", OneOf({"oak", "beech"}), AsFlag());
    v.Add(place, "place", "x,y of the desk", InUnit("m"), AsFlag());
    v.Add(screws, "screws", "number of screws");
    v.AddPart(lamp, "lamp", "lamp on the desk");
  }
};

// Expects an error that begins with the flag and its text, and then has the names.
template <typename... Parts>
void ExpectRefusedSettings(const std::string& settings, const Parts&... names) {
  Desk desk;
  SettingsText text(&desk);
  const std::string beginning = "--desk is '" + settings + "', must be ";
  try {
    SetText("--desk", settings, &text);
    ADD_FAILURE() << "no InputError was thrown";
  } catch (const InputError& error) {
    const std::string message = error.what();
    ASSERT_THAT(message, StartsWith(beginning));
    EXPECT_THAT(message.substr(beginning.size()), Names(names...));
  }
}

TEST(SettingsText, SetsValuesOfAllTypesAndUnits) {
  Desk desk;
  SettingsText text(&desk);
  text.Set("width_m=2.5; drawers=4;number=9;sold=true;wood=beech;place=1,-2.5;tilt_deg=45;");
  EXPECT_EQ(desk.width_m, 2.5f);
  EXPECT_EQ(desk.drawers, 4);
  EXPECT_EQ(desk.number, 9u);
  EXPECT_TRUE(desk.sold);
  EXPECT_EQ(desk.wood, "beech");
  EXPECT_THAT(*desk.place, ElementsAre(1, -2.5));
  EXPECT_DOUBLE_EQ(desk.lamp.tilt_rad, std::atan(1));
  EXPECT_EQ(text.Get(),
            "drawers=4;number=9;place=1,-2.5;sold=true;tilt_deg=45;width_m=2.5;wood=beech");
}

TEST(SettingsText, IsEmptyForDefaultsAndRestoresThem) {
  Desk desk;
  SettingsText text(&desk);
  EXPECT_EQ(text.Get(), "");
  text.Set("colors=1,0.5,0;drawers=2");
  EXPECT_THAT(desk.lamp.colors, ElementsAre(1, 0.5, 0));
  text.Set("sold=true");
  EXPECT_EQ(text.Get(), "sold=true");
  EXPECT_EQ(desk.drawers, 3);
  text.Set("");
  EXPECT_EQ(text.Get(), "");
}

TEST(SettingsText, RejectsNamesAndTextsWithoutValue) {
  ExpectRefusedSettings("color=1,2,3", "color", "colors", "drawers", "tilt_deg");
  ExpectRefusedSettings("screws=5", "screws", "drawers");  // no flag, so no setting
  ExpectRefusedSettings("tilt_rad=1", "tilt_rad", "tilt_deg");
  ExpectRefusedSettings("sold", "sold", "name=value");
  ExpectRefusedSettings("drawers=2;drawers=3", "drawers");
}

TEST(SettingsText, RejectsValuesWithNameAndConstraint) {
  ExpectRefusedSettings("drawers=6", "drawers", 6, 1, 5);
  ExpectRefusedSettings("drawers=2.5", "drawers", "2.5");
  ExpectRefusedSettings("number=-1", "number", "-1");
  ExpectRefusedSettings("width_m=", "width_m");
  ExpectRefusedSettings("width_m=4", "width_m", 4);
  ExpectRefusedSettings("width_m=nan", "width_m", "nan");
  ExpectRefusedSettings("width_m=2m", "width_m", "2m");
  ExpectRefusedSettings("tilt_deg=91", "tilt_deg", 91, 0, 90);
  ExpectRefusedSettings("sold=1", "sold", "true", "false");
  ExpectRefusedSettings("wood=pine", "wood", "pine", "oak", "beech");
  ExpectRefusedSettings("place=1", "place", 1, 2);
  ExpectRefusedSettings("colors=1,2", "lamp", "colors", 2, 1, 3);
}

TEST(PairText, SetsBothNumbersOrTheFirst) {
  int count = 3;
  double step_m = 0.5;
  PairText text(Option("count", "", AtLeast(1)), &count, Option("step_m", "", Between(0, 1)),
                &step_m);
  EXPECT_EQ(text.Get(), "3,0.5");
  text.Set("7,0.25");
  EXPECT_EQ(text.Get(), "7,0.25");
  text.Set("5");
  EXPECT_EQ(count, 5);
  EXPECT_EQ(step_m, 0.25);
  const auto refuses = [&](const std::string& pair, const auto&... names) {
    ExpectInputError([&] { SetText("--pair", pair, &text); },
                     Names("--pair", pair, "count,step_m", names...));
  };
  refuses("0,1", "count", 0, 1);
  refuses("1,2", "step_m", 2, 0, 1);
  refuses("1.5", "count", 1.5);
  refuses("1,", "step_m");
  refuses("1,0.5,3", "step_m", "0.5,3");
}

TEST(SettingsText, HelpListsDefaultsUnitsAndBounds) {
  Desk desk;
  const std::string help = SettingsHelp(TableOf(&desk));
  EXPECT_THAT(help, HasSubstr("\ndrawers=3: number of drawers, 1 to 5\n"));
  EXPECT_THAT(help, HasSubstr("\nplace: x,y of the desk, m\n"));
  EXPECT_THAT(help, HasSubstr("\ntilt_deg=0: tilt of the lamp, 0 to 90\n"));
  EXPECT_THAT(help, Not(HasSubstr("screws")));
}

}  // namespace
}  // namespace surfit::testing
