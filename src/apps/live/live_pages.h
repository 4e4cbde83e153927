#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <utility>

#include "apps/live/http_rules.h"
#include "apps/live/http_server.h"
#include "apps/live/live_data.h"
#include "apps/live/live_run.h"

namespace surfit {

// Answers the requests of the live page with LiveData, and controls the run. The status is 403 for
// an invalid token, Host or Origin, 404 for an unknown page, and 204 for data that do not exist
// yet.
class LivePages {
 public:
  // Keeps the pointers.
  LivePages(std::string token, LiveRun* run, LiveData* shown)
      : token_(std::move(token)), run_(*run), shown_(*shown) {}

  // Implements HttpServer::Handler. Call on the server thread only.
  std::optional<HttpAnswer> Answer(const HttpRequest& request, bool must);

  // Seconds since the last answer to a request with valid token. Thread-safe.
  double SinceLastAnswer_s() const;

 private:
  std::optional<HttpAnswer> Get(const std::string& page, const HttpTarget& target, bool must);
  std::optional<HttpAnswer> Map(const HttpTarget& target, bool must);
  HttpAnswer Post(const std::string& page);

  std::string token_;
  LiveRun& run_;
  LiveData& shown_;
  std::atomic<double> answered_at_s_{0};
  // Token bucket: bytes of map data that may be sent now.
  double map_bytes_ = 0;
  double map_bytes_at_s_ = 0;
};

}  // namespace surfit
