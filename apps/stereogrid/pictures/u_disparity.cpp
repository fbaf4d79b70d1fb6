// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "pictures/drawing.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid::app {
namespace {

constexpr double tick_px{5};

/// Row of the canvas at a disparity.
double row_of(const Box& box, double disparity, int disparities) {
  return box.y + (disparity + 0.5) * box.height / disparities;
}

void draw_disparity_axis(Canvas& canvas, const Box& box, int disparities) {
  const int step{disparities > 100 ? 20 : 10};
  const Colour ink{palette().ink};
  for (int d{0}; d < disparities; d += step) {
    const double y{row_of(box, d, disparities)};
    canvas.line({{box.x - tick_px, y}, {double(box.x), y}}, {ink});
    canvas.text({box.x - tick_px - 3, y + 5}, fmt::format("{}", d), {.colour = ink, .align = Align::right});
  }
  canvas.text({box.x - 42.0, box.y + box.height / 2.0}, "disparity (px)",
              {.colour = ink, .align = Align::centre, .upwards = true});
}

void draw_depth_axis(Canvas& canvas, const Box& box, int disparities, const Rig& rig) {
  const double x{double(box.x) + box.width};
  const Colour ink{palette().ink};
  double lowest_free{double(box.y) + box.height + text_px};
  for (const double depth_m : {1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0, 40.0, 80.0}) {
    const double y{row_of(box, rig.focal_px * rig.baseline_m / depth_m, disparities)};
    if (y > box.y + box.height || y + 5 > lowest_free) continue;
    canvas.line({{x, y}, {x + tick_px, y}}, {ink});
    canvas.text({x + tick_px + 3, y + 5}, fmt::format("{:g}", depth_m), {.colour = ink});
    lowest_free = y - 10;
  }
  canvas.text({x + 48.0, box.y + box.height / 2.0}, "distance (m)",
              {.colour = ink, .align = Align::centre, .upwards = true});
}

}  // namespace

void draw_u_disparity(Canvas& canvas, const Box& box, const CameraImage& image) {
  const Image<float>& occupancy{image.stages.occupancy_smooth};
  canvas.image(box, occupancy_colours(occupancy), false);
  frame_box(canvas, box);
  draw_disparity_axis(canvas, box, occupancy.height());
  draw_depth_axis(canvas, box, occupancy.height(), image.seen.rig);
}

std::vector<std::uint8_t> u_disparity_jpeg(const CameraImage& image) {
  constexpr int quality{90};
  cv::Mat colours{occupancy_colours(image.stages.occupancy_smooth)};
  cv::cvtColor(colours, colours, cv::COLOR_RGB2BGR);
  return io::encode_jpeg(view_of(colours), quality);
}

}  // namespace stereogrid::app
