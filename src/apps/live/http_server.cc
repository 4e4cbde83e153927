#include "apps/live/http_server.h"

#include <sched.h>
#include <sys/resource.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <cstdint>
#include <future>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include "surfit/core/error.h"

namespace surfit {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using boost::system::error_code;

// Lowers the priority of the calling thread only (Linux). Nice 15: about 1/30 of a busy core.
// SCHED_BATCH: does not preempt other threads.
void LowerThreadPriority() {
  constexpr int kThisThread = 0, kLessPriority = 15;
  const sched_param no_priority = {};
  setpriority(PRIO_PROCESS, kThisThread, kLessPriority);
  sched_setscheduler(kThisThread, SCHED_BATCH, &no_priority);
}

std::chrono::steady_clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(seconds));
}

}  // namespace

class HttpSession;

// Only the server thread uses these members, except `io`.
struct HttpServer::State {
  State(const HttpLimits& of_clients, Handler of_requests)
      : limits(of_clients), handler(std::move(of_requests)) {}

  void Accept();
  void Add(tcp::socket socket);
  void WakeAll();
  void Run();
  std::vector<std::shared_ptr<HttpSession>> Open() const;  // oldest first

  HttpLimits limits;
  Handler handler;
  // Declared before `io`, because the sessions in `io` are destroyed first.
  std::map<std::uint64_t, std::weak_ptr<HttpSession>> sessions;
  std::uint64_t next_session = 0;
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  asio::steady_timer pause{io};  // delay after a failed accept
  std::thread thread;
};

class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(tcp::socket socket, std::uint64_t id, HttpServer::State* server)
      : stream_(std::move(socket)), id_(id), server_(*server), hold_(server->io) {}
  ~HttpSession() { server_.sessions.erase(id_); }
  HttpSession(const HttpSession&) = delete;
  HttpSession& operator=(const HttpSession&) = delete;

  bool is_unauthenticated() const { return !knows_token_ && !is_closed_; }
  bool is_client() const { return knows_token_ && !is_closed_; }

  void Read() {
    const HttpLimits& limits = server_.limits;
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(limits.header_bytes));
    parser_->body_limit(limits.body_bytes);
    stream_.expires_after(Seconds(knows_token_ ? limits.idle_s : limits.request_s));
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](error_code error, std::size_t) { self->TakeRequest(error); });
  }

  void Wake() {
    if (waits_) Ask(/*must=*/false);
  }

  void Close() {
    is_closed_ = true;
    hold_.cancel();
    stream_.close();
  }

 private:
  void TakeRequest(error_code error) {
    if (error == http::error::header_limit)
      return Refuse(http::status::request_header_fields_too_large);
    if (error == http::error::body_limit) return Refuse(http::status::payload_too_large);
    const bool ends = error == http::error::end_of_stream || error == http::error::partial_message;
    const bool is_http = error.category() == make_error_code(http::error::bad_method).category();
    if (error && (ends || !is_http)) return Close();
    if (error) return Refuse(http::status::bad_request);
    const auto& message = parser_->get();
    const auto text = [](beast::string_view view) { return std::string(view.data(), view.size()); };
    request_ = {text(message.method_string()), text(message.target()),
                text(message[http::field::host]), std::nullopt};
    if (message.count(http::field::origin) > 0) {
      request_.origin = text(message[http::field::origin]);
    }
    if (message.count(http::field::host) != 1) return Refuse(http::status::bad_request);
    keeps_alive_ = message.keep_alive();
    stream_.expires_never();
    hold_.expires_after(Seconds(server_.limits.hold_s));
    hold_.async_wait([self = shared_from_this()](error_code stopped) {
      if (!stopped && self->waits_) self->Ask(/*must=*/true);
    });
    Ask(/*must=*/false);
  }

  void Ask(bool must) {
    std::optional<HttpAnswer> answer = server_.handler(request_, must);
    waits_ = !answer;
    if (waits_) return;
    hold_.cancel();
    const bool is_new = answer->has_token && !knows_token_;
    if (is_new && IsFull()) return Refuse(http::status::service_unavailable);
    knows_token_ = knows_token_ || answer->has_token;
    Write(static_cast<http::status>(answer->status), answer->type, answer->body);
  }

  bool IsFull() const {
    std::size_t clients = 0;
    for (const auto& session : server_.Open()) clients += session->is_client() ? 1 : 0;
    return clients >= server_.limits.clients;
  }

  void Refuse(http::status status) {
    keeps_alive_ = false;
    Write(status, "text/plain; charset=utf-8", nullptr);
  }

  // Sends the response. Its headers forbid caching, embedding in other pages, and access by other
  // origins.
  void Write(http::status status, const std::string& type,
             std::shared_ptr<const std::string> body) {
    const bool has_body = status != http::status::no_content;
    const auto reason = has_body ? http::obsolete_reason(status) : beast::string_view();
    body_ = body ? std::move(body) : std::make_shared<std::string>(reason.data(), reason.size());
    response_ = {};
    response_.result(status);
    response_.version(11);
    response_.keep_alive(keeps_alive_);
    response_.set(http::field::content_type, type);
    response_.set(http::field::cache_control, "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("X-Frame-Options", "DENY");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("Cross-Origin-Resource-Policy", "same-origin");
    response_.body() = {body_->data(), body_->size()};
    response_.prepare_payload();
    stream_.expires_after(Seconds(server_.limits.write_s));
    http::async_write(stream_, response_,
                      [self = shared_from_this()](error_code error, std::size_t) {
                        self->body_.reset();
                        if (error || !self->keeps_alive_) return self->End();
                        self->Read();
                      });
  }

  void End() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    Close();
  }

  beast::tcp_stream stream_;
  const std::uint64_t id_;
  HttpServer::State& server_;
  asio::steady_timer hold_;
  beast::flat_buffer buffer_{16384};
  std::optional<http::request_parser<http::string_body>> parser_;
  HttpRequest request_;
  http::response<http::span_body<const char>> response_;
  std::shared_ptr<const std::string> body_;
  bool knows_token_ = false, keeps_alive_ = false, waits_ = false, is_closed_ = false;
};

