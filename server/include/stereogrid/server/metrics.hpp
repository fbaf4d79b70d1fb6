// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid::server {

/// Writes Prometheus' text format, version 0.0.4.
class STEREOGRID_EXPORT Metrics {
 public:
  static constexpr const char* content_type{"text/plain; version=0.0.4; charset=utf-8"};
  using Labels = std::vector<std::pair<std::string, std::string>>;

  /// Begins a metric that only grows (until the program starts anew), or one that goes up and down. Names are of
  /// letters, digits, '_' and ':', no digit first. Throws ConfigError: another name, or one that was there before.
  void counter(std::string_view name, std::string_view help);
  void gauge(std::string_view name, std::string_view help);

  /// A value of the metric begun last. Throws ConfigError: none was begun, or a label's name is not of letters, digits
  /// and '_', no digit first, no "__" first.
  void sample(double value, const Labels& labels = {});

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  STEREOGRID_HIDDEN void begin(std::string_view name, std::string_view help, std::string_view type);

  std::vector<std::string> names_;
  std::string text_;
};

}  // namespace stereogrid::server
