#pragma once

#include <gmock/gmock.h>

#include <ostream>
#include <string>

#include "surfit/core/error.h"

namespace surfit::testing {

// Expects that the call throws InputError with a message that the matcher accepts.
template <typename Call, typename Matcher>
void ExpectInputError(const Call& call, const Matcher& message) {
  try {
    call();
    ADD_FAILURE() << "no InputError was thrown";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), message);
  }
}

// A file that a reader must refuse, and what the message says besides the file's name.
struct MalformedFile {
  const char* name;
  std::string content;
  const char* message;
};

inline void PrintTo(const MalformedFile& file, std::ostream* out) { *out << file.name; }

}  // namespace surfit::testing
