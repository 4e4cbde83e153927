#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "apps/live/live_run.h"

namespace surfit {

class OptionVisitor;

struct ServeOptions {
  int port = -1;  // -1: no web page; 0: any free port
  // IP address to listen on; 0.0.0.0: all network interfaces.
  std::string address = "127.0.0.1";

  void Visit(OptionVisitor& visitor);
};

// HTTP server of the live web page of a run, on its own thread. The page shows map, pictures,
// path and state, and can pause and stop the run. The address contains a random access token.
// Requests without this token get status 403. Slow clients get fewer updates and do not block
// the run. No files are served.
class LiveServer : public RunViewer {
 public:
  // Starts the server thread. `run` must outlive the server. Throws InputError for invalid
  // options, for port -1, or if the port cannot be opened.
  LiveServer(const ServeOptions& options, LiveRun* run);
  ~LiveServer() override;

  // Address of the web page: http://ADDRESS:PORT/TOKEN/, with ServeOptions::address and the
  // opened port.
  std::string url() const;

  void Show(const SlamRunFrame& frame) override;
  void Wait(const SlamRunFrame& frame, int wait_ms) override;
  void ShowWork() override;
  void Keep(const SlamRunResult& result) override;
  // Blocks for at most 10 s, until all pages have the final map: no answer for 2 s. Returns at once
  // if no page has requested data in the last 8 s.
  void Stay() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace surfit
