#ifdef CARILLON_LIBLO
#include <lo/lo.h>
#endif

#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <thread>

#include "cli/play/devices.hpp"
#include "cli/play/interrupt.hpp"
#include "core/error.hpp"

namespace carillon::cli::play {

#ifdef CARILLON_LIBLO

namespace {

using scene::live::Request;

/// The arguments of a message, taken one after the other.
class Arguments {
 public:
  explicit Arguments(lo_message message)
      : types_(lo_message_get_types(message)), values_(lo_message_get_argv(message)) {}

  bool done() const { return types_[next_] == '\0'; }
  /// A name, or a number as text.
  std::string name() {
    if (types_[next_] == 's') return &values_[next_++]->s;
    return std::to_string(static_cast<long>(number()));
  }
  double number() {
    const std::size_t i = next_++;
    switch (types_[i]) {
      case 'i':
        return values_[i]->i;
      case 'h':
        return static_cast<double>(values_[i]->h);
      case 'f':
        return static_cast<double>(values_[i]->f);
      case 'd':
        return values_[i]->d;
      default:
        throw core::InputError("an argument is missing or is no number");
    }
  }
  bool word(const char* text) {
    if (types_[next_] != 's' || std::strcmp(&values_[next_]->s, text) != 0) return false;
    ++next_;
    return true;
  }

 private:
  const char* types_;
  lo_arg** values_;
  std::size_t next_ = 0;
};

/// @throws InputError  an address or arguments that are none
Request osc_request(const std::string& address, Arguments arguments) {
  Request request;
  if (address == "/strike") {
    request.kind = Request::Kind::strike;
    request.object = arguments.name();
    if (!arguments.done()) {
      const double x = arguments.number(), y = arguments.number();
      request.position = Vec3(x, y, arguments.number());
    }
    if (!arguments.done()) request.impulse = arguments.number();
    if (!arguments.done()) request.contact = arguments.number();
  } else if (address == "/support") {
    request.kind = Request::Kind::support;
    request.object = arguments.name();
    const double number = arguments.number();
    if (!(number >= 0 && number < 1e6)) throw core::InputError("no such support");
    request.support = static_cast<int>(number);
    if (arguments.word("on")) {
      request.on = true;
    } else if (arguments.word("off")) {
      request.on = false;
    } else {
      request.stiffness = arguments.number();
      request.damping = arguments.number();
    }
  } else if (address == "/damp") {
    request.kind = Request::Kind::damp;
    request.object = arguments.name();
    request.amount = arguments.number();
  } else if (address != "/stop") {
    throw core::InputError(fmt::format("no address {}", address));
  }
  if (!arguments.done()) throw core::InputError("an argument is too much");
  return request;
}

class OscPort : public Opened {
 public:
  OscPort(const std::string& address, Apply apply) : apply_(std::move(apply)) {
    const std::size_t colon = address.rfind(':');
    const std::string host = colon == std::string::npos ? "127.0.0.1" : address.substr(0, colon);
    const std::string port = colon == std::string::npos ? address : address.substr(colon + 1);
    addrinfo hints{};
    hints.ai_socktype = SOCK_DGRAM;
    hints.ai_flags = AI_NUMERICSERV;
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) {
      throw core::InputError(fmt::format("--osc {}: no such address", address),
                             "write PORT, or HOST:PORT with a host of this machine");
    }
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owned(found, ::freeaddrinfo);
    socket_ = ::socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket_ < 0 || ::bind(socket_, found->ai_addr, found->ai_addrlen) != 0) {
      const std::string why = std::strerror(errno);
      if (socket_ >= 0) ::close(socket_);
      throw core::InputError(fmt::format("--osc {}: cannot listen: {}", address, why),
                             "choose another port");
    }
    thread_ = thread_without_signals([this] { listen(); });
  }
  ~OscPort() override {
    leave_ = true;
    thread_.join();
    ::close(socket_);
  }
  OscPort(const OscPort&) = delete;
  OscPort& operator=(const OscPort&) = delete;

 private:
  void listen() {
    std::array<char, 65536> packet{};
    while (!leave_) {
      pollfd ready{socket_, POLLIN, 0};
      if (::poll(&ready, 1, 50) <= 0) continue;
      const ssize_t size = ::recv(socket_, packet.data(), packet.size(), 0);
      if (size >= 0) take(std::span(packet).first(static_cast<std::size_t>(size)), 0);
    }
  }

  /// A message, or a bundle of them, whose elements are done at once whatever their time.
  void take(std::span<char> packet, int depth) {
    constexpr std::size_t head = 16;  // "#bundle" and a time
    if (packet.size() < head || std::memcmp(packet.data(), "#bundle", 8) != 0) return act(packet);
    if (depth > 4) {
      ++refused;
      return;
    }
    packet = packet.subspan(head);
    while (!packet.empty()) {
      std::uint32_t size = 0;
      if (packet.size() < sizeof(size)) {
        ++refused;
        return;
      }
      std::memcpy(&size, packet.data(), sizeof(size));
      size = ntohl(size);
      packet = packet.subspan(sizeof(size));
      if (size == 0 || size % 4 != 0 || size > packet.size()) {
        ++refused;
        return;
      }
      take(packet.first(size), depth + 1);
      packet = packet.subspan(size);
    }
  }

  void act(std::span<char> packet) {
    try {
      int result = 0;
      const std::unique_ptr<void, void (*)(lo_message)> message(
          lo_message_deserialise(packet.data(), packet.size(), &result), lo_message_free);
      if (!message) throw core::InputError("malformed");
      apply_(osc_request(packet.data(), Arguments(message.get())));
    } catch (const core::Error&) {
      ++refused;
    }
  }

  Apply apply_;
  int socket_ = -1;
  std::atomic<bool> leave_ = false;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Opened> open_osc(const std::string& address, Apply apply) {
  return std::make_unique<OscPort>(address, std::move(apply));
}

#else

std::unique_ptr<Opened> open_osc(const std::string&, Apply) {
  throw core::InputError("--osc needs liblo, which was missing when this was built",
                         "install liblo-dev and build again");
}

#endif

}  // namespace carillon::cli::play
