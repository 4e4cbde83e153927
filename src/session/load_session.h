#pragma once

#include <functional>
#include <string>

#include "surfit/session/session.h"

namespace surfit {

// Callback with a description of damaged or missing data. May throw.
using DamageCallback = std::function<void(const std::string& damage)>;

// Reads all intact data of a session. Throws InputError if the folder has no session.
Session LoadSession(const std::string& folder, const DamageCallback& tell);

}  // namespace surfit
