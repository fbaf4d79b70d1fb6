// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "figures/sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace stereogrid::app::figures {
namespace {

constexpr int margin_px{20};
constexpr int title_px{40};
constexpr int line_px{21};
constexpr int panel_title_px{28};
constexpr int tick_px{5};
constexpr int left_px{68};   // tick texts and the label along the edge
constexpr int right_px{54};  // tick texts
constexpr int below_px{46};
constexpr int bar_px{14};
constexpr int bar_gap_px{16};
constexpr int bar_text_px{64};
constexpr double tick_size{0.45};
constexpr double label_size{0.5};
constexpr double title_size{0.7};
constexpr double panel_title_size{0.52};

bool is_drawn(const Axis& axis) {
  return !axis.label.empty() || !axis.ticks.empty();
}

struct Margins {
  int left{0};
  int right{0};
  int below{0};
};

Margins margins_of(const Panel& panel) {
  Margins margins;
  margins.left = is_drawn(panel.y) ? left_px : 8;
  margins.right = is_drawn(panel.right) ? right_px : 10;
  if (panel.bar) margins.right += bar_gap_px + bar_px + bar_text_px;
  margins.below = (is_drawn(panel.x) ? below_px : 8) + line_px * static_cast<int>(panel.keys.size()) + 10;
  return margins;
}

cv::Size size_of(const Panel& panel) {
  const Margins margins{margins_of(panel)};
  const int width{std::max(panel.picture.cols + margins.right, text_width_px(panel.title, panel_title_size) + 20)};
  return {margins.left + width, panel_title_px + panel.picture.rows + margins.below};
}

/// Text that runs upwards; (x, y) is the middle of its base line.
void draw_text_upwards(cv::Mat& canvas, int x, int y, const std::string& text) {
  constexpr int height{20};
  const int width{text_width_px(text, label_size) + 4};
  cv::Mat flat(height, width, CV_8UC3, scalar(palette::paper));
  draw_text(flat, 2, height - 6, text, palette::ink, Align::left, label_size);
  cv::Mat upwards;
  cv::rotate(flat, upwards, cv::ROTATE_90_COUNTERCLOCKWISE);
  const cv::Rect wanted{x - height + 6, y - width / 2, height, width};
  const cv::Rect there{wanted & cv::Rect{0, 0, canvas.cols, canvas.rows}};
  upwards(there - wanted.tl()).copyTo(canvas(there));
}

void draw_x_axis(cv::Mat& canvas, const Box& box, const Axis& axis) {
  if (!is_drawn(axis)) return;
  const int y{box.y + box.height};
  for (const Tick& tick : axis.ticks) {
    const int x{box.x + along_x(axis, tick.at, box.width)};
    cv::line(canvas, {x, y}, {x, y + tick_px}, scalar(palette::ink));
    draw_text(canvas, x, y + tick_px + 14, tick.text, palette::ink, Align::centre, tick_size);
  }
  draw_text(canvas, box.x + box.width / 2, y + 38, axis.label, palette::ink, Align::centre, label_size);
}

void draw_y_axis(cv::Mat& canvas, const Box& box, const Axis& axis) {
  if (!is_drawn(axis)) return;
  for (const Tick& tick : axis.ticks) {
    const int y{box.y + along_y(axis, tick.at, box.height)};
    cv::line(canvas, {box.x - 1 - tick_px, y}, {box.x - 1, y}, scalar(palette::ink));
    draw_text(canvas, box.x - tick_px - 5, y + 5, tick.text, palette::ink, Align::right, tick_size);
  }
  draw_text_upwards(canvas, box.x - left_px + 22, box.y + box.height / 2, axis.label);
}

void draw_ticks_right(cv::Mat& canvas, const Box& box, const Axis& axis) {
  for (const Tick& tick : axis.ticks) {
    const int y{box.y + along_y(axis, tick.at, box.height)};
    cv::line(canvas, {box.x + box.width, y}, {box.x + box.width + tick_px, y}, scalar(palette::ink));
    draw_text(canvas, box.x + box.width + tick_px + 4, y + 5, tick.text, palette::ink, Align::left, tick_size);
  }
}

void draw_bar(cv::Mat& canvas, const Box& box, const ColourBar& bar) {
  for (int i{0}; i < box.height; ++i) {
    const double share{1 - (i + 0.5) / box.height};
    fill_box(canvas, {box.x, box.y + i, box.width, 1}, bar.colour(share));
  }
  frame_box(canvas, box);
  draw_ticks_right(canvas, box, bar.axis);
  draw_text_upwards(canvas, box.x + box.width + bar_text_px - 8, box.y + box.height / 2, bar.axis.label);
}

void draw_keys(cv::Mat& canvas, int x, int y, const std::vector<Key>& keys) {
  for (const Key& key : keys) {
    const Box box{x, y - 10, 12, 12};
    fill_box(canvas, box, key.colour);
    frame_box(canvas, box);
    draw_text(canvas, x + 20, y, key.text, palette::ink, Align::left, tick_size);
    y += line_px;
  }
}

void draw_panel(cv::Mat& canvas, int x, int y, const Panel& panel) {
  const Margins margins{margins_of(panel)};
  const Box box{x + margins.left, y + panel_title_px, panel.picture.cols, panel.picture.rows};
  draw_text(canvas, box.x, box.y - 10, panel.title, palette::ink, Align::left, panel_title_size);
  panel.picture.copyTo(canvas(cv::Rect{box.x, box.y, box.width, box.height}));
  if (is_drawn(panel.x) || is_drawn(panel.y)) frame_box(canvas, box);
  draw_x_axis(canvas, box, panel.x);
  draw_y_axis(canvas, box, panel.y);
  draw_ticks_right(canvas, box, panel.right);
  if (panel.bar) {
    const int bar_x{box.x + box.width + bar_gap_px + (is_drawn(panel.right) ? right_px : 0)};
    draw_bar(canvas, {bar_x, box.y, bar_px, box.height}, *panel.bar);
  }
  draw_keys(canvas, box.x, box.y + box.height + (is_drawn(panel.x) ? below_px : 8) + 12, panel.keys);
}

using Row = std::vector<Panel>;

int height_of(const Row& row) {
  int height{0};
  for (const Panel& panel : row) height = std::max(height, size_of(panel).height);
  return height;
}

/// Rows with equally many panels stand in line: where the panels of such a row begin, and the width of all.
std::vector<int> columns_of(const std::vector<Row>& rows, std::size_t panels) {
  std::vector<int> edges(panels + 1);
  for (std::size_t k{0}; k < panels; ++k) {
    int width{0};
    for (const Row& row : rows) {
      if (row.size() == panels) width = std::max(width, size_of(row[k]).width);
    }
    edges[k + 1] = edges[k] + width;
  }
  return edges;
}

}  // namespace

