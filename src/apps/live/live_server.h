#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "apps/live/live_run.h"

namespace surfit {

class OptionVisitor;

// Address and size of the live web page.
struct ServeOptions {
  int port = -1;  // -1: no web page; 0: any free port
  // IP address of this machine; 0.0.0.0: all network interfaces.
  std::string address = "127.0.0.1";
  std::size_t max_surfels = 131072;  // maximum number of surfels on a page

  void Visit(OptionVisitor& visitor);
};

// Live web page of a run over HTTP. Each request needs the random token, which is part of the
// address. Pages show the map, pictures, path and state, and can pause and stop the run. Slow
// clients get fewer updates and never block the run. No files are served.
class LiveServer : public RunViewer {
 public:
  // Throws InputError for invalid options, or if the port cannot be opened. `run` must outlive the
  // server.
  LiveServer(const ServeOptions& options, LiveRun* run);
  ~LiveServer() override;

  // Address of the web page: http://ADDRESS:PORT/TOKEN/.
  std::string url() const;

  void Show(const SlamRunFrame& frame) override;
  void Wait(const SlamRunFrame& frame, int wait_ms) override;
  void ShowWork() override;
  void Keep(const SlamRunResult& result) override;
  // Blocks until all pages have the final map, at most 10 s.
  void Stay() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace surfit
