#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace surfit::testing
