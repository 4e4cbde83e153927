#pragma once

#include <gmock/gmock.h>

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "surfit/core/error.h"
#include "surfit/geometry/rigid3.h"
#include "testing/names_matcher.h"

namespace surfit::testing {

// Matchers of gmock for all tests.
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

// EXPECT_THAT(actual, VectorNear(expected, tolerance)): the Euclidean norm of the difference
// (Frobenius for matrices) is at most the tolerance. NaN never matches.
MATCHER_P2(VectorNear, expected, tolerance,
           "is within " + ::testing::PrintToString(tolerance) + " of (" +
               ::testing::PrintToString(expected) + ")") {
  const double distance = (arg - expected).norm();
  *result_listener << "off by " << distance;
  return distance <= tolerance;
}

// EXPECT_THAT(actual, RigidNear(expected, tolerance_m, tolerance_rad)): translation and rotation
// differ by at most the tolerances. q and -q are equal rotations. NaN never matches.
MATCHER_P3(RigidNear, expected, tolerance_m, tolerance_rad,
           "is within " + ::testing::PrintToString(tolerance_m) + " m and " +
               ::testing::PrintToString(tolerance_rad) + " rad of\n" +
               ::testing::PrintToString(expected.Matrix())) {
  const double distance_m = (arg.translation - expected.translation).norm();
  const double angle_rad = RotationAngle(arg.rotation * expected.rotation.conjugate());
  *result_listener << "\n"
                   << arg.Matrix() << "\noff by " << distance_m << " m and " << angle_rad << " rad";
  return distance_m <= tolerance_m && angle_rad <= tolerance_rad;
}

// Expects that the call throws InputError with a message that matches.
template <typename Call, typename Matcher>
void ExpectInputError(const Call& call, const Matcher& message) {
  try {
    call();
    ADD_FAILURE() << "no InputError was thrown";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), message);
  }
}

// Expects that Validate() rejects default options with this change, and names the field and its
// value.
template <typename Options>
void ExpectOptionsRefused(const std::function<void(Options&)>& change, const std::string& field,
                          const std::string& value) {
  Options options;
  change(options);
  ExpectInputError([&] { Validate(options); }, Names(field, value));
}

// A file that a reader must reject, with the names in the message besides the path.
struct MalformedFile {
  const char* name;  // of the test case
  std::string content;
  std::vector<std::string> names;
};

inline void PrintTo(const MalformedFile& file, std::ostream* out) { *out << file.name; }

}  // namespace surfit::testing
