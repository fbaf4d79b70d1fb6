// SPDX-License-Identifier: Apache-2.0
#include "net/network.hpp"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <utility>
#include <vector>

#include "net/http_session.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::server {
namespace {

constexpr std::chrono::milliseconds farewell{1000};
constexpr std::chrono::milliseconds pause{100};  // wait when no more connections can be opened

net::ip::address parsed_address(const std::string& text) {
  Error error;
  const auto address{net::ip::make_address(text == "localhost" ? "127.0.0.1" : text, error)};
  if (error) {
    throw ConfigError{"'" + text +
                      "' is not an address to listen on: give one of this machine, such as 127.0.0.1, or "
                      "0.0.0.0 for all of them."};
  }
  return address;
}

std::string url_form(const net::ip::address& address) {
  return address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
}

[[noreturn]] void fail(const Error& error, const Tcp::endpoint& where) {
  const std::string port{std::to_string(where.port())};
  const std::string address{url_form(where.address())};
  if (error == net::error::address_in_use) {
    throw DeviceError{"Port " + port + " of " + address +
                      " is taken: end the program that has it, or choose another port "
                      "(0: any free one)."};
  }
  if (error == net::error::access_denied) {
    throw DeviceError{"Port " + port + " may not be used by this user: choose one above 1023."};
  }
  if (error == boost::system::errc::address_not_available) {
    throw ConfigError{address +
                      " is not an address of this machine: give one that it has, or 0.0.0.0 for all of them."};
  }
  throw DeviceError{"Cannot listen on " + address + ":" + port + ": " + error.message() + "."};
}

/// Says so to whom there is no room for.
void turn_away(Tcp::socket& socket) {
  static constexpr char words[]{
      "HTTP/1.1 503 Service Unavailable\r\nContent-Type: text/plain\r\nContent-Length: 22\r\nConnection: close\r\n\r\n"
      "Too many connections.\n"};
  Error ignored;
  socket.non_blocking(true, ignored);
  socket.write_some(net::buffer(words, sizeof words - 1), ignored);
}

}  // namespace

struct Network::State {
  explicit State(const Tcp::endpoint& where) : acceptor{io}, work{io.get_executor()}, pause_timer{io}, deadline{io} {
    Error error;
    acceptor.open(where.protocol(), error);
    if (!error) acceptor.set_option(net::socket_base::reuse_address(true), error);
    if (!error) acceptor.bind(where, error);
    if (!error) acceptor.listen(net::socket_base::max_listen_connections, error);
    if (error) fail(error, where);
  }

  void accept() {
    acceptor.async_accept([this](Error error, Tcp::socket socket) {
      if (!acceptor.is_open()) return;
      if (error) return accept_later();
      admit(std::move(socket));
      accept();
    });
  }

  /// Most likely there are no descriptors left; to try at once would keep the processor busy.
  void accept_later() {
    pause_timer.expires_after(pause);
    pause_timer.async_wait([this](Error error) {
      if (!error && acceptor.is_open()) accept();
    });
  }

  void admit(Tcp::socket socket) {
    Error ignored;
    if (!make_room(socket.remote_endpoint(ignored).address())) {
      ++around->counters.refused;
      return turn_away(socket);
    }
    socket.set_option(Tcp::no_delay(true), ignored);
    std::make_shared<HttpSession>(std::move(socket), *around)->read();
  }

  /// Ends the connection without progress for longest where there are too many: of this address, or at all. False: none
  /// can be ended, all are WebSockets.
  bool make_room(const net::ip::address& address) {
    std::size_t of_address{0};
    for (const Session* const session : around->sessions) of_address += session->address() == address ? 1 : 0;
    const bool address_is_full{of_address >= around->limits.connections_per_address};
    if (!address_is_full && around->sessions.size() < around->limits.connections) return true;
    Session* oldest{nullptr};
    for (Session* const session : around->sessions) {
      if (!session->progress() || (address_is_full && session->address() != address)) continue;
      if (oldest == nullptr || *session->progress() < *oldest->progress()) oldest = session;
    }
    if (oldest == nullptr) return false;
    ++around->counters.refused;
    oldest->cut();
    return true;
  }

  void say_goodbye() {
    Error ignored;
    acceptor.close(ignored);
    pause_timer.cancel();
    work.reset();
    if (around->sessions.empty()) return;
    deadline.expires_after(farewell);
    deadline.async_wait([this](Error error) {
      if (!error) for_each_session(&Session::cut);
    });
    around->emptied = [this] { deadline.cancel(); };
    for_each_session(&Session::stop);
  }

  void for_each_session(void (Session::*what)()) {
    std::vector<std::shared_ptr<Session>> sessions;  // copied, since the calls may end some
    for (Session* const session : around->sessions) sessions.push_back(session->shared_from_this());
    for (const auto& session : sessions) (*session.*what)();
  }

  std::unique_ptr<Surroundings> around;  // sessions refer to it until the last
  net::io_context io{1};
  Tcp::acceptor acceptor;
  net::executor_work_guard<net::io_context::executor_type> work;
  net::steady_timer pause_timer;
  net::steady_timer deadline;
};

Network::Network(const std::string& address, std::uint16_t port)
    : state_{std::make_unique<State>(Tcp::endpoint{parsed_address(address), port})} {}

Network::~Network() = default;

std::uint16_t Network::port() const {
  return state_->acceptor.local_endpoint().port();
}

bool Network::loopback() const {
  return state_->acceptor.local_endpoint().address().is_loopback();
}

std::string Network::address() const {
  return url_form(state_->acceptor.local_endpoint().address());
}

void Network::run(Hub& hub, const Site& site, const Limits& limits, Counters& counters) {
  state_->around = std::make_unique<Surroundings>(Surroundings{hub, site, limits, counters});
  state_->accept();
  state_->io.run();
}

void Network::post(std::function<void()> work) {
  net::post(state_->io, std::move(work));
}

void Network::stop() {
  post([this] { state_->say_goodbye(); });
}

}  // namespace stereogrid::server
