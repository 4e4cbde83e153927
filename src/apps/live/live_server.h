#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "apps/live/live_run.h"

namespace surfit {

class OptionVisitor;

// Address of the live web page, and size of its map.
struct ServeOptions {
  int port = -1;  // -1: no web page, the caller creates no LiveServer; 0: any free port
  // IP address of this machine; 0.0.0.0: all network interfaces.
  std::string address = "127.0.0.1";
  std::size_t max_surfels = 131072;  // maximum number of surfels on a page

  void Visit(OptionVisitor& visitor);
};

// Live web page of a run over HTTP, served by its own thread. Each request needs the random token,
// which is part of the address. Other requests get status 403. Pages show the map, pictures, path
// and state, and can pause and stop the run. Slow clients get fewer updates and never block the
// run. No files are served. The functions of RunViewer are for the thread of the run only.
class LiveServer : public RunViewer {
 public:
  // Starts the server thread. Pages pause and stop `run`, which must outlive the server. Throws
  // InputError for invalid options, for port -1, or if address and port cannot be opened.
  LiveServer(const ServeOptions& options, LiveRun* run);
  // Ends the server thread.
  ~LiveServer() override;

  // Address of the web page: http://ADDRESS:PORT/TOKEN/. ADDRESS is that of the options, also if it
  // is 0.0.0.0. PORT is the opened port.
  std::string url() const;

  void Show(const SlamRunFrame& frame) override;
  void Wait(const SlamRunFrame& frame, int wait_ms) override;
  void ShowWork() override;
  void Keep(const SlamRunResult& result) override;
  // Blocks until no request was answered for 2 s: all pages have the final map. Blocks for at most
  // 10 s. Returns at once if no page has requested data in the last 8 s.
  void Stay() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace surfit
