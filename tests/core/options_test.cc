#include "surfit/core/options.h"

#include <gmock/gmock.h>

#include <cmath>

#include "surfit/core/error.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using ::testing::Pair;
using ::testing::StrEq;
using ::testing::UnorderedElementsAre;

struct Wheel {
  double angle_rad = 0.5;
  float width_m = 0.1f;

  void Visit(OptionVisitor& v) {
    v.Add(angle_rad, "angle_rad", "angle", ZeroIs("straight"), Below(2 * std::atan(1)), AsFlag());
    v.Add(width_m, "width_m", "width", Positive(), AsFlag("wheel_width_m"));
  }
};

struct Car {
  std::string name = "beetle";
  std::string color = "red";
  int doors = 4;
  bool sold = false;
  std::size_t number = 7;
  std::vector<double> gears = {0.25, 1};
  Wheel front, rear;
  std::optional<std::array<double, 2>> place;

  void Visit(OptionVisitor& v) {
    v.Group("looks");
    v.Add(name, "name", "its name", Required(), Everyday());
    v.Add(color, "color", "its colour", OneOf({"red", "blue"}), AsFlag());
    v.Group("parts");
    v.Add(doors, "doors", "its doors", Between(2, 5), AsFlag());
    v.Add(sold, "sold", "whether it is", AsFlag());
    v.Add(number, "number", "its number", AsFlag());
    v.Add(gears, "gears", "its gears", AsFlag());
    v.AddPart(front, "front", "front wheels");
    v.AddPart(rear, "rear", "rear wheels", NoFlags());
    v.Add(place, "place", "where it stands", AsFlag());
    v.Check([this] {
      if (sold && doors < 3) throw InputError("sold is true, must be false with 2 doors");
    });
  }
};

void ExpectRefused(const std::function<void(Car*)>& change, const std::string& message) {
  Car car;
  change(&car);
  ExpectInputError([&] { Validate(car); }, StrEq(message));
}

TEST(Options, NameFieldValueAndConstraint) {
  Validate(Car());
  ExpectRefused([](Car* c) { c->name = ""; }, "name is missing, must be set");
  ExpectRefused([](Car* c) { c->color = "pink"; }, "color is 'pink', must be one of: red, blue");
  ExpectRefused([](Car* c) { c->doors = 6; }, "doors is 6, must be from 2 to 5");
  ExpectRefused([](Car* c) { c->front.width_m = 0; }, "front.width_m is 0, must be positive");
  ExpectRefused([](Car* c) { c->front.width_m = NAN; }, "front.width_m is nan, must be positive");
  ExpectRefused([](Car* c) { c->rear.width_m = INFINITY; },
                "rear.width_m is inf, must be positive");
  ExpectRefused([](Car* c) { c->rear.angle_rad = -1; },
                "rear.angle_rad is -1, must be zero (straight) or positive and below 1.5708");
}

TEST(Options, CheckWhatHoldsBetweenThem) {
  ExpectRefused(
      [](Car* c) {
        c->sold = true;
        c->doors = 2;
      },
      "sold is true, must be false with 2 doors");
}

TEST(Options, TellFlagsInTheirOwnUnit) {
  EXPECT_THAT(FlagValues(Car()),
              UnorderedElementsAre(Pair("name", "beetle"), Pair("color", "red"), Pair("doors", "4"),
                                   Pair("sold", "false"), Pair("number", "7"),
                                   Pair("gears", "0.25,1"), Pair("angle_deg", "28.64788975654116"),
                                   Pair("wheel_width_m", "0.1"), Pair("place", "")));
  const Option option = Option("angle_rad", "angle", Positive(), Below(2 * std::atan(1)), AsFlag());
  double angle_rad = -std::atan(1);
  ExpectInputError([&] { RequireOption("--angle_deg", option, &angle_rad, true); },
                   StrEq("--angle_deg is -45, must be positive and below 90"));
}

TEST(Options, PartsSayWhichFlagsTheyHave) {
  struct {
    Car first, second;
    void Visit(OptionVisitor& v) {
      v.AddPart(first, "first", "one", OnlyFlags({"doors", "angle_deg"}));
      v.AddPart(second, "second", "two", WithoutFlags({"doors", "angle_deg", "name"}));
    }
  } cars;
  const auto flags = TableFlags(TableOf(&cars));
  EXPECT_EQ(flags.size(), 8u);
  EXPECT_EQ(flags.count("doors") + flags.count("angle_deg"), 2u);
  EXPECT_EQ(flags.count("name"), 0u);
}

TEST(Options, NothingIsRequiredOfAnOptionalPart) {
  struct Garage {
    Car car;
    void Visit(OptionVisitor& v) { v.AddPart(car, "car", "car", OptionalPart()); }
  } garage;
  garage.car.name = "";
  Validate(garage);
  garage.car.doors = 1;
  ExpectInputError([&] { Validate(garage); }, HasSubstr("car.doors is 1"));
}

TEST(Options, AreReadFromText) {
  std::optional<std::array<double, 2>> place;
  OptionFromText("1.5,-2", &place);
  EXPECT_EQ(OptionToText(place), "1.5,-2");
  OptionFromText("", &place);
  EXPECT_FALSE(place.has_value());
  std::vector<int> numbers;
  ExpectInputError([&] { OptionFromText("1,2.5", &numbers); },
                   StrEq("whole numbers with commas between them"));
  ExpectInputError([&] { OptionFromText("1,2,3", &place); },
                   StrEq("2 numbers with commas between them"));
}

TEST(Options, HelpTellsUnitChoicesAndZero) {
  EXPECT_EQ(Option("color", "its colour", OneOf({"red", "blue", "white"})).Help(),
            "its colour; one of red, blue or white");
  EXPECT_EQ(Option("size", "its size", ZeroIs("any"), InUnit("m")).Help(), "its size, m; 0 = any");
  EXPECT_EQ(Option("doors", "its doors", Between(2, 5)).Help(), "its doors, 2 to 5");
}

}  // namespace
}  // namespace surfit::testing
