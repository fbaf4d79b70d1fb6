// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "pictures/drawing.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

using testing::HasSubstr;
using testing::Not;
using Triple = std::array<double, 3>;
using Matrix = std::array<Triple, 3>;

// Machado, Oliveira, Fernandes: A Physiologically-based Model for Simulation of Color Vision Deficiency, 2009, severity
// 1
constexpr Matrix normal{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
constexpr Matrix protanopia{
    {{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}};
constexpr Matrix deuteranopia{
    {{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}};
constexpr Matrix xyz_of_white{{{0.4339, 0.3762, 0.1899}, {0.2127, 0.7152, 0.0722}, {0.0178, 0.1095, 0.8727}}};

Triple product(const Matrix& matrix, const Triple& v) {
  Triple made{};
  for (std::size_t i{0}; i < 3; ++i) made[i] = matrix[i][0] * v[0] + matrix[i][1] * v[1] + matrix[i][2] * v[2];
  return made;
}

Triple linear(Colour colour) {
  const auto channel = [](double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  return {channel(colour.red / 255.0), channel(colour.green / 255.0), channel(colour.blue / 255.0)};
}

/// CIE L*a*b* of a colour as an eye sees it.
Triple seen(Colour colour, const Matrix& eye) {
  Triple rgb{product(eye, linear(colour))};
  for (double& value : rgb) value = std::clamp(value, 0.0, 1.0);
  Triple f{product(xyz_of_white, rgb)};
  for (double& value : f) value = value > 0.008856 ? std::cbrt(value) : 7.787 * value + 16.0 / 116;
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

/// CIE 1976 difference.
double difference(Colour a, Colour b, const Matrix& eye) {
  const Triple one{seen(a, eye)};
  const Triple other{seen(b, eye)};
  return std::hypot(one[0] - other[0], one[1] - other[1], one[2] - other[2]);
}

/// Contrast by WCAG 2.
double contrast(Colour a, Colour b) {
  const auto luminance = [](Colour colour) { return product(xyz_of_white, linear(colour))[1] + 0.05; };
  const auto [low, high] = std::minmax({luminance(a), luminance(b)});
  return high / low;
}

TEST(Pictures, DirectionsDifferForColourBlindEyes) {
  constexpr int directions{72};
  constexpr double step{2 * std::numbers::pi / directions};
  for (const Matrix& eye : {normal, protanopia, deuteranopia}) {
    double opposite{1e9};
    double across{1e9};
    double aside{1e9};
    for (int i{0}; i < directions; ++i) {
      const Colour colour{colour_of_direction(i * step)};
      const auto to = [&](int by) { return difference(colour, colour_of_direction((i + by) * step), eye); };
      opposite = std::min(opposite, to(directions / 2));
      for (int by{directions / 8}; by <= directions / 2; ++by)
        (by < directions / 4 ? aside : across) = std::min(by < directions / 4 ? aside : across, to(by));
    }
    EXPECT_GT(opposite, 40);
    EXPECT_GT(across, 30);  // from 90° on
    EXPECT_GT(aside, 20);   // from 45° on
  }
}

TEST(Pictures, DirectionsAreCyclic) {
  EXPECT_EQ(colour_of_direction(0), palette().headings[0]);
  EXPECT_EQ(colour_of_direction(-1e-18), palette().headings[0]);
  EXPECT_EQ(colour_of_direction(std::numbers::pi), palette().headings[4]);
  EXPECT_EQ(colour_of_direction(-std::numbers::pi), palette().headings[4]);
  EXPECT_EQ(colour_of_direction(-std::numbers::pi / 2), palette().headings[6]);
}

TEST(Pictures, EdgesOfDropsDifferWithoutTheirColour) {
  Obstacle obstacle;
  obstacle.kind = ObstacleKind::boundary;
  const double usual{stroke_of(obstacle).width_px};
  obstacle.kind = ObstacleKind::drop;
  EXPECT_EQ(stroke_of(obstacle).width_px, 2 * usual);
  EXPECT_EQ(stroke_of(obstacle).colour, palette().drop);
}

TEST(Pictures, LettersAreLargeAndHaveContrast) {
  EXPECT_GE(text_px, 14);
  for (const Colour ground : {palette().paper, palette().card}) {
    for (const Colour letters : {palette().ink, palette().soft}) EXPECT_GE(contrast(letters, ground), 4.5);
  }
}

TEST(Letters, AreProportional) {
  EXPECT_LT(text_width("i", 100), 0.5 * text_width("m", 100));
  EXPECT_DOUBLE_EQ(text_width("mi", 100), text_width("m", 100) + text_width("i", 100));
  EXPECT_EQ(text_contours("i", 16).size(), 2U);
  EXPECT_EQ(text_contours("°−≤", 16).size(), 2U + 1U + 2U);
  EXPECT_EQ(text_contours("π", 16), text_contours("?", 16));
  EXPECT_EQ(text_contours("", 16).size(), 0U);
}

TEST(Letters, StandUpwardsToo) {
  const auto inked = [](bool upwards) {
    PixelCanvas canvas{60, 60};
    fill_box(canvas, {0, 0, 60, 60}, palette().card);
    canvas.text({30, 30}, "Il", {.colour = {0, 0, 0}, .size_px = 20, .align = Align::centre, .upwards = upwards});
    const io::RgbImage image{canvas.result()};
    std::set<int> rows;
    for (int v{0}; v < 60; ++v) {
      for (int u{0}; u < 60; ++u) {
        if (image.pixels(3 * u, v) < 128) rows.insert(v);
      }
    }
    return rows;
  };
  EXPECT_EQ(*inked(false).begin(), 15);  // capitals are 0.71 em high
  EXPECT_EQ(*inked(false).rbegin(), 29);
  EXPECT_LT(inked(true).size(), 12U);
}

class Drawn : public testing::Test {
 protected:
  Drawn() : scene{scenes::parse_scene("crossing?frames=1&width=160&height=100")} {
    Pipeline pipeline{preset("default"), scene.rig()};
    frame = scene.load(0);
    result = pipeline.process(frame);
    Obstacle obstacle;
    obstacle.id = 4711;
    obstacle.confirmed = obstacle.moving = true;
    obstacle.x_m = 8;
    obstacle.length_m = obstacle.width_m = obstacle.height_m = 1;
    obstacle.vy_mps = 2.5;
    obstacle.outline = {{7.5, -0.5}, {7.5, 0.5}, {8.5, 0.5}, {8.5, -0.5}};
    result.obstacles = {obstacle};
  }

  scenes::Scene scene;
  StereoFrame frame;
  FrameResult result;
};

TEST_F(Drawn, ObstaclesHaveTheirNumbersInBothViews) {
  const std::string svg{draw_svg(frame, result)};
  const std::string label{">4711: 2.5 m/s</text>"};
  const std::size_t first{svg.find(label)};
  ASSERT_NE(first, std::string::npos);
  EXPECT_NE(svg.find(label, first + 1), std::string::npos);
  result.obstacles[0].confirmed = false;
  EXPECT_EQ(draw_svg(frame, result).find(label), std::string::npos);
}

TEST_F(Drawn, SvgHasTheSizeOfThePixelsAndNamesItsAxes) {
  const std::string svg{draw_svg(frame, result)};
  const io::RgbImage pixels{draw_picture(frame, result)};
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 " + std::to_string(pixels.width) + ' ' + std::to_string(pixels.height)));
  for (const char* name : {"x, ahead (m)", "y, to the left (m)", "disparity (px)", "distance (m)"}) {
    EXPECT_THAT(svg, HasSubstr(std::string{'>'} + name + "</text>"));
  }
  for (const char* direction : {">ahead<", ">left<", ">back<", ">right<"}) EXPECT_THAT(svg, HasSubstr(direction));
}

// The obstacle is ahead: no line of it is in the image of the camera that faces backwards.
TEST(DrawnCameras, HaveAnImageEachAndOneGrid) {
  const scenes::Scene scene{
      scenes::parse_scene("around?cameras=2&turn_deg=180&frames=1&width=160&height=100&focal=80")};
  Config config{preset("default")};
  config.grid.rear_m = config.grid.length_m = 10;
  Pipeline pipeline{config, scene.rigs(), {.camera_names = {"front", "rear"}}};
  const StereoFrame frame{scene.load(0)};
  FrameResult result{pipeline.process(frame)};
  Obstacle obstacle;
  obstacle.id = 4711;
  obstacle.confirmed = true;
  obstacle.x_m = 6;
  obstacle.length_m = obstacle.width_m = obstacle.height_m = 1;
  result.obstacles = {obstacle};
  const std::string svg{draw_svg(frame, result)};
  for (const char* name : {">front</text>", ">rear</text>"}) EXPECT_THAT(svg, HasSubstr(name));
  EXPECT_THAT(svg, Not(HasSubstr("u-disparity")));
  const auto count_of = [&svg](const std::string& part) {
    int count{0};
    for (std::size_t at{svg.find(part)}; at != std::string::npos; at = svg.find(part, at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(count_of("<image"), 3 + 2) << "two cameras, the grid, two scales";
  EXPECT_EQ(count_of(">4711</text>"), 2) << "one camera and the grid";
  EXPECT_FALSE(annotated_jpeg(image_of(frame, result, 1)).empty());
  EXPECT_NE(annotated_jpeg(image_of(frame, result, 0)), annotated_jpeg(image_of(frame, result, 1)));
  result.cameras[1].has_images = false;
  EXPECT_EQ(image_of(frame, result, 1).frame, nullptr);
  const io::RgbImage pixels{draw_picture(frame, result)};
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 " + std::to_string(pixels.width) + ' ' + std::to_string(pixels.height)));
}

TEST_F(Drawn, ElevationIsDrawnWhereItExceedsItsNoise) {
  const auto changed = [&](float elevation_m, float sigma_m) {
    result.vehicle.occupancy(10, 10) = 0.1F;
    result.vehicle.velocity_x(10, 10) = result.vehicle.velocity_y(10, 10) = 0;
    result.elevation_m(10, 10) = 0;
    const std::string level{draw_svg(frame, result)};
    result.elevation_m(10, 10) = elevation_m;
    result.elevation_sigma_m(10, 10) = sigma_m;
    return draw_svg(frame, result) != level;
  };
  ASSERT_FALSE(result.elevation_m.empty());
  EXPECT_TRUE(changed(0.3F, 0.05F));
  EXPECT_TRUE(changed(-0.3F, 0.05F));
  EXPECT_FALSE(changed(0.3F, 0.2F));
  EXPECT_FALSE(changed(0.05F, 0.01F));
}

}  // namespace
}  // namespace stereogrid::app
