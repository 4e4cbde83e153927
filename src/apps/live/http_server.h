#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace surfit {

struct HttpRequest {
  std::string method;  // as it was sent: GET, POST, ...
  std::string target;  // path and query, as it was sent
  std::string host;    // of the header; empty where there is none
  std::optional<std::string> origin;
};

struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::shared_ptr<const std::string> body;
  bool knows_token = false;  // who asks may
};

// What clients may take up, each and all together.
struct HttpLimits {
  std::size_t strangers = 32;       // connections that have not shown the token: the oldest goes
  std::size_t clients = 64;         // and those that have: a further one is refused
  std::size_t header_bytes = 8192;  //
  std::size_t body_bytes = 1024;
  double request_s = 5;  // in which a stranger must have sent a request
  double idle_s = 60;    // between the requests of others
  double hold_s = 5;     // that an answer may be waited for
  double write_s = 20;   // in which an answer must have been taken
};

// A server of HTTP/1.1 on a thread of its own. No client can make it wait for them, nor keep more
// memory than one answer.
class HttpServer {
 public:
  // Answers a request; nothing where the answer is to wait for Wake(), which is asked for again
  // then, or when no more time is left (`must`).
  using Handler = std::function<std::optional<HttpAnswer>(const HttpRequest& request, bool must)>;

  // Its thread has less priority than who makes it, until TakePriority(). Port 0: any that is free.
  // Throws InputError naming address and port if they cannot be had.
  HttpServer(const std::string& address, int port, const HttpLimits& limits, Handler handler);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::string address() const;
  int port() const;
  // Any thread may call it.
  void Wake();
  // From now on its thread has the priority of who calls this, if there can be another thread.
  void TakePriority();

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace surfit
