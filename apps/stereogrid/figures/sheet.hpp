// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pictures/drawing.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::app::figures {

struct Tick {
  double at{0};
  std::string text;
};

/// One edge of a panel: `from` lies at its left or lower end, `to` at its right or upper end; either may be larger.
struct Axis {
  std::string label;  ///< with its unit
  double from{0};
  double to{1};
  std::vector<Tick> ticks{};  ///< none, and no label: the edge is not drawn
};

/// Round numbers (1, 2 or 5 times a power of ten apart), at most `most`, within both ends.
[[nodiscard]] std::vector<Tick> round_ticks(double from, double to, int most);
/// An axis with them.
[[nodiscard]] Axis axis(std::string label, double from, double to, int most_ticks = 8);
/// Pixels from the left or upper end of an edge of `length_px` where `value` lies.
[[nodiscard]] int along_x(const Axis& axis, double value, int length_px);
[[nodiscard]] int along_y(const Axis& axis, double value, int length_px);

struct ColourBar {
  Axis axis;
  Colour (*colour)(double share){nullptr};  ///< share 0 at axis.from, 1 at axis.to
};

/// A colour and what it means.
struct Key {
  Colour colour;
  std::string text;
};

struct Panel {
  std::string title;
  cv::Mat picture;  ///< 8-bit R G B, drawn pixel by pixel
  Axis x{};
  Axis y{};
  Axis right{};  ///< a second scale of the same edge as y
  std::optional<ColourBar> bar{};
  std::vector<Key> keys{};  ///< a line each below the panel
};

/// A figure: a title, a few lines of text and rows of panels.
class Sheet {
 public:
  Sheet(std::string title, std::vector<std::string> lines);

  void add_row(std::vector<Panel> panels);
  [[nodiscard]] io::RgbImage draw() const;

 private:
  std::string title_;
  std::vector<std::string> lines_;
  std::vector<std::vector<Panel>> rows_;
};

}  // namespace stereogrid::app::figures
