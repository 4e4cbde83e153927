#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace surfit {

// Request without its body.
struct HttpRequest {
  std::string method;
  std::string target;
  std::string host;                   // Host header; empty if missing
  std::optional<std::string> origin;  // Origin header; std::nullopt: missing
};

// Answer to a request. A null body is the reason phrase of the status, or empty for 204.
struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::shared_ptr<const std::string> body;
  bool has_token = false;  // the request had the valid token
};

// Limits against slow or malicious clients.
struct HttpLimits {
  // Connections without valid token. Above the limit, the oldest connection is closed.
  std::size_t strangers = 32;
  std::size_t clients = 64;  // connections with valid token; further connections get status 503
  std::size_t header_bytes = 8192;  // per request; above it: status 431
  std::size_t body_bytes = 1024;    // per request; above it: status 413
  double request_s = 5;  // maximum time of each request before the first one with valid token
  double idle_s = 60;    // maximum time between requests with valid token
  double hold_s = 5;     // maximum delay of an answer
  double write_s = 20;   // maximum time to send an answer
};

// HTTP/1.1 server on its own thread. Slow clients do not block other clients. Stores at most one
// answer per connection.
class HttpServer {
 public:
  // Answers a request on the server thread. std::nullopt delays the answer: the handler is called
  // again after Wake(), and after HttpLimits::hold_s with `must`. With `must`, it must answer. The
  // handler must not throw.
  using Handler = std::function<std::optional<HttpAnswer>(const HttpRequest& request, bool must)>;

  // Starts the server thread with low priority. Port 0: any free port. Throws InputError if the
  // port cannot be opened. The address must be an IP address. The destructor stops the thread and
  // closes all connections.
  HttpServer(const std::string& address, int port, const HttpLimits& limits, Handler handler);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Address and port that are open.
  std::string address() const;
  int port() const;
  // Calls the handler again for all delayed answers. Thread-safe.
  void Wake();
  // Gives the server thread the priority of the calling thread, if a new thread can be created.
  void TakePriority();

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace surfit
