// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace stereogrid {
namespace {

// Limits for any camera: beyond them the sums of the stages overflow.
constexpr double focal_min_px{1};
constexpr double focal_max_px{1e6};
constexpr double baseline_min_m{1e-4};
constexpr double baseline_max_m{10};
constexpr double centimetres_max{100};  // as a baseline of 1 m in cm
constexpr double height_min_m{0.01};
constexpr double height_max_m{100};
constexpr double angle_max_rad{0.7853981633974483};
constexpr double right_angle_rad{1.5707963267948966};
constexpr double yaw_max_rad{4 * right_angle_rad};
constexpr double place_max_m{100};  // from the vehicle's origin, along either axis

// Usual values of vehicles. A lens is unusual by its field of view, but not if its focal length is common.
constexpr double usual_baseline_min_m{0.01};
constexpr double usual_baseline_max_m{3};
constexpr double usual_height_min_m{0.1};
constexpr double usual_height_max_m{6};
constexpr double usual_focal_min_px{100};
constexpr double usual_focal_max_px{10000};
constexpr double focal_min_widths{0.1};
constexpr double focal_max_widths{20};

std::string text_of(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", number);
  return text.data();
}

// Sentences about a rig.
class Findings {
 public:
  void add_if(bool wrong, const char* what, double number, const char* rest) {
    if (wrong) found_.push_back(what + text_of(number) + rest);
  }
  void add_if(bool wrong, std::string sentence) {
    if (wrong) found_.push_back(std::move(sentence));
  }
  [[nodiscard]] std::vector<std::string> take() { return std::move(found_); }

 private:
  std::vector<std::string> found_;
};

bool is_finite(const Rig& rig) {
  const std::array<double, 10> numbers{
      rig.focal_px,         rig.cx_px,           rig.cy_px,      rig.baseline_m, rig.camera_height_m,
      rig.camera_pitch_rad, rig.camera_roll_rad, rig.camera_x_m, rig.camera_y_m, rig.camera_yaw_rad};
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

// A pixel extends by half its size beyond its centre. 0: the size is unknown.
bool is_outside(double centre_px, int size_px) {
  return size_px != 0 && (centre_px < -0.5 || centre_px > size_px - 0.5);
}

void look_at_baseline(double baseline_m, Findings& found) {
  const char* const what{"The baseline is "};
  found.add_if(baseline_m == 0,
               "The baseline is zero: the two cameras are the same one; baseline_m has to be positive.");
  found.add_if(baseline_m < 0, "The baseline is negative: left and right are swapped.");
  found.add_if(baseline_m > baseline_max_m, what, baseline_m,
               baseline_m > centimetres_max
                   ? " m, which looks like millimetres: divide by 1000."
                   : " m, which looks like centimetres or millimetres: divide by 100 or 1000.");
  found.add_if(baseline_m > 0 && baseline_m < baseline_min_m, what, baseline_m,
               " m, less than a tenth of a millimetre: it is to be given in metres.");
}

void look_at_height(double height_m, Findings& found) {
  const char* const what{"The camera height is "};
  found.add_if(height_m < height_min_m, what, height_m, " m; it has to be above the ground, by a centimetre at least.");
  found.add_if(height_m > height_max_m, what, height_m,
               " m, which looks like centimetres or millimetres: it is to be given in metres.");
}

}  // namespace

std::vector<std::string> problems(const Rig& rig) {
  Findings found;
  found.add_if(rig.width_px < 0 || rig.height_px < 0, "The image size is negative.");
  found.add_if(!is_finite(rig), "A number is not finite.");
  if (!is_finite(rig)) return found.take();
  found.add_if(rig.focal_px <= 0, "The focal length is ", rig.focal_px, " px; focal_px has to be positive.");
  found.add_if(rig.focal_px > 0 && rig.focal_px < focal_min_px, "The focal length is ", rig.focal_px,
               " px, less than a pixel: it is to be given in pixels, not in metres or millimetres.");
  found.add_if(rig.focal_px > focal_max_px, "The focal length is ", rig.focal_px, " px, more than any lens has.");
  look_at_baseline(rig.baseline_m, found);
  found.add_if(is_outside(rig.cx_px, rig.width_px) || is_outside(rig.cy_px, rig.height_px),
               "The principal point (" + text_of(rig.cx_px) + ", " + text_of(rig.cy_px) + ") lies outside the image.");
  look_at_height(rig.camera_height_m, found);
  const double pitch_rad{std::abs(rig.camera_pitch_rad)};
  found.add_if(pitch_rad > right_angle_rad, "The camera pitch is ", rig.camera_pitch_rad,
               " rad, over 90°: is it in degrees?");
  found.add_if(pitch_rad > angle_max_rad && pitch_rad <= right_angle_rad, "The camera pitch is ", rig.camera_pitch_rad,
               " rad, over 45°, which is not supported: mount the camera flatter.");
  found.add_if(std::abs(rig.camera_roll_rad) > angle_max_rad, "The camera roll is ", rig.camera_roll_rad,
               " rad, over 45°: is it in degrees?");
  for (const double place_m : {rig.camera_x_m, rig.camera_y_m}) {
    found.add_if(std::abs(place_m) > place_max_m, "The camera is ", place_m,
                 " m from the vehicle's origin: it is to be given in metres.");
  }
  found.add_if(std::abs(rig.camera_yaw_rad) > yaw_max_rad, "The camera yaw is ", rig.camera_yaw_rad,
               " rad, over 360°: is it in degrees?");
  return found.take();
}

std::vector<std::string> oddities(const Rig& rig) {
  Findings found;
  const double focal_px{rig.focal_px};
  found.add_if(focal_px < usual_focal_min_px && (rig.width_px == 0 || focal_px < focal_min_widths * rig.width_px),
               "The focal length is ", focal_px, " px, which is little: is it in millimetres?");
  found.add_if(focal_px > usual_focal_max_px && (rig.width_px == 0 || focal_px > focal_max_widths * rig.width_px),
               "The focal length is ", focal_px, " px, which is much: is it of other images?");
  found.add_if(rig.baseline_m < usual_baseline_min_m || rig.baseline_m > usual_baseline_max_m, "The baseline is ",
               rig.baseline_m, " m, which hardly any stereo camera has: is it in metres?");
  found.add_if(rig.camera_height_m < usual_height_min_m || rig.camera_height_m > usual_height_max_m,
               "The camera height is ", rig.camera_height_m, " m, which hardly any vehicle has: is it in metres?");
  return found.take();
}

}  // namespace stereogrid
