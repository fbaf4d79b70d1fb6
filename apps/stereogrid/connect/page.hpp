// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/server/http.hpp"
#include "stereogrid/server/server.hpp"

namespace stereogrid::app {

class Command;

/// Address and port of a server.
struct ListenAddress {
  std::string address{"127.0.0.1"};
  std::uint16_t port{8765};  ///< 0: any free one
};

/// Parses "ADDRESS:PORT" ("127.0.0.1:8765", "[::1]:8765") or ":PORT" (loopback). Throws ConfigError.
[[nodiscard]] ListenAddress listen_address_of(const std::string& text);

/// Address and access rights of a server, as set by the user.
struct PageOptions {
  std::string listen{"127.0.0.1:8765"};  ///< listen_address_of()
  std::vector<std::string> allowed_origins;
};

void add_page_options(Command command, PageOptions& options);

/// Starts a server of the viewer's page at that address. Throws ConfigError, DeviceError.
[[nodiscard]] std::unique_ptr<server::Server> start_server(const PageOptions& options, server::ServerOptions made);

/// The page, the messages it shows, /metrics for Prometheus and /healthz. Functions may be called from any thread.
class Page {
 public:
  /// `name`: for the page to show. Throws ConfigError, DeviceError.
  Page(const PageOptions& options, std::string name, server::Parameters parameters = {});
  ~Page();

  [[nodiscard]] server::Server& server();

  /// After each frame, for /metrics and /healthz.
  void note(const FrameResult& result, const messages::FrameFacts& facts);
  /// Sets the fault shown by /healthz and sent to all viewers on a change; "": none.
  void set_fault(const std::string& sentence);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Files that the build embeds into the program.

/// The page of viewer/; its front page is "/".
[[nodiscard]] std::vector<server::Asset> viewer_assets();
/// Scripts for shells: /bash.sh and so on (packaging/completion).
[[nodiscard]] std::vector<server::Asset> completion_scripts();

/// Replaces each `what` in `text`.
void replace_all(std::string& text, std::string_view what, std::string_view by);
/// `json` for a script element of a page: it can neither end that element nor begin another.
[[nodiscard]] std::string embedded_json(std::string json);

/// Parts of the report that `evaluate --html` writes; page.html has placeholders.
[[nodiscard]] std::vector<server::Asset> report_assets();

}  // namespace stereogrid::app
