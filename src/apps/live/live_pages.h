#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <utility>

#include "apps/live/http_rules.h"
#include "apps/live/http_server.h"
#include "apps/live/live_run.h"
#include "apps/live/shown_run.h"

namespace surfit {

// Answers what browsers ask for: who may, and what there is.
class LivePages {
 public:
  LivePages(std::string token, LiveRun* run, ShownRun* shown)
      : token_(std::move(token)), run_(*run), shown_(*shown) {}

  // HttpServer::Handler.
  std::optional<HttpAnswer> Answer(const HttpRequest& request, bool must);

  // For how long nobody who may ask has been answered. Any thread may call it.
  double SinceLastAnswer_s() const;

 private:
  std::optional<HttpAnswer> Get(const std::string& page, const HttpTarget& target, bool must);
  std::optional<HttpAnswer> Map(const HttpTarget& target, bool must);
  HttpAnswer Post(const std::string& page);

  std::string token_;
  LiveRun& run_;
  ShownRun& shown_;
  std::atomic<double> answered_at_s_{0};
  // What may still be sent of the map, bytes: it grows with time.
  double map_bytes_ = 0;
  double map_bytes_at_s_ = 0;
};

}  // namespace surfit