std::vector<std::shared_ptr<HttpSession>> HttpServer::State::Open() const {
  std::vector<std::shared_ptr<HttpSession>> open;
  for (const auto& [id, session] : sessions) {
    if (auto alive = session.lock()) open.push_back(std::move(alive));
  }
  return open;
}

void HttpServer::State::Accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      Add(std::move(socket));
      return Accept();
    }
    pause.expires_after(std::chrono::milliseconds(100));  // file descriptors may be free again
    pause.async_wait([this](error_code stopped) {
      if (!stopped) Accept();
    });
  });
}

void HttpServer::State::Add(tcp::socket socket) {
  std::vector<std::shared_ptr<HttpSession>> strangers;
  for (auto& session : Open()) {
    if (session->is_unauthenticated()) strangers.push_back(std::move(session));
  }
  if (strangers.size() >= limits.strangers) strangers.front()->Close();
  const std::uint64_t id = next_session++;
  const auto session = std::make_shared<HttpSession>(std::move(socket), id, this);
  sessions[id] = session;
  session->Read();
}

void HttpServer::State::WakeAll() {
  for (const auto& session : Open()) session->Wake();
}

// Runs the event loop until the server stops. After an exception, for example std::bad_alloc, the
// loop continues for the other connections.
void HttpServer::State::Run() {
  for (bool is_over = false; !is_over;) {
    try {
      io.run();
      is_over = true;
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): the loop continues
    }
  }
}

HttpServer::HttpServer(const std::string& address, int port, const HttpLimits& limits,
                       Handler handler)
    : state_(std::make_unique<State>(limits, std::move(handler))) {
  error_code error;
  const auto ip = asio::ip::make_address(address, error);
  if (error) throw InputError(Concat("address '", address, "' is invalid, must be an IP address"));
  tcp::acceptor& acceptor = state_->acceptor;
  const tcp::endpoint endpoint(ip, static_cast<std::uint16_t>(port));
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    throw InputError(
        Concat("port ", port, " of ", address, " cannot be opened: ", error.message()));
  }
  state_->Accept();
  state_->thread = std::thread([this] {
    LowerThreadPriority();
    state_->Run();
  });
}

HttpServer::~HttpServer() {
  state_->io.stop();
  state_->thread.join();
}

std::string HttpServer::address() const {
  return state_->acceptor.local_endpoint().address().to_string();
}

int HttpServer::port() const { return state_->acceptor.local_endpoint().port(); }

void HttpServer::Wake() {
  asio::post(state_->io, [state = state_.get()] { state->WakeAll(); });
}

// A thread cannot raise its own priority, so a new server thread replaces the old one.
void HttpServer::TakePriority() {
  std::promise<void> handed_over;
  std::thread other;
  try {
    other = std::thread([this, begins = handed_over.get_future()] {
      begins.wait();
      state_->Run();
    });
  } catch (const std::exception&) {
    return;
  }
  state_->io.stop();
  state_->thread.join();
  state_->io.restart();
  state_->thread = std::move(other);
  handed_over.set_value();
}

}  // namespace surfit
