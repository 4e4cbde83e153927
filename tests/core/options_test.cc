#include "surfit/core/options.h"

#include <gmock/gmock.h>

#include <cmath>

#include "surfit/core/error.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using ::testing::Pair;
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

template <typename... Parts>
void ExpectRefused(const std::function<void(Car*)>& change, const Parts&... names) {
  Car car;
  change(&car);
  ExpectInputError([&] { Validate(car); }, Names(names...));
}

TEST(Options, NameFieldValueAndConstraint) {
  Validate(Car());
  ExpectRefused([](Car* c) { c->name = ""; }, "name");
  ExpectRefused([](Car* c) { c->color = "pink"; }, "color", "pink", "red", "blue");
  ExpectRefused([](Car* c) { c->doors = 6; }, "doors", 6, 2, 5);
  ExpectRefused([](Car* c) { c->front.width_m = 0; }, "front.width_m", 0);
  ExpectRefused([](Car* c) { c->front.width_m = NAN; }, "front.width_m", "nan");
  ExpectRefused([](Car* c) { c->rear.width_m = INFINITY; }, "rear.width_m", "inf");
  ExpectRefused([](Car* c) { c->rear.angle_rad = -1; }, "rear.angle_rad", -1, "straight", 1.5708);
}

TEST(Options, CheckCombinationsOfFields) {
  ExpectRefused(
      [](Car* c) {
        c->sold = true;
        c->doors = 2;
      },
      "sold", "true", "doors", 2);
}

TEST(Options, ConvertValuesToUnitOfFlag) {
  EXPECT_THAT(FlagValues(Car()),
              UnorderedElementsAre(Pair("name", "beetle"), Pair("color", "red"), Pair("doors", "4"),
                                   Pair("sold", "false"), Pair("number", "7"),
                                   Pair("gears", "0.25,1"), Pair("angle_deg", "28.64788975654116"),
                                   Pair("wheel_width_m", "0.1"), Pair("place", "")));
  const Option option = Option("angle_rad", "angle", Positive(), Below(2 * std::atan(1)), AsFlag());
  double angle_rad = -std::atan(1);
  ExpectInputError([&] { RequireOption("--angle_deg", option, &angle_rad, true); },
                   Names("--angle_deg", -45, 90));
}

TEST(Options, PartsSelectTheirFlags) {
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

TEST(Options, OptionalPartHasNoRequiredFields) {
  struct Garage {
    Car car;
    void Visit(OptionVisitor& v) { v.AddPart(car, "car", "car", OptionalPart()); }
  } garage;
  garage.car.name = "";
  Validate(garage);
  garage.car.doors = 1;
  ExpectInputError([&] { Validate(garage); }, Names("car.doors", 1));
}

TEST(Options, ParseText) {
  std::optional<std::array<double, 2>> place;
  OptionFromText("1.5,-2", &place);
  EXPECT_EQ(OptionToText(place), "1.5,-2");
  OptionFromText("", &place);
  EXPECT_FALSE(place.has_value());
  std::vector<int> numbers;
  EXPECT_THROW(OptionFromText("1,2.5", &numbers), InputError);
  ExpectInputError([&] { OptionFromText("1,2,3", &place); }, Names(2));
}

TEST(Options, HelpContainsUnitChoicesAndMeaningOfZero) {
  EXPECT_THAT(Option("color", "its colour", OneOf({"red", "blue", "white"})).Help(),
              AllOf(StartsWith("its colour"), Names("red", "blue", "white")));
  EXPECT_THAT(Option("size", "its size", ZeroIs("any"), InUnit("m")).Help(),
              AllOf(StartsWith("its size"), Names("m", 0, "any")));
  EXPECT_THAT(Option("doors", "its doors", Between(2, 5)).Help(),
              AllOf(StartsWith("its doors"), Names(2, 5)));
}

}  // namespace
}  // namespace surfit::testing
