// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "evaluate/output.hpp"
#include "evaluate/report/parts.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"

namespace stereogrid::app {
namespace {

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (std::size_t at{text.find(what)}; at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
}

}  // namespace

void write_report(const std::filesystem::path& path, const nlohmann::ordered_json& evaluation) {
  std::string data{io::json_text(evaluation)};
  replace_all(data, "</", "<\\/");  // a name must not end the script element
  std::string page{report::page_html};
  replace_all(page, "@STYLE@", report::page_css);
  replace_all(page, "@CHARTS@", report::charts_js);
  replace_all(page, "@PAGE@", report::page_js);
  replace_all(page, "@DATA@", data);
  io::write_file(path, page);
}

}  // namespace stereogrid::app