std::vector<Tick> round_ticks(double from, double to, int most) {
  const double low{std::min(from, to)};
  const double high{std::max(from, to)};
  std::vector<Tick> ticks;
  if (!(high > low) || most < 1) return ticks;
  double power{std::pow(10.0, std::floor(std::log10((high - low) / most)))};
  const auto fits = [&](double step) { return (high - low) / step <= most - 1 + 1e-9; };
  double step{power};
  while (!fits(step)) {
    step = fits(2 * power) ? 2 * power : fits(5 * power) ? 5 * power : 10 * power;
    power *= 10;
  }
  for (auto i{std::llround(std::ceil(low / step - 1e-9))}; static_cast<double>(i) * step <= high + 1e-9 * step; ++i) {
    const double at{static_cast<double>(i) * step};
    ticks.push_back({at, fmt::format("{:.6g}", at)});
  }
  return ticks;
}

Axis axis(std::string label, double from, double to, int most_ticks) {
  return {std::move(label), from, to, round_ticks(from, to, most_ticks)};
}

int along_x(const Axis& axis, double value, int length_px) {
  return static_cast<int>(std::lround((value - axis.from) / (axis.to - axis.from) * length_px));
}

int along_y(const Axis& axis, double value, int length_px) {
  return length_px - along_x(axis, value, length_px);
}

Sheet::Sheet(std::string title, std::vector<std::string> lines) : title_{std::move(title)}, lines_{std::move(lines)} {}

void Sheet::add_row(std::vector<Panel> panels) {
  rows_.push_back(std::move(panels));
}

io::RgbImage Sheet::draw() const {
  const int text_height{title_px + line_px * static_cast<int>(lines_.size())};
  int width{text_width_px(title_, title_size)};
  int height{margin_px + text_height};
  for (const std::string& line : lines_) width = std::max(width, text_width_px(line, label_size));
  for (const Row& row : rows_) {
    width = std::max(width, columns_of(rows_, row.size()).back());
    height += height_of(row);
  }
  width += 2 * margin_px;
  io::RgbImage image{width, height, {3 * width, height}};
  cv::Mat canvas{height, width, CV_8UC3, image.pixels.data()};
  fill_box(canvas, {0, 0, width, height}, palette::paper);
  draw_text(canvas, margin_px, margin_px + 14, title_, palette::ink, Align::left, title_size);
  for (std::size_t i{0}; i < lines_.size(); ++i) {
    const int y{margin_px + title_px + line_px * static_cast<int>(i)};
    draw_text(canvas, margin_px, y, lines_[i], palette::faint_ink, Align::left, label_size);
  }
  int y{text_height + margin_px / 2};
  for (const Row& row : rows_) {
    const std::vector<int> columns{columns_of(rows_, row.size())};
    for (std::size_t k{0}; k < row.size(); ++k) draw_panel(canvas, margin_px + columns[k], y, row[k]);
    y += height_of(row);
  }
  return image;
}

}  // namespace stereogrid::app::figures
