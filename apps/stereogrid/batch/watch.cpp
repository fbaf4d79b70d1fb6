// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/watch.hpp"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "batch/status.hpp"
#include "connect/assets.hpp"
#include "connect/page.hpp"
#include "console.hpp"
#include "interrupt.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds shortest_pause{3};

/// What was found last; the server's thread asks for it.
class Latest {
 public:
  explicit Latest(std::string plan) : plan_{std::move(plan)} {}

  void set(Json status) {
    const std::scoped_lock lock{mutex_};
    status_ = std::move(status);
    fault_.clear();
    found_at_ = Clock::now();
  }
  void set_fault(std::string fault) {
    const std::scoped_lock lock{mutex_};
    fault_ = std::move(fault);
  }
  [[nodiscard]] server::Answer answer() const {
    const std::scoped_lock lock{mutex_};
    const double age_s{std::chrono::duration<double>{Clock::now() - found_at_}.count()};
    const Json json{{"plan", plan_}, {"age_s", age_s}, {"fault", fault_}, {"status", status_}};
    return {.content_type = "application/json", .body = io::json_text(json) + '\n'};
  }

 private:
  std::string plan_;
  mutable std::mutex mutex_;  // of what follows
  Json status_;
  std::string fault_;
  Clock::time_point found_at_;
};

/// Of the viewer's files: the page of a batch in front.
std::vector<server::Asset> assets() {
  std::vector<server::Asset> chosen;
  for (server::Asset& asset : viewer_assets()) {
    if (asset.path == "/batch.html")
      asset.path = "/";
    else if (asset.path != "/batch.js" && asset.path != "/style.css" && asset.path != "/theme.css")
      continue;
    chosen.push_back(std::move(asset));
  }
  return chosen;
}

/// Looking takes long where there are many shards: not all the time is for it.
void pause_after(Clock::duration took) {
  const auto end{Clock::now() + std::max<Clock::duration>(shortest_pause, 4 * took)};
  while (interrupted() == 0 && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds{50});
}

}  // namespace

void watch(const PlanReader& plan, const std::string& listen) {
  const bool is_port{listen.find(':') == std::string::npos};
  Latest latest{io::printable_path(plan.folder())};
  latest.set(to_json(status_of(plan)));
  server::ServerOptions made;
  made.name = "stereogrid batch";
  made.http.assets = assets();
  made.http.endpoints.push_back({"/status.json", [&latest] { return latest.answer(); }});
  const auto server{start_server({is_port ? ':' + listen : listen, {}, "--watch"}, std::move(made))};
  catch_interrupts();
  tell("open {}\n", server->url());
  if (!lost_output().empty()) return;  // run_program() says it
  while (interrupted() == 0) {
    const auto begin{Clock::now()};
    try {
      latest.set(to_json(status_of(plan)));
    } catch (const std::runtime_error& error) {  // InputError, or DeviceError: the disk
      latest.set_fault(error.what());
    }
    pause_after(Clock::now() - begin);
  }
}

}  // namespace stereogrid::app::batch
