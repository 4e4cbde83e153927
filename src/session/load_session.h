#pragma once

#include <functional>
#include <string>

#include "surfit/session/session.h"

namespace surfit {

// Called with a sentence for what is damaged or missing; may throw.
using TellDamage = std::function<void(const std::string& damage)>;

// Reads all that is intact, and tells what is not. Throws InputError where there is no session.
Session LoadSession(const std::string& folder, const TellDamage& tell);

}  // namespace surfit
