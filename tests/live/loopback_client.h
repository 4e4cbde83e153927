#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <utility>

namespace surfit {

struct ReceivedAnswer {
  int status = 0;  // 0: the server closed the connection
  std::string head, body;
};

// A connection to a local port that sends arbitrary bytes.
class LoopbackClient {
 public:
  explicit LoopbackClient(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_connected_ =
        connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~LoopbackClient() {
    if (socket_ >= 0) close(socket_);
  }
  LoopbackClient(LoopbackClient&& other) noexcept
      : socket_(std::exchange(other.socket_, -1)), is_connected_(other.is_connected_) {}
  LoopbackClient& operator=(LoopbackClient&&) = delete;

  bool is_connected() const { return is_connected_; }

  bool Send(const std::string& bytes) {
    return send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(bytes.size());
  }

  // Receives one answer. Waits for at most `patience_s`.
  ReceivedAnswer Receive(double patience_s = 10) {
    ReceivedAnswer answer;
    std::size_t end = std::string::npos;
    while ((end = received_.find("\r\n\r\n")) == std::string::npos) {
      if (!ReceiveMore(patience_s)) return answer;
    }
    answer.head = received_.substr(0, end + 2);
    received_.erase(0, end + 4);
    answer.status = std::atoi(answer.head.substr(answer.head.find(' ')).c_str());
    const std::string kLength = "Content-Length: ";
    const std::size_t at = answer.head.find(kLength);
    const std::size_t length =
        at == std::string::npos ? 0 : std::strtoul(&answer.head[at + kLength.size()], nullptr, 10);
    while (received_.size() < length) {
      if (!ReceiveMore(patience_s)) return answer;
    }
    answer.body = received_.substr(0, length);
    received_.erase(0, length);
    return answer;
  }

  ReceivedAnswer Ask(const std::string& bytes) {
    Send(bytes);
    return Receive();
  }

  // True if the server closes the connection within this time.
  bool IsClosedWithin(double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      if (!ReceiveMore(0.05) && is_over_) return true;
    }
    return false;
  }

 private:
  bool ReceiveMore(double patience_s) {
    pollfd waits = {socket_, POLLIN, 0};
    if (poll(&waits, 1, static_cast<int>(1000 * patience_s)) <= 0) return false;
    char bytes[65536];
    const ssize_t count = recv(socket_, bytes, sizeof(bytes), 0);
    is_over_ = count <= 0;
    if (count > 0) received_.append(bytes, static_cast<std::size_t>(count));
    return count > 0;
  }

  int socket_;
  bool is_connected_ = false, is_over_ = false;
  std::string received_;
};

}  // namespace surfit
