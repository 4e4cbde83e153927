#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace surfit {

struct HttpRequest {
  std::string method;
  std::string target;
  std::string host;  // Host header; empty if missing
  std::optional<std::string> origin;
};

struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::shared_ptr<const std::string> body;
  bool has_token = false;  // the request has the valid token
};

// Resource limits of the server.
struct HttpLimits {
  // Connections without valid token; the oldest one above the limit is closed.
  std::size_t strangers = 32;
  std::size_t clients = 64;  // connections with valid token; further connections are refused
  std::size_t header_bytes = 8192;
  std::size_t body_bytes = 1024;
  double request_s = 5;  // maximum time until a request with valid token
  double idle_s = 60;    // maximum time between requests with valid token
  double hold_s = 5;     // maximum delay of an answer
  double write_s = 20;   // maximum time to send an answer
};

// HTTP/1.1 server on its own thread. A slow client does not block other clients. A connection
// stores at most one answer.
class HttpServer {
 public:
  // Answers a request, on the server thread. Returns std::nullopt to delay the answer: the handler
  // is called again after Wake(). After HttpLimits::hold_s it is called with `must`.
  using Handler = std::function<std::optional<HttpAnswer>(const HttpRequest& request, bool must)>;

  // Starts the server thread with low priority, see TakePriority(). Port 0: any free port. Throws
  // InputError with address and port if the port cannot be opened.
  HttpServer(const std::string& address, int port, const HttpLimits& limits, Handler handler);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::string address() const;
  int port() const;
  // Calls the handler again for delayed answers. Thread-safe.
  void Wake();
  // Gives the server thread the priority of the calling thread. No effect if no thread can be
  // created.
  void TakePriority();

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace surfit
