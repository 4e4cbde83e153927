#pragma once

#include <functional>
#include <string>

#include "surfit/session/session.h"

namespace surfit {

// Callback for damaged or missing data, with a description. May throw.
using DamageCallback = std::function<void(const std::string& damage)>;

// Reads all intact data of a session. Throws InputError if the folder has no session.
Session LoadSession(const std::string& folder, const DamageCallback& tell);

}  // namespace surfit
