#pragma once

#include <functional>
#include <string>

#include "surfit/session/session.h"

namespace surfit {

// Callback with a description of damaged or missing data. May throw. The text names file and row.
using DamageCallback = std::function<void(const std::string& damage)>;

// Reads all intact data of a session, from one save. Damaged rows and tiles are reported and
// omitted. Throws InputError if the folder has no session, another version, or no intact row in
// table `session`. Another program may write to the session meanwhile.
Session LoadSession(const std::string& folder, const DamageCallback& tell);

}  // namespace surfit
