#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "apps/live/live_run.h"

namespace surfit {

class OptionVisitor;

// Where the pages of a run are to be had.
struct ServeOptions {
  int port = -1;                      // -1: nowhere; 0: any that is free
  std::string address = "127.0.0.1";  // of the machine; 0.0.0.0: all that it has
  std::size_t max_surfels = 131072;   // that pages show of the map

  void Visit(OptionVisitor& visitor);
};

// Shows a run in any browser: pages that who knows their address, with a random token in it, may
// open, over HTTP. They get the map as it changes, pictures, path and state, and can pause and stop
// the run. They never make it wait: who is slow gets less. Nothing of the disk can be had.
class LiveServer : public RunViewer {
 public:
  // Throws InputError for bad options, or where the port cannot be had. The run outlives it.
  LiveServer(const ServeOptions& options, LiveRun* run);
  ~LiveServer() override;

  // What a browser opens, http://ADDRESS:PORT/TOKEN/.
  std::string url() const;

  void Show(const SlamRunFrame& frame) override;
  void Wait(const SlamRunFrame& frame, int wait_ms) override;
  void ShowWork() override;
  void Keep(const SlamRunResult& result) override;
  // Until all who look on have the map that the run has come to, some seconds at most.
  void Stay() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace surfit
