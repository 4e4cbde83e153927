#include "session/load_session.h"
#include "session/schema.h"
#include "surfit/core/error.h"

namespace surfit {

std::vector<std::string> CheckSession(const std::string& folder) {
  std::vector<std::string> damages;
  const auto tell = [&](const std::string& damage) { damages.push_back(damage); };
  if (HasSession(folder)) {
    Database database(DatabaseOf(folder), Database::Mode::kRead);
    try {
      for (const std::string& line : database.Texts("PRAGMA integrity_check")) {
        if (line != "ok") tell(Concat(database.path(), ": ", line));
      }
    } catch (const LockedError&) {
      throw;
    } catch (const InputError& error) {
      tell(error.what());
    }
  }
  try {
    LoadSession(folder, tell);
  } catch (const LockedError&) {
    throw;
  } catch (const InputError& error) {
    if (damages.empty()) throw;
    tell(error.what());
  }
  return damages;
}

}  // namespace surfit
