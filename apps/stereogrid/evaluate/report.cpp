// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "connect/page.hpp"
#include "evaluate/figures.hpp"
#include "evaluate/output.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"

namespace stereogrid::app {
namespace {

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (std::size_t at{text.find(what)}; at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
}

std::string text_of(const std::vector<server::Asset>& assets, std::string_view path) {
  return std::ranges::find(assets, path, &server::Asset::path)->bytes;
}

}  // namespace

void write_report(const std::filesystem::path& path, const nlohmann::ordered_json& evaluation) {
  nlohmann::ordered_json with_titles(evaluation);
  with_titles["figures"] = {{"motion", declarations_of(motion_figures)},
                            {"things", declarations_of(thing_figures)},
                            {"tracking", declarations_of(tracking_figures)},
                            {"errors", declarations_of(error_figures)}};
  std::string data{io::json_text(with_titles)};
  replace_all(data, "<", "\\u003c");  // a name must neither end the script element nor begin another
  const auto viewer{viewer_assets()};
  const auto report{report_assets()};
  std::string page{text_of(report, "/page.html")};
  replace_all(page, "@STYLE@", text_of(viewer, "/theme.css") + text_of(report, "/page.css"));
  // one module, so that it needs no imports
  replace_all(page, "@SCRIPT@",
              text_of(viewer, "/plot.js") + text_of(report, "/charts.js") + text_of(report, "/page.js"));
  replace_all(page, "@DATA@", data);
  io::write_file(path, page);
}

}  // namespace stereogrid::app
